// Line charts as SVG. A chart follows the width of its place, has a cursor, and tells values under it as text.
(function (knap) {
  "use strict";
  const { html, svg, onWidth } = knap.elements;

  const margin = { left: 52, right: 10, top: 8, bottom: 34 };

  // One path for a series; a value without a place (not finite, or not positive on a logarithmic axis) breaks it.
  function pathOf(xs, ys, xAxis, yAxis, stepped) {
    let path = "";
    let down = false;
    for (let i = 0; i < xs.length; ++i) {
      const [x, y] = [xAxis.at(xs[i]), ys[i] === null ? NaN : yAxis.at(ys[i])];
      if (!Number.isFinite(x) || !Number.isFinite(y)) {
        down = false;
        continue;
      }
      if (down && stepped) path += `H${x.toFixed(1)}`;
      path += `${down ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`;
      down = true;
    }
    return path;
  }

  function drawAxes(xAxis, yAxis, width, height, xLabel) {
    const [left, right, bottom] = [margin.left, width - margin.right, height - margin.bottom];
    const group = svg("g", { class: "axes" });
    for (const { value, text } of yAxis.ticks) {
      const y = yAxis.at(value);
      group.append(svg("line", { x1: left, x2: right, y1: y, y2: y }),
        svg("text", { x: left - 6, y: y + 4, "text-anchor": "end" }, text));
    }
    for (const { value, text } of xAxis.ticks) {
      const x = xAxis.at(value);
      group.append(svg("line", { x1: x, x2: x, y1: bottom, y2: bottom + 4, class: "tick" }),
        svg("text", { x, y: bottom + 16, "text-anchor": "middle" }, text));
    }
    group.append(svg("text", { x: (left + right) / 2, y: height - 3, "text-anchor": "middle" }, xLabel));
    return group;
  }

  // The sample whose x is nearest; xs ascend.
  function nearest(xs, x) {
    let best = -1;
    for (let i = 0; i < xs.length; ++i) if (best < 0 || Math.abs(xs[i] - x) < Math.abs(xs[best] - x)) best = i;
    return best;
  }

  // series: { name, style, xs, ys, stepped, marks } in `unit`; marks are flags of samples that get a dot.
  // xLabel names the x axis; borders are x values with a line through the chart.
  class LineChart {
    constructor({ title, unit = "", xLabel, xUnit = "", series, borders = [], height = 170, logarithmic = false,
      fromZero = false }) {
      Object.assign(this, { title, xLabel, xUnit, series, borders, height, logarithmic, fromZero });
      const all = series.flatMap((one) => Array.from(one.ys));
      const range = knap.axes.rangeOf(all) ?? [0, 0];
      this.scale = knap.quantities.scaleFor(Math.max(Math.abs(range[0]), Math.abs(range[1])), unit);
      this.cursor = null;
      this.readout = html("span", { class: "readout", "aria-live": "off" });
      this.plot = html("div", { class: "plot", tabindex: 0, role: "img", "aria-label": this.describe(range) });
      const unitText = this.scale.unit ? ` [${this.scale.unit}]` : "";
      this.node = html("figure", { class: "chart" },
        html("figcaption", null, html("span", { class: "title" }, title + unitText), this.legend(), this.readout),
        this.plot);
      onWidth(this.plot, (width) => this.draw(width));
      this.follow();
    }

    describe(range) {
      const span = range.map((value) => knap.quantities.number(value / this.scale.factor)).join(" to ");
      return `${this.title} over ${this.xLabel}: ${this.series.map((one) => one.name).join(", ")}; ` +
        `from ${span} ${this.scale.unit}. Arrow keys read values.`;
    }

    legend() {
      return html("span", { class: "legend" }, ...this.series.map((one) =>
        html("span", { class: `key ${one.style}` }, svg("svg", { width: 18, height: 8, "aria-hidden": "true" },
          svg("path", { class: "series", d: "M0,4H18" })), one.name)));
    }

    draw(width) {
      const scaled = this.series.map((one) => ({
        ...one, ys: Array.from(one.ys, (y) => (y === null ? null : y / this.scale.factor)),
      }));
      const values = scaled.flatMap((one) => one.ys);
      const vertical = [this.height - margin.bottom, margin.top];
      this.yAxis = knap.axes.fitting(this.fromZero ? [0, ...values] : values, vertical, this.logarithmic) ??
        knap.axes.linear([0, 1], vertical);
      const range = knap.axes.rangeOf(scaled.flatMap((one) => Array.from(one.xs))) ?? [0, 1];
      this.xAxis = knap.axes.linear(range, [margin.left, width - margin.right], { tight: true, wanted: width / 90 });
      const drawing = svg("svg", { width, height: this.height, "aria-hidden": "true" });
      const label = this.xUnit ? `${this.xLabel} [${this.xUnit}]` : this.xLabel;
      drawing.append(drawAxes(this.xAxis, this.yAxis, width, this.height, label), this.drawBorders());
      for (const one of scaled) drawing.append(this.drawSeries(one));
      this.cursorLine = svg("line", { class: "cursor", y1: margin.top, y2: this.height - margin.bottom });
      drawing.append(this.cursorLine);
      this.plot.replaceChildren(drawing);
      this.placeCursor();
    }

    drawBorders() {
      return svg("g", { class: "borders" }, ...this.borders.map((x) =>
        svg("line", { x1: this.xAxis.at(x), x2: this.xAxis.at(x), y1: margin.top, y2: this.height - margin.bottom })));
    }

    drawSeries({ style, xs, ys, stepped, marks }) {
      const group = svg("g", { class: style });
      group.append(svg("path", { class: "series", d: pathOf(xs, ys, this.xAxis, this.yAxis, stepped) }));
      (marks ?? []).forEach((marked, i) => {
        const [x, y] = [this.xAxis.at(xs[i]), ys[i] === null ? NaN : this.yAxis.at(ys[i])];
        if (marked && Number.isFinite(x) && Number.isFinite(y)) group.append(svg("circle", { cx: x, cy: y, r: 2.4 }));
      });
      return group;
    }

    // Puts the cursor at an x and says the values there; null takes it away.
    setCursor(x) {
      this.cursor = x;
      this.placeCursor();
    }

    placeCursor() {
      const shown = this.cursor !== null;
      this.readout.textContent = shown ? this.valuesAt(this.cursor) : "";
      if (!this.cursorLine) return;
      this.cursorLine.style.visibility = shown ? "visible" : "hidden";
      if (!shown) return;
      const x = Math.min(this.xAxis.at(this.xAxis.high), Math.max(margin.left, this.xAxis.at(this.cursor)));
      this.cursorLine.setAttribute("x1", x);
      this.cursorLine.setAttribute("x2", x);
    }

    valuesAt(x) {
      const said = this.series.map((one) => {
        const i = nearest(one.xs, x);
        if (i < 0 || one.ys[i] === null || !Number.isFinite(one.ys[i])) return null;
        return `${one.name} ${knap.quantities.number(one.ys[i] / this.scale.factor)}`;
      });
      const place = `${this.xLabel} ${knap.quantities.number(x)}${this.xUnit && ` ${this.xUnit}`}`;
      return `${place}: ${said.filter(Boolean).join(", ")}`;
    }

    // The pointer and the arrow keys move the cursor; a chart beside a replay moves the replay instead (onPick).
    follow() {
      const pick = (x) => (this.onPick ? this.onPick(x) : this.setCursor(x));
      const under = (event) => {
        const { low, high } = this.xAxis;
        const share = (event.offsetX - margin.left) / (this.xAxis.at(high) - margin.left);
        const x = low + Math.min(1, Math.max(0, share)) * (high - low);
        const xs = this.series[0].xs;
        return this.onPick ? x : xs[nearest(xs, x)];
      };
      this.plot.addEventListener("pointermove", (event) => {
        if (!this.onPick || event.buttons & 1) pick(under(event));
      });
      this.plot.addEventListener("pointerdown", (event) => pick(under(event)));
      this.plot.addEventListener("pointerleave", () => this.onPick || this.setCursor(null));
      this.plot.addEventListener("keydown", (event) => {
        const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (!step || this.onPick) return;
        const xs = this.series[0].xs;
        const at = this.cursor === null ? -1 : nearest(xs, this.cursor);
        this.setCursor(xs[Math.min(xs.length - 1, Math.max(0, at + step))]);
        this.readout.setAttribute("aria-live", "polite");
        event.preventDefault();
        event.stopPropagation();
      });
    }
  }

  knap.LineChart = LineChart;
})(window.knap = window.knap || {});
