// Starts the page: reads the data and fills the sections, each of which is hidden where the run has nothing for it.
(function (knap) {
  "use strict";
  const { html, table } = knap.elements;

  function readData() {
    return JSON.parse(document.getElementById("data").textContent);
  }

  // The command for one variation, made from the example that the run gives.
  function commandFor(data, row) {
    const example = (data.repeat ?? []).find((command) => /--variation[ =]\d+/.test(command));
    return example?.replace(/(--variation[ =])\d+/, `$1${row}`);
  }

  function fillSection(name, content) {
    const section = document.getElementById(name);
    if (content) section.append(content);
    section.hidden = !content;
    const link = document.querySelector(`nav a[href="#${name}"]`);
    if (link) link.hidden = !content;
  }

  // Rows of the list of recordings, worst first; a row's button shows its variation.
  function recordingList(variations, choose) {
    const verdict = (design, row) => {
      const success = variations.success(design, row);
      const mark = success === null ? "" : success ? " ✓" : " ✗";
      return `${variations.lossText(design, row)}${mark}${variations.distrust(design, row) ? " not trusted" : ""}`;
    };
    const idOf = (row) => {
      const replay = variations.replays.get(row).learned ?? variations.replays.get(row).initial;
      return html("code", { title: replay.id }, (replay.id ?? "").slice(0, 12));
    };
    const keys = variations.keys.slice(0, 4);
    const chooser = (row) => html("button",
      { type: "button", class: "choose", "data-row": row, onclick: () => choose(row) }, `variation ${row}`);
    const rows = variations.worstFirst().map((row) => [chooser(row), verdict("initial", row), verdict("learned", row),
      ...keys.map((_, k) => variations.keyText(row, k)), idOf(row)]);
    const names = keys.map(({ key }) => knap.Variations.shortName(key));
    const heads = ["", "loss, initial", "loss, learned", ...names, "id"];
    return table("Recorded variations, the learned tool's worst first", heads, rows,
      [1, 2, ...keys.map((_, k) => 3 + k)]);
  }

  function markChosen(row) {
    for (const button of document.querySelectorAll("button.choose")) {
      button.setAttribute("aria-current", Number(button.dataset.row) === row);
    }
  }

  // Keys work anywhere but where they already mean something.
  function listenToKeys(replay) {
    addEventListener("keydown", (event) => {
      if (event.altKey || event.metaKey || event.target.closest("input, select, button, summary, a")) return;
      if (event.key === " " || event.key.startsWith("Arrow")) replay.handleKey(event);
    });
  }

  function fillReplays(data, variations, scene) {
    const recorded = variations.replays.size > 0;
    const replay = recorded ? new knap.Replay(variations, scene, recordingList(variations, choose)) : null;
    const map = variations.count > 0 ? new knap.SuccessMap(variations, choose) : null;
    function show(row) {
      const command = commandFor(data, row);
      replay?.choose(row, command);
      map?.select(row, command);
      markChosen(row);
    }
    // What a reader chooses plays at once.
    function choose(row) {
      show(row);
      replay?.playback.play();
    }
    fillSection("replay", replay?.node);
    fillSection("map", map?.node);
    const first = variations.worstFirst()[0] ?? (map ? 0 : undefined);
    if (first !== undefined) show(first);
    if (replay) listenToKeys(replay);
    return replay;
  }

  function start() {
    const data = readData();
    const scene = new knap.Scene(data);
    const variations = new knap.Variations(data);
    const title = data.run?.scenario ?? data.run?.name ?? "run";
    document.title = `${title}: knap report`;
    document.getElementById("title").textContent = title;
    document.getElementById("asked").textContent = data.run?.description ?? "";
    document.getElementById("result").append(knap.summary.make(data));
    fillSection("comparison", knap.comparison.make(data));
    const replay = fillReplays(data, variations, scene);
    const shape = data.theta?.names?.length && !data.comparison ? new knap.ShapeView(data, scene) : null;
    fillSection("shape", shape?.node);
    fillSection("learning", knap.learning.make(data));
    fillSection("certificates", knap.summary.certificates(data));
    fillSection("timeline", data.timeline?.rollouts?.worker?.length ? new knap.Timeline(data.timeline).node : null);
    fillSection("repeat", knap.summary.repeat(data));
    knap.theme.install(document.getElementById("theme"), () => {
      replay?.redraw();
      shape?.view?.redraw();
    });
  }

  start();
})(window.knap = window.knap || {});
