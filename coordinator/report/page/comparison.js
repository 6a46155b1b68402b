// Runs beside each other: methods of a study with their seeds, or two runs. What each ended at, how it got there, and
// where in its bounds each parameter came to rest.
(function (knap) {
  "use strict";
  const { html, svg, table, onWidth } = knap.elements;
  const { quantity, percent, count } = knap.quantities;

  const styles = 6;  // g0 to g5
  const styleOf = (index) => `g${index % styles}`;
  const known = (value) => value !== null && value !== undefined && Number.isFinite(value);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

  function deviation(values) {
    if (values.length < 2) return 0;
    const middle = mean(values);
    return Math.sqrt(values.reduce((sum, value) => sum + (value - middle) ** 2, 0) / (values.length - 1));
  }

  function median(values) {
    const sorted = [...values].sort((a, b) => a - b);
    const half = Math.floor(sorted.length / 2);
    return sorted.length % 2 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
  }

  // One row a group: a dot a run, an upright mark at their mean. `axisOf(pixels)` makes the axis.
  class Strip {
    constructor(rows, axisOf, text, reference = null) {
      Object.assign(this, { rows, axisOf, text, reference });
      const described = rows.map(({ name, values }) => `${name} ${values.map(text).join(", ")}`).join("; ");
      this.node = html("div", { class: "plot strip", role: "img", "aria-label": described });
      onWidth(this.node, (width) => this.draw(width));
    }

    draw(width) {
      const [left, rowHeight] = [Math.min(150, width * 0.34), 26];
      const height = rowHeight * this.rows.length + 26;
      const axis = this.axisOf([left, width - 44]);
      const drawing = svg("svg", { width, height, "aria-hidden": "true" });
      if (!axis) return;
      const axes = svg("g", { class: "axes" });
      for (const { value, text } of axis.ticks) {
        axes.append(svg("line", { x1: axis.at(value), x2: axis.at(value), y1: 4, y2: height - 22 }),
          svg("text", { x: axis.at(value), y: height - 8, "text-anchor": "middle" }, this.tickText?.(value) ?? text));
      }
      drawing.append(axes);
      if (known(this.reference) && Number.isFinite(axis.at(this.reference))) {
        const x = axis.at(this.reference);
        drawing.append(svg("g", { class: "borders" }, svg("line", { x1: x, x2: x, y1: 0, y2: height - 22 })));
      }
      this.rows.forEach(({ name, values, labels, style }, i) => {
        const y = rowHeight * (i + 0.5) + 4;
        const row = svg("g", { class: `dots ${style}` }, svg("text", { x: 0, y: y + 4 }, name));
        const at = values.map((value) => (known(value) ? axis.at(value) : NaN));
        at.forEach((x, k) => {
          if (!Number.isFinite(x)) return;
          // Equal values lie side by side.
          const before = at.slice(0, k).filter((other) => Math.abs(other - x) < 3).length;
          row.append(svg("circle", { cx: x, cy: y + 4 * (before % 2 ? -1 : 1) * Math.ceil(before / 2), r: 3.5 },
            svg("title", null, `${labels[k]}: ${this.text(values[k])}`)));
        });
        const finite = values.filter(known);
        if (finite.length > 1) {
          const x = axis.at(mean(finite));
          row.append(svg("line", { class: "mean", x1: x, x2: x, y1: y - 9, y2: y + 9 }));
        }
        drawing.append(row);
      });
      this.node.replaceChildren(drawing);
    }
  }

  function labelled(title, node, hint) {
    return html("figure", { class: "dotted" }, html("figcaption", null, html("span", { class: "title" }, title),
      hint ? html("span", { class: "readout" }, hint) : null), node);
  }

  const rowsOf = (groups, pick) => groups.map((group, i) => ({
    name: group.name, style: styleOf(i), labels: group.runs.map((run) => run.name), values: group.runs.map(pick),
  }));

  function outcomes(data, groups) {
    const { initial } = data.comparison;
    const made = [];
    if (data.has_success) {
      const strip = new Strip(rowsOf(groups, (run) => run.test.success_rate),
        (pixels) => knap.axes.linear([0, 1], pixels, { tight: true, wanted: 5 }), percent, initial?.success_rate);
      strip.tickText = percent;
      made.push(labelled("Success on variations that no run saw", strip.node, "dotted: the initial tool"));
    }
    const losses = groups.flatMap((group) => group.runs.map((run) => run.test.loss_mean));
    const loss = (value) => quantity(value, data.loss_unit ?? "");
    const strip = new Strip(rowsOf(groups, (run) => run.test.loss_mean),
      (pixels) => knap.axes.fitting([...losses, initial?.loss_mean ?? null], pixels, true), loss, initial?.loss_mean);
    strip.tickText = loss;
    made.push(labelled("Mean loss there", strip.node, "dotted: the initial tool"));
    return made;
  }

  // What a group's runs had reached after so many rollouts, in the mean; before a run's first value there is none.
  function progressOf(group, field) {
    const curves = group.runs.map((run) => run.curve).filter((curve) => curve[field]?.some(known));
    if (!curves.length) return null;
    const last = Math.max(...curves.map((curve) => curve.rollouts.at(-1)));
    const xs = Array.from({ length: 101 }, (_, i) => (last * i) / 100);
    const ys = xs.map((x) => {
      const values = curves.map((curve) => {
        let value = null;
        curve.rollouts.forEach((at, i) => { if (at <= x && known(curve[field][i])) value = curve[field][i]; });
        return value;
      });
      return values.every((value) => value !== null) ? mean(values) : null;
    });
    return { xs, ys };
  }

  function curves(data, groups) {
    const fields = [["validation_success", "Share of validation variations that succeeds", "", true],
      ["validation_loss", "Validation: mean loss", data.loss_unit ?? "", false],
      ["best_loss", "Best loss of the present batch", data.loss_unit ?? "", false]];
    return fields.map(([field, title, unit, fromZero]) => {
      const series = groups.map((group, i) => {
        const progress = progressOf(group, field);
        return progress && { name: group.name, style: styleOf(i), stepped: true, ...progress };
      }).filter((one) => one && one.ys.some(known));
      if (!series.length) return null;
      return new knap.LineChart({ title: data.comparison.of_runs ? title : `${title}, mean over runs`, unit,
        xLabel: "rollouts", series, fromZero, logarithmic: !fromZero, height: 220 }).node;
    }).filter(Boolean);
  }

  function summaryTable(data, groups) {
    const loss = (value) => quantity(value, data.loss_unit ?? "");
    const spread = (values, text) => (values.length > 1 ? `${text(mean(values))} ± ${text(deviation(values))}` :
      text(values[0]));
    const rows = groups.map((group) => {
      const pick = (field) => group.runs.map((run) => run.test[field]).filter(known);
      const rates = pick("success_rate");
      const single = data.comparison.of_runs;
      const cells = single ? [group.name] : [group.name, count(group.runs.length)];
      const of = (text) => (rates.length ? text() : "none");
      if (data.has_success && single) {
        cells.push(of(() => percent(rates[0])), of(() => group.runs[0].test.success_rate_95.map(percent).join(" to ")));
      } else if (data.has_success) {
        cells.push(of(() => spread(rates, percent)), of(() => percent(median(rates))),
          of(() => `${percent(Math.min(...rates))} to ${percent(Math.max(...rates))}`));
      }
      const [means, tails] = [pick("loss_mean"), pick("worst_decile_loss")];
      cells.push(means.length ? spread(means, loss) : "none", tails.length ? spread(tails, loss) : "none",
        count(Math.round(mean(group.runs.map((run) => run.rollouts)))));
      return cells;
    });
    const single = data.comparison.of_runs;
    const success = single ? ["success", "95% interval"] : ["success", "median", "least to most"];
    const heads = ["", ...(single ? [] : ["runs"]), ...(data.has_success ? success : []), "mean loss", "worst tenth",
      "rollouts"];
    const caption = single ? "On variations that neither run saw" : "Mean ± standard deviation over runs";
    return table(caption, heads, rows, heads.map((_, i) => i).slice(1));
  }

  function parameters(data, groups) {
    const { names = [], lower, upper, initial, kinds } = data.theta ?? {};
    if (!names.length || names.length > 24) return null;
    const charts = names.map((name, k) => {
      const text = (value) => quantity(value, kinds[k]);
      const strip = new Strip(rowsOf(groups, (run) => run.theta[k]),
        (pixels) => knap.axes.linear([lower[k], upper[k]], pixels, { tight: true }), text, initial[k]);
      strip.tickText = text;
      return labelled(name.replaceAll("_", " "), strip.node);
    });
    return html("details", null, html("summary", null, `Where the ${count(names.length)} parameters came to rest`),
      html("p", { class: "hint" }, "Each axis is a parameter's whole range; dotted: where it began."),
      html("div", { class: "charts" }, ...charts));
  }

  function make(data) {
    const groups = data.comparison?.groups;
    if (!groups?.length) return null;
    return html("div", { class: "comparison" }, html("div", { class: "charts" }, ...outcomes(data, groups)),
      summaryTable(data, groups), html("div", { class: "charts" }, ...curves(data, groups)), parameters(data, groups));
  }

  knap.comparison = { make };
})(window.knap = window.knap || {});
