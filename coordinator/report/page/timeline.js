// Who computed what and when: a lane a worker, a bar a rollout, a line an event.
(function (knap) {
  "use strict";
  const { html, svg, onWidth, table } = knap.elements;
  const { number, count, counted, percent, duration } = knap.quantities;

  const margin = { left: 110, right: 12, top: 18, bottom: 34 };

  class Timeline {
    constructor({ workers = [], rollouts = {}, events = [] }) {
      this.rollouts = { worker: [], kind: [], end_s: [], duration_s: [], attempt: [], ...rollouts };
      const lanes = Math.max(workers.length, (knap.axes.rangeOf(this.rollouts.worker)?.[1] ?? -1) + 1);
      this.workers = Array.from({ length: lanes }, (_, i) => workers[i] ?? `worker ${i + 1}`);
      this.events = events;
      const times = [0, ...this.rollouts.end_s, ...events.map((one) => one.time_s)];
      this.end = Math.max(1e-3, knap.axes.rangeOf(times)[1]);
      this.kinds = [...new Set(this.rollouts.kind)].sort();
      this.readout = html("p", { class: "readout" });
      this.plot = html("div", { class: "plot", role: "img", "aria-label": this.summary() });
      onWidth(this.plot, (width) => this.draw(width));
      this.node = html("div", { class: "timeline" }, html("p", null, this.summary()), this.legend(), this.plot,
        this.readout, this.eventList(), this.workerTable());
    }

    retries() {
      return this.rollouts.attempt.filter((attempt) => attempt > 1).length;
    }

    summary() {
      const lost = this.events.filter((one) => one.event === "worker_lost").length;
      const again = this.retries() ? `${count(this.retries())} of them sent again` : "none was sent again";
      const done = [counted(this.workers.length, "worker"), counted(this.rollouts.end_s.length, "rollout")];
      const losses = lost ? `${counted(lost, "worker")} lost` : "no worker lost";
      return `${done.join(" computed ")} in ${duration(this.end)}; ${again}, ${losses}.`;
    }

    legend() {
      const key = (style, text) => html("span", { class: "key" },
        svg("svg", { width: 18, height: 10, "aria-hidden": "true" },
          svg("rect", { class: style, width: 18, height: 10 })), text);
      return html("p", { class: "legend" }, ...this.kinds.map((kind, i) => key(`kind-${i % 4}`, kind)),
        this.retries() ? key("retry", "sent again") : null, this.events.length ? key("event", "event") : null);
    }

    draw(width) {
      const lanes = Math.max(1, this.workers.length);
      const lane = Math.max(3, Math.min(22, 480 / lanes));
      const height = margin.top + lane * lanes + margin.bottom;
      const drawing = svg("svg", { width, height, "aria-hidden": "true" });
      const xAxis = knap.axes.linear([0, this.end], [margin.left, width - margin.right],
        { tight: true, wanted: width / 110 });
      drawing.append(this.drawLanes(lane, width), this.drawTicks(xAxis, height, width), ...this.drawBars(xAxis, lane),
        ...this.events.map((one) => this.drawEvent(one, xAxis, height)));
      drawing.addEventListener("pointermove", (event) => this.tell(event, xAxis, lane));
      this.plot.replaceChildren(drawing);
    }

    // Names are left out where lanes are too narrow for them; the table below has all.
    drawLanes(lane, width) {
      const every = Math.ceil(12 / lane);
      return svg("g", { class: "lanes" }, ...this.workers.flatMap((worker, i) => {
        const y = margin.top + i * lane;
        const rect = svg("rect", { x: margin.left, y: y + 0.1 * lane, width: width - margin.left - margin.right,
          height: 0.8 * lane });
        if (i % every) return [rect];
        const name = worker.length > 16 ? `${worker.slice(0, 15)}…` : worker;
        const middle = y + 0.5 * Math.max(lane, 8) + 4;
        return [rect, svg("text", { x: margin.left - 6, y: middle, "text-anchor": "end" }, name)];
      }));
    }

    drawTicks(xAxis, height, width) {
      const bottom = height - margin.bottom;
      return svg("g", { class: "axes" }, ...xAxis.ticks.flatMap(({ value, text }) => [
        svg("line", { x1: xAxis.at(value), x2: xAxis.at(value), y1: bottom, y2: bottom + 4, class: "tick" }),
        svg("text", { x: xAxis.at(value), y: bottom + 16, "text-anchor": "middle" }, text)]),
      svg("text", { x: (margin.left + width) / 2, y: height - 3, "text-anchor": "middle", class: "label" },
        "time since the start [s]"));
    }

    // One path a kind: tens of thousands of rollouts are more elements than a browser likes.
    drawBars(xAxis, lane) {
      const { worker, kind, end_s: ends, duration_s: durations, attempt } = this.rollouts;
      const paths = new Map(this.kinds.map((name) => [name, ""]));
      let again = "";
      for (let i = 0; i < worker.length; ++i) {
        const [x, right] = [xAxis.at(Math.max(0, ends[i] - durations[i])), xAxis.at(ends[i])];
        const y = margin.top + worker[i] * lane;
        const across = Math.max(0.6, right - x - 0.4);
        const bar = (top, tall) => `M${x.toFixed(2)},${(y + top).toFixed(2)}h${across.toFixed(2)}v${tall.toFixed(2)}h` +
          `${(-across).toFixed(2)}z`;
        paths.set(kind[i], paths.get(kind[i]) + bar(0.1 * lane, 0.8 * lane));
        if (attempt[i] > 1) again += bar(0.1 * lane, Math.max(2, 0.25 * lane));
      }
      const bars = this.kinds.map((name, i) => svg("path", { class: `bars kind-${i % 4}`, d: paths.get(name) }));
      return again ? [...bars, svg("path", { class: "retry", d: again })] : bars;
    }

    drawEvent({ time_s: time, event, text }, xAxis, height) {
      const x = xAxis.at(time);
      return svg("g", { class: "event" }, svg("title", null, `${number(time)} s: ${text || event}`),
        svg("path", { d: `M${x},${margin.top - 3}l-5,-9h10z` }),
        svg("line", { x1: x, x2: x, y1: margin.top - 3, y2: height - margin.bottom }));
    }

    tell(event, xAxis, lane) {
      const { worker, kind, end_s: ends, duration_s: durations, attempt } = this.rollouts;
      const row = Math.floor((event.offsetY - margin.top) / lane);
      const share = (event.offsetX - margin.left) / (xAxis.at(xAxis.high) - margin.left);
      const time = share * this.end;
      const i = worker.findIndex((one, k) => one === row && time <= ends[k] && time >= ends[k] - durations[k]);
      this.readout.textContent = i < 0 ? "" : `${this.workers[row]} at ${number(time)} s: ${kind[i]} rollout, ` +
        `${duration(durations[i])}${attempt[i] > 1 ? `, attempt ${attempt[i]}` : ""}`;
    }

    eventList() {
      if (!this.events.length) return null;
      return html("details", { open: this.events.length <= 5 },
        html("summary", null, counted(this.events.length, "event")),
        html("ul", { class: "events" }, ...this.events.map((one) =>
          html("li", null, html("span", { class: "when" }, `${number(one.time_s)} s`), ` ${one.text || one.event}`))));
    }

    workerTable() {
      const { worker, duration_s: durations, attempt } = this.rollouts;
      const lanes = this.workers.map((name) => ({ name, rollouts: 0, busy: 0, again: 0 }));
      worker.forEach((row, i) => {
        lanes[row].rollouts += 1;
        lanes[row].busy += durations[i];
        lanes[row].again += attempt[i] > 1 ? 1 : 0;
      });
      const rows = lanes.map((one) =>
        [one.name, count(one.rollouts), percent(one.busy / this.end), count(one.again)]);
      return html("details", null, html("summary", null, "The workers as a table"),
        table("What each worker computed", ["worker", "rollouts", "busy", "sent again"], rows, [1, 2, 3]));
    }
  }

  knap.Timeline = Timeline;
})(window.knap = window.knap || {});
