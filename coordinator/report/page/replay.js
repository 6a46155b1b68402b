// Both designs side by side in one test variation: views that share camera and time, and plots with a time cursor.
(function (knap) {
  "use strict";
  const { html, copyButton } = knap.elements;
  const { quantity, number } = knap.quantities;

  const titles = { initial: "Initial tool", learned: "Learned tool" };
  const speeds = [0.1, 0.25, 0.5, 1, 2, 4];

  class Replay {
    // `makeList` makes what is set below the views: the choice of recordings.
    constructor(variations, scene, makeList) {
      Object.assign(this, { variations, scene, makeList });
      this.camera = new knap.Camera(scene.up);
      this.recordings = {};
      this.charts = [];
      this.playback = new knap.Playback((time) => this.show(time), (playing) => this.showPlaying(playing));
      this.panes = Object.fromEntries(knap.designs.map((design) => [design, this.makePane(design)]));
      this.plots = html("div", { class: "plots", role: "group", "aria-label": "Forces and signals over time" });
      this.notice = html("p", { class: "notice", role: "status", hidden: true });
      this.node = html("div", { class: "replay" },
        html("div", { class: "stage" }, this.notice,
          html("div", { class: "panes" }, ...knap.designs.map((design) => this.panes[design].node)),
          this.makeControls(), this.makeHint(), this.list = makeList()),
        this.plots);
    }

    makePane(design) {
      const view = new knap.View(`${titles[design]} in motion`, this.camera, (detail) => this.picture(design, detail));
      knap.attachCamera(view.canvas, this.camera, () => this.redraw(), () => this.reset());
      const outcome = html("span", { class: "outcome" });
      const origin = html("div", { class: "origin" });
      const empty = html("p", { class: "empty", hidden: true }, "No recording of this tool here");
      const node = html("figure", { class: `pane ${design}` },
        html("figcaption", null, html("strong", null, titles[design]), outcome),
        html("div", { class: "canvas" }, view.canvas, empty), origin);
      return { view, outcome, origin, empty, node };
    }

    makeControls() {
      this.button = html("button", { type: "button", class: "play", "aria-label": "Play",
        "aria-keyshortcuts": "Space", onclick: () => this.playback.toggle() }, "▶");
      this.slider = html("input", { type: "range", class: "scrub", min: 0, max: 1, step: "any", value: 0,
        "aria-label": "Time of the replay", oninput: () => this.scrub(Number(this.slider.value)) });
      this.slider.addEventListener("keydown", (event) => this.handleKey(event));
      this.clock = html("output", { class: "clock" });
      const speed = html("select", { "aria-label": "Speed", onchange: () => {
        this.playback.speed = Number(speed.value);
      } }, ...speeds.map((value) => html("option", { value, selected: value === 1 }, `${value}×`)));
      this.forces = this.makeToggle("forces", "Draw contact forces as arrows", true, () => this.redraw());
      this.paths = this.makeToggle("paths", "Draw the paths of free bodies", true, () => this.redraw());
      this.paths.node.hidden = !this.scene.bodies.some((body) => this.scene.hasPath(body));
      this.follow = this.makeToggle("follow", "Stay with the tool", false, () => this.frame());
      this.follow.node.hidden = this.scene.leader() === null;
      return html("div", { class: "controls", role: "group", "aria-label": "Replay" },
        this.button, this.slider, this.clock, speed, this.forces.node, this.paths.node, this.follow.node);
    }

    makeToggle(name, label, checked, onchange) {
      const box = html("input", { type: "checkbox", checked, "aria-label": label, onchange });
      return { box, node: html("label", { title: label }, box, ` ${name}`) };
    }

    makeHint() {
      this.scaleText = html("span");
      return html("p", { class: "hint" },
        "Drag to turn, shift and drag to move, click and wheel or pinch to zoom, double-click to reset. ",
        "Space plays, arrow keys step. ", this.scaleText);
    }

    // Shows a variation; one without recordings leaves the views empty, and the notice says how to see it.
    choose(row, command) {
      this.row = row;
      this.load();
      const [{ gravity } = {}] = Object.values(this.variations.replays.get(row) ?? {});
      this.camera.aim(gravity ? knap.matrices.unit(knap.matrices.scale(gravity, -1)) : this.scene.up);
      this.showNotice(command);
      this.frame();
      this.makeCharts();
      this.playback.restart(this.end);
    }

    // New recordings of the same variations: time, camera and whether it plays stay as they are.
    refresh() {
      this.load();
      this.makeCharts();
      this.playback.end = this.end;
      this.playback.seek(this.playback.time);
      const list = this.makeList();
      this.list.replaceWith(list);
      this.list = list;
    }

    load() {
      const replays = this.variations.replays.get(this.row) ?? {};
      this.recordings = Object.fromEntries(Object.entries(replays)
        .map(([design, replay]) => [design, new knap.Recording(replay, this.scene.movers)]));
      for (const design of knap.designs) this.describe(design);
      this.measureForces();
      this.slider.max = this.end || 1;
    }

    get end() {
      return Math.max(0, ...Object.values(this.recordings).map((recording) => recording.end));
    }

    showNotice(command) {
      this.notice.hidden = this.variations.embedded(this.row);
      this.notice.replaceChildren(`Variation ${this.row} is not recorded in this file.`);
      if (!command) return;
      const code = html("code", null, command);
      this.notice.append(" To see it: ", code, " ", copyButton(code, "Copy the command"));
    }

    describe(design) {
      const pane = this.panes[design];
      const recording = this.recordings[design];
      pane.empty.hidden = recording !== undefined;
      pane.outcome.replaceChildren(...this.outcomeOf(design));
      pane.origin.replaceChildren();
      if (!recording) return;
      const { id, loss, doubts, same_bits: same } = recording.about;
      const whole = html("code", { class: "id", title: id }, id ?? "");
      const bits = Number.isFinite(loss) && loss !== null ? `, loss bits ${knap.decoding.bitsOf(loss)}` : "";
      pane.origin.append(html("span", null, "Computed again from the run: rollout "), whole,
        copyButton(whole, `Copy the id of the ${design} rollout`), html("span", { class: "bits" }, bits));
      if (same === true) pane.origin.append(html("span", null, ", as the run had it"));
      if (same === false) {
        const text = "Not the bits that the run had: another build computes this.";
        pane.origin.append(html("p", { class: "warning" }, text));
      }
      const reason = this.variations.distrust(design, this.row);
      if (reason) pane.origin.append(html("p", { class: "warning" }, `Not trusted: ${reason}`));
      if (doubts?.length) pane.origin.append(html("p", null, `Doubts: ${doubts.join("; ")}`));
    }

    outcomeOf(design) {
      const success = this.variations.success(design, this.row);
      const verdict = success === null ? null :
        html("span", { class: success ? "success" : "failure" }, success ? "✓ success" : "✗ failure");
      return [html("span", null, this.variations.lossPhrase(design, this.row)), verdict].filter(Boolean);
    }

    // One scale for both views: the usual greatest force is as long as a third of the scene's half width.
    measureForces() {
      const sizes = Object.values(this.recordings).flatMap((recording) =>
        recording.forces.flatMap((force) => recording.forceSizes(force).filter((size) => size > 0)));
      sizes.sort((a, b) => a - b);
      this.usualForce = sizes.length ? sizes[Math.floor(0.95 * (sizes.length - 1))] : 0;
    }

    // Back to where the camera looked from at first.
    reset() {
      this.camera.turn(...knap.Camera.start);
      this.frame();
    }

    // Fills the views, from the direction that the reader has chosen.
    frame() {
      const recordings = Object.values(this.recordings);
      if (!recordings.length) {
        this.scaleText.textContent = "";
        this.redraw();
        return;
      }
      const { view } = this.panes.learned;
      const moment = this.follow.box.checked ? this.playback.time : null;
      this.led = null;
      this.camera.fit(this.scene.frame(recordings, moment), view.aspect || 4 / 3);
      // Before the page has its width, views have none; the frame is then chosen again.
      view.onResize = () => this.framedAt !== view.aspect && this.frame();
      this.framedAt = view.aspect;
      if (this.follow.box.checked) this.stayWithTool();
      this.metersPerNewton = this.usualForce > 0 ? (0.35 * this.camera.size) / this.usualForce : 0;
      this.scaleText.textContent = this.describeScale(view);
      this.redraw();
    }

    describeScale(view) {
      const hasGround = this.scene.bodies.some((body) => body.planes.length > 0);
      const grid = hasGround ? `Grid ${quantity(view.gridStep, "m", 1)}. ` : "";
      const arrow = this.usualForce > 0 ?
        `An arrow of one grid step is ${quantity(view.gridStep / this.metersPerNewton, "N", 2)}.` : "";
      return grid + arrow;
    }

    picture(design, detail) {
      const recording = this.recordings[design];
      if (!recording) return { solids: [], planes: [], lines: [], arrows: [] };
      return this.scene.pictureAt(recording, Math.min(this.playback.time, recording.end), detail, {
        showForces: this.forces.box.checked, showPaths: this.paths.box.checked,
        metersPerNewton: this.metersPerNewton, size: this.camera.size,
      });
    }

    redraw() {
      for (const { view } of Object.values(this.panes)) view.redraw();
    }

    show(time) {
      this.slider.value = time;
      this.slider.setAttribute("aria-valuetext", `${number(time)} seconds`);
      this.clock.textContent = `${time.toFixed(2)} / ${this.playback.end.toFixed(2)} s`;
      for (const chart of this.charts) chart.setCursor(time);
      if (this.follow.box.checked) this.stayWithTool();
      this.redraw();
    }

    // Moves the camera as the tool has moved since the last time: what the reader has turned and shifted stays so.
    stayWithTool() {
      const recording = this.recordings.learned ?? this.recordings.initial;
      const pose = recording?.poseAt(this.playback.time, this.scene.leader());
      if (!pose) return;
      const place = [pose[12], pose[13], pose[14]];
      if (this.led) this.camera.shift(knap.matrices.subtract(place, this.led));
      this.led = place;
    }

    showPlaying(playing) {
      this.button.textContent = playing ? "❚❚" : "▶";
      this.button.setAttribute("aria-label", playing ? "Pause" : "Play");
    }

    scrub(time) {
      this.playback.pause();
      this.playback.seek(time);
    }

    // Space and arrows, wherever the page's focus is on nothing that needs them itself.
    handleKey(event) {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === " ") this.playback.toggle();
      else if (step) this.scrub(this.playback.time + (step * this.playback.end) / (event.ctrlKey ? 20 : 200));
      else if (event.key === "Home") this.scrub(0);
      else if (event.key === "End") this.scrub(this.playback.end);
      else return;
      event.preventDefault();
      event.stopPropagation();
    }

    makeCharts() {
      this.charts = [...this.forceCharts(), ...this.signalCharts()];
      for (const chart of this.charts) chart.onPick = (time) => this.scrub(time);
      this.plots.replaceChildren(...this.charts.map((chart) => chart.node));
      // An empty view keeps its size, so that the page does not jump.
      const recorded = Object.keys(this.recordings).length > 0;
      if (recorded) this.node.classList.toggle("plotless", this.charts.length === 0);
    }

    // A chart of one quantity with a line a design; `pick` finds the numbers in a recording.
    chart(title, unit, pick, fromZero) {
      const series = [];
      for (const design of knap.designs) {
        const recording = this.recordings[design];
        const ys = recording && pick(recording);
        if (ys) series.push({ name: design, style: design, xs: Array.from(recording.times), ys });
      }
      return new knap.LineChart({ title, unit, xLabel: "time", xUnit: "s", series, height: 132, fromZero });
    }

    namesOf(list) {
      const all = Object.values(this.recordings).flatMap((recording) => recording[list]);
      return [...new Set(all.map((one) => one.name))];
    }

    // A chart a contact; with many contacts, as a rope's links have, one chart of all together.
    forceCharts() {
      const names = this.namesOf("forces");
      const sizes = (recording, chosen) => {
        const forces = recording.forces.filter((force) => chosen.includes(force.name));
        const all = forces.map((force) => recording.forceSizes(force));
        return all.length ? all[0].map((_, i) => all.reduce((sum, one) => sum + one[i], 0)) : null;
      };
      if (names.length > 4) {
        return [this.chart(`Forces of ${names.length} contacts, added`, "N", (one) => sizes(one, names), true)];
      }
      return names.map((name) => this.chart(`Force ${name}`, "N", (recording) => sizes(recording, [name]), true));
    }

    signalCharts() {
      return this.namesOf("signals").map((name) => {
        const find = (recording) => recording.signals.find((signal) => signal.name === name);
        const unit = Object.values(this.recordings).map(find).find(Boolean)?.unit ?? "";
        return this.chart(name, unit, (recording) => find(recording)?.values, false);
      });
    }
  }

  knap.Replay = Replay;
})(window.knap = window.knap || {});
