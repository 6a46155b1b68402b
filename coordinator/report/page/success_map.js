// Where in the variation space each design succeeds: a dot a test variation, to click.
(function (knap) {
  "use strict";
  const { html, svg, onWidth } = knap.elements;
  const { scaleFor, quantity } = knap.quantities;

  const titles = { initial: "Initial tool", learned: "Learned tool" };
  const margin = { left: 52, right: 12, top: 10, bottom: 38 };

  // Cividis in seven steps, which readers with any colour vision can order.
  const lossColours = ["#00224e", "#2a3f6d", "#575d6d", "#7d7c78", "#a59c74", "#d2c060", "#fee838"];

  class SuccessMap {
    // choose(row) is called when a reader picks a variation.
    constructor(variations, choose) {
      this.variations = variations;
      this.choose = choose;
      this.selected = null;
      this.axes = [
        ...variations.keys.map((key, k) => ({
          name: knap.Variations.shortName(key.key), unit: key.unit, range: this.rangeOfKey(key, k),
          value: (design, row) => variations.values[row]?.[k],
        })),
        { name: "loss", unit: variations.lossUnit, value: (design, row) => variations.loss(design, row) },
      ];
      this.chosen = variations.keys.length > 1 ? [0, 1] : [0, variations.keys.length];
      this.byLoss = !variations.hasSuccess;
      this.maps = Object.fromEntries(knap.designs.map((design) => [design, this.makeMap(design)]));
      this.details = html("div", { class: "details", role: "status" });
      this.legend = html("p", { class: "legend" });
      this.node = html("div", { class: "map" }, this.makeControls(), this.legend,
        html("div", { class: "panes" }, ...knap.designs.map((design) => this.maps[design].node)), this.details);
      for (const design of knap.designs) onWidth(this.maps[design].plot, () => this.draw(design));
      this.drawLegend();
    }

    // Values may lie outside the bounds that a distribution without ends was given.
    rangeOfKey({ lower, upper }, k) {
      return knap.axes.rangeOf([lower, upper, ...this.variations.values.map((row) => row[k])]) ?? [0, 1];
    }

    makeMap(design) {
      const plot = html("div", { class: "plot" });
      plot.addEventListener("keydown", (event) => this.handleKey(event, design));
      const node = html("figure", { class: design }, html("figcaption", null, titles[design]), plot);
      return { plot, node, dots: [] };
    }

    makeControls() {
      const axisChoice = (label, place) => {
        const select = html("select", { onchange: () => {
          this.chosen[place] = Number(select.value);
          this.drawAll();
        } }, ...this.axes.map(({ name }, i) => html("option", { value: i, selected: i === this.chosen[place] }, name)));
        return html("label", null, `${label} `, select);
      };
      const colour = html("select", { class: "colour-choice", onchange: () => {
        this.byLoss = colour.value === "loss";
        this.drawAll();
      } }, ...(this.variations.hasSuccess ? ["success", "loss"] : ["loss"])
        .map((name) => html("option", { value: name }, name)));
      return html("div", { class: "controls" }, axisChoice("across", 0), axisChoice("up", 1),
        html("label", null, "colour ", colour));
    }

    drawAll() {
      this.drawLegend();
      for (const design of knap.designs) this.draw(design);
    }

    // Both maps share their axes, so that a variation is at the same place in both.
    axisOf(place, pixels) {
      const axis = this.axes[this.chosen[place]];
      const values = axis.range ?? this.lossValues();
      const range = knap.axes.rangeOf(values) ?? [0, 1];
      const scale = scaleFor(Math.max(...range.map(Math.abs)), axis.unit);
      const scaled = values.map((value) => (value === null || value === undefined ? null : value / scale.factor));
      const drawn = axis.range ? knap.axes.linear(scaled, pixels, { tight: true, wanted: 6 }) :
        knap.axes.fitting(scaled, pixels, true) ?? knap.axes.linear([0, 1], pixels);
      const label = scale.unit ? `${axis.name} [${scale.unit}]` : axis.name;
      return { drawn, label, at: (design, row) => this.place(drawn, axis.value(design, row), scale.factor) };
    }

    // Failed rollouts have no loss: they stand at the far end of a loss axis. What the axis cannot hold is at its ends.
    place(drawn, value, factor) {
      if (value === undefined) return NaN;
      const scaled = value === null ? drawn.high : value / factor;
      return drawn.at(Math.min(drawn.high, Math.max(drawn.low, scaled)));
    }

    lossValues() {
      const rows = Array.from({ length: this.variations.count }, (_, row) => row);
      return knap.designs.flatMap((design) => rows.map((row) => this.variations.loss(design, row) ?? null));
    }

    draw(design) {
      const map = this.maps[design];
      const width = map.plot.clientWidth;
      if (!width) return;
      const height = Math.round(Math.min(360, Math.max(220, 0.72 * width)));
      const across = this.axisOf(0, [margin.left, width - margin.right]);
      const up = this.axisOf(1, [height - margin.bottom, margin.top]);
      const label = `${titles[design]}: ${this.variations.count} test variations. Arrow keys move, Enter shows one.`;
      const drawing = svg("svg", { width, height, role: "group", "aria-label": label });
      drawing.append(this.drawAxes(across, up, width, height));
      map.dots = [];
      for (let row = 0; row < this.variations.count; ++row) {
        const [x, y] = [across.at(design, row), up.at(design, row)];
        if (!this.variations.tested(design, row) || !Number.isFinite(x) || !Number.isFinite(y)) continue;
        const node = this.makeDot(design, row, x, y);
        map.dots.push({ row, x, y, node });
      }
      drawing.append(...map.dots.map((dot) => dot.node));
      map.plot.replaceChildren(drawing);
      this.mark(design);
    }

    drawAxes(across, up, width, height) {
      const bottom = height - margin.bottom;
      const group = svg("g", { class: "axes" });
      group.append(svg("rect", { x: margin.left, y: margin.top, width: width - margin.left - margin.right,
        height: bottom - margin.top, class: "frame" }));
      for (const { value, text } of across.drawn.ticks) {
        const x = across.drawn.at(value);
        group.append(svg("line", { x1: x, x2: x, y1: margin.top, y2: bottom }),
          svg("text", { x, y: bottom + 16, "text-anchor": "middle" }, text));
      }
      for (const { value, text } of up.drawn.ticks) {
        const y = up.drawn.at(value);
        group.append(svg("line", { x1: margin.left, x2: width - margin.right, y1: y, y2: y }),
          svg("text", { x: margin.left - 6, y: y + 4, "text-anchor": "end" }, text));
      }
      group.append(svg("text", { x: width - margin.right, y: height - 4, "text-anchor": "end", class: "label" },
        `${across.label} → · ↑ ${up.label}`));
      return group;
    }

    // Success is a filled dot, failure a cross: the form tells what the colour tells. A ring has a recording behind it.
    makeDot(design, row, x, y) {
      const { variations } = this;
      const success = variations.success(design, row);
      const untrusted = variations.distrust(design, row) !== "";
      const node = svg("g", { class: "dot", transform: `translate(${x.toFixed(1)},${y.toFixed(1)})`, tabindex: -1,
        role: "button", "aria-label": this.describe(design, row), "data-row": row,
        onclick: () => this.pick(design, row) });
      node.append(svg("circle", { r: 9, class: "target" }));
      if (variations.embedded(row)) node.append(svg("circle", { r: 7, class: "recorded" }));
      if (untrusted) node.append(svg("path", { class: "untrusted", d: "M0,-8L8,0L0,8L-8,0Z" }));
      const form = success === false ? svg("path", { d: "M-4,-4L4,4M-4,4L4,-4", class: "cross" }) :
        svg("circle", { r: 4.2, class: "disc" });
      const colour = this.byLoss ? this.colourOf(variations.loss(design, row)) : null;
      if (colour) form.style[success === false ? "stroke" : "fill"] = colour;
      form.classList.add(this.byLoss ? "by-loss" : success === false ? "failure" : "success");
      // Some colours of the scale are near the paper's.
      if (this.byLoss && success === false) node.append(svg("path", { d: "M-4,-4L4,4M-4,4L4,-4", class: "cross rim" }));
      node.append(form, svg("title", null, this.describe(design, row)));
      return node;
    }

    describe(design, row) {
      const { variations } = this;
      const success = variations.success(design, row);
      const words = [`variation ${row}`, variations.lossPhrase(design, row)];
      if (success !== null) words.push(success ? "success" : "failure");
      if (variations.distrust(design, row)) words.push("not trusted");
      if (variations.gradientFlagged(design, row)) words.push("gradient flagged");
      if (variations.embedded(row)) words.push("recorded");
      return words.join(", ");
    }

    lossScale() {
      const values = this.lossValues();
      return knap.axes.fitting(values, [0, 1], true);
    }

    colourOf(loss) {
      if (loss === null || loss === undefined) return "var(--failure)";
      const scale = this.lossScaleKept ??= this.lossScale();
      if (!scale) return lossColours[0];
      const share = scale.at(Math.max(loss, scale.low));
      return lossColours[Math.min(lossColours.length - 1, Math.max(0, Math.floor(share * lossColours.length)))];
    }

    drawLegend() {
      const key = (content, text) => html("span", { class: "key" },
        svg("svg", { width: 18, height: 18, viewBox: "-9 -9 18 18", "aria-hidden": "true" }, content), text);
      const keys = [];
      if (!this.byLoss) keys.push(key(svg("circle", { r: 4.2, class: "disc success" }), "success"));
      if (this.variations.hasSuccess) {
        keys.push(key(svg("path", { d: "M-4,-4L4,4M-4,4L4,-4", class: `cross ${this.byLoss ? "by-loss" : "failure"}` }),
          "failure"));
      }
      if (this.byLoss) keys.push(this.lossKey());
      keys.push(key(svg("circle", { r: 7, class: "recorded" }), "recorded: plays when chosen"),
        key(svg("path", { class: "untrusted", d: "M0,-8L8,0L0,8L-8,0Z" }), "not trusted"));
      this.legend.replaceChildren(...keys);
    }

    lossKey() {
      const scale = this.lossScale();
      const text = (loss) => quantity(loss, this.variations.lossUnit, 2);
      const ends = scale ? [text(scale.low), text(scale.high)] : ["", ""];
      return html("span", { class: "key" }, `loss ${ends[0]} `, html("span", { class: "ramp", "aria-hidden": "true" },
        ...lossColours.map((colour) => {
          const cell = html("span");
          cell.style.background = colour;
          return cell;
        })), ` ${ends[1]}${scale?.logarithmic ? ", by decades" : ""}`);
    }

    pick(design, row) {
      this.choose(row);
      this.maps[design].dots.find((dot) => dot.row === row)?.node.focus();
    }

    select(row, command) {
      this.selected = row;
      for (const design of knap.designs) this.mark(design);
      this.showDetails(row, command);
    }

    // The chosen variation's dot is the one that Tab reaches.
    mark(design) {
      const { dots } = this.maps[design];
      const chosen = dots.find((dot) => dot.row === this.selected) ?? dots[0];
      for (const dot of dots) {
        dot.node.setAttribute("tabindex", dot === chosen ? 0 : -1);
        dot.node.classList.toggle("selected", dot.row === this.selected);
        dot.node.setAttribute("aria-current", dot.row === this.selected);
      }
      if (chosen?.row === this.selected) chosen.node.parentNode.append(chosen.node);
    }

    // The nearest dot in the direction of an arrow key, sideways distance counting double.
    handleKey(event, design) {
      const { dots } = this.maps[design];
      const current = dots.find((dot) => dot.node === document.activeElement);
      const direction = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!current) return;
      if (event.key === "Enter" || event.key === " ") {
        this.pick(design, current.row);
      } else if (direction) {
        const along = (dot) => (dot.x - current.x) * direction[0] + (dot.y - current.y) * direction[1];
        const aside = (dot) => Math.abs((dot.x - current.x) * direction[1] - (dot.y - current.y) * direction[0]);
        const cost = (dot) => along(dot) + 2 * aside(dot);
        const ahead = dots.filter((dot) => along(dot) > 0.5).sort((a, b) => cost(a) - cost(b))[0];
        ahead?.node.focus();
      } else {
        return;
      }
      event.preventDefault();
      event.stopPropagation();
    }

    showDetails(row, command) {
      const { variations } = this;
      const keys = variations.keys.map(({ key }, k) =>
        `${knap.Variations.shortName(key)} = ${variations.keyText(row, k)}`);
      const outcome = knap.designs.map((design) => {
        const success = variations.success(design, row);
        const words = [variations.lossPhrase(design, row)];
        if (success !== null) words.push(success ? "success" : "failure");
        if (variations.gradientFlagged(design, row)) words.push("gradient flagged");
        if (variations.distrust(design, row)) words.push(`not trusted: ${variations.distrust(design, row)}`);
        return `${design}: ${words.join(", ")}`;
      });
      const code = command ? html("code", null, command) : null;
      this.details.replaceChildren(
        html("strong", null, `Variation ${row}`),
        ...(variations.embedded(row) ? [" plays in the ", html("a", { href: "#replay" }, "replay"), ". "] :
          [" is not recorded in this file. "]),
        html("span", null, [...keys, ...outcome].join("; ") + ". "),
        ...(code ? [html("span", null, "To compute it again: "), code, " ",
          knap.elements.copyButton(code, "Copy the command")] : []));
    }
  }

  knap.SuccessMap = SuccessMap;
})(window.knap = window.knap || {});
