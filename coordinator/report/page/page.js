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

  // What the node had before goes; parts that the reader has opened, in their order, stay open.
  function refill(node, ...content) {
    const open = [...node.querySelectorAll("details")].map((part) => part.open);
    node.replaceChildren(...content);
    [...node.querySelectorAll("details")].forEach((part, i) => { part.open = open[i] ?? part.open; });
  }

  function fillSection(name, content) {
    const section = document.getElementById(name);
    refill(section, section.querySelector("h2"), ...(content ? [content] : []));
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
    const replay = recorded ? new knap.Replay(variations, scene, () => recordingList(variations, choose)) : null;
    // While a run goes on, few of the variations are there.
    const map = variations.count > 0 && !data.live ? new knap.SuccessMap(variations, choose) : null;
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

  // What a run that goes on changes, and what it does not.
  function fillProgress(data) {
    const makers = { learning: () => knap.learning.make(data), certificates: () => knap.summary.certificates(data),
      timeline: () => (data.timeline?.rollouts?.worker?.length ? new knap.Timeline(data.timeline).node : null) };
    for (const [name, make] of Object.entries(makers)) {
      // A chart that the reader has the pointer on is left alone.
      if (!document.getElementById(name).matches(":hover")) fillSection(name, make());
    }
  }

  function fillResult(data) {
    refill(document.getElementById("result"), data.live ? knap.live.make(data) : knap.summary.make(data));
  }

  function follow(data, variations, scene, replay, shape) {
    const silent = document.getElementById("silent");
    knap.live.follow(data, (hasNewDesign) => {
      fillResult(data);
      fillProgress(data);
      if (!hasNewDesign) return;
      variations.takeReplays(data.replays);
      scene.reshape(data.theta);
      if (replay) {
        replay.refresh();
        markChosen(replay.row);
      }
      shape?.update(data);
    }, (seconds) => {
      silent.hidden = seconds < 5;
      silent.textContent = `knap has not answered for ${Math.round(seconds)} s: the run was stopped, or has ended. ` +
        "What it has learned is in its folder; the command below goes on with it.";
    });
  }

  function start() {
    const data = readData();
    const scene = new knap.Scene(data);
    const variations = new knap.Variations(data);
    const title = data.run?.scenario ?? data.run?.name ?? "run";
    document.title = `${title}: knap report`;
    document.getElementById("title").textContent = title;
    document.getElementById("asked").textContent = data.run?.description ?? "";
    fillResult(data);
    fillSection("comparison", knap.comparison.make(data));
    const replay = fillReplays(data, variations, scene);
    const shape = data.theta?.names?.length && !data.comparison ? new knap.ShapeView(data, scene) : null;
    fillSection("shape", shape?.node);
    fillProgress(data);
    fillSection("repeat", knap.summary.repeat(data));
    knap.theme.install(document.getElementById("theme"), () => {
      replay?.redraw();
      shape?.view?.redraw();
    });
    if (data.live) follow(data, variations, scene, replay, shape);
  }

  start();
})(window.knap = window.knap || {});
