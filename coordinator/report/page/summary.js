// What came out, in words and one small drawing; certificates; how to repeat it.
(function (knap) {
  "use strict";
  const { html, svg, copyButton } = knap.elements;
  const { quantity, percent, count, counted, duration } = knap.quantities;

  // The measure that the run is judged by: the share of successes where there is one, else the mean loss.
  function measureOf(data) {
    const pick = (name) => knap.designs.map((design) => data.test?.[design]?.[name] ?? null);
    if (data.has_success && pick("success_rate").some((rate) => rate !== null)) {
      return { name: "Success", values: pick("success_rate"), intervals: pick("success_rate_95"), text: percent };
    }
    const text = (loss) => quantity(loss, data.loss_unit ?? "");
    return { name: "Mean loss", values: pick("loss_mean"), intervals: pick("loss_mean_95"), text };
  }

  function headline({ name, values, intervals, text }) {
    const part = (i, design) => html("span", { class: `figure ${design}` },
      html("span", { class: "who" }, design), html("span", { class: "value" }, text(values[i])),
      html("span", { class: "interval" }, intervals[i] ? `95% interval ${intervals[i].map(text).join(" to ")}` : ""));
    return html("div", { class: "headline" }, html("span", { class: "what" }, name), part(0, "initial"),
      html("span", { class: "arrow", "aria-label": "became" }, "→"), part(1, "learned"));
  }

  // Two dots with their intervals on one axis: whether the intervals overlap is seen at once.
  function intervalDrawing(measure) {
    const width = 300;
    const isShare = measure.name === "Success";
    const values = [...measure.values, ...measure.intervals.flatMap((interval) => interval ?? [])];
    const axis = isShare ? knap.axes.linear([0, 1], [10, width - 10], { tight: true }) :
      knap.axes.fitting(values, [10, width - 10], true);
    if (!axis) return null;
    const drawing = svg("svg", { class: "intervals", viewBox: `0 0 ${width} 48`, "aria-hidden": "true" });
    drawing.append(svg("line", { class: "base", x1: 10, x2: width - 10, y1: 32, y2: 32 }));
    for (const [at, anchor] of [[axis.low, "start"], [axis.high, "end"]]) {
      drawing.append(svg("text", { x: axis.at(at) + (anchor === "start" ? -8 : 8), y: 46, "text-anchor": anchor },
        measure.text(at)));
    }
    knap.designs.forEach((design, i) => drawing.append(...intervalMark(measure, axis, design, i)));
    return drawing;
  }

  function intervalMark({ values, intervals }, axis, design, i) {
    const y = 12 + 10 * i;
    const marks = [];
    if (intervals[i]) {
      const [low, high] = intervals[i].map((value) => axis.at(Math.min(axis.high, Math.max(axis.low, value))));
      if (Number.isFinite(low + high)) marks.push(svg("line", { class: design, x1: low, x2: high, y1: y, y2: y }));
    }
    const at = values[i] === null ? NaN : axis.at(values[i]);
    if (Number.isFinite(at)) marks.push(svg("circle", { class: design, cx: at, cy: y, r: 4.5 }));
    return marks;
  }

  function trustSentences(data) {
    return knap.designs.flatMap((design) => {
      const summary = data.test?.[design];
      if (!summary) return [];
      const reasons = Object.entries(summary.distrust ?? {}).map(([reason, n]) => `${reason} (${count(n)})`);
      const troubles = [[summary.untrusted, "not trusted"], [summary.not_converged, "did not converge"],
        [summary.not_finite, "left the finite numbers"]].filter(([n]) => n > 0).map(([n, what]) => `${count(n)} ${what}`);
      if (!troubles.length) return [];
      const why = reasons.length ? `: ${reasons.join(", ")}` : "";
      return [`Of the ${design} tool's ${count(data.test.variations)} test rollouts ${troubles.join(", ")}${why}.`];
    });
  }

  function trust(data) {
    const sentences = trustSentences(data);
    const variations = data.test?.variations;
    if (sentences.length) return html("p", { class: "trust warning" }, sentences.join(" "));
    return html("p", { class: "trust" }, variations ? `No rollout of the ${count(variations)} test variations is ` +
      "untrusted: all converged and kept their certificates." : "The run has no test.");
  }

  function make(data) {
    const { run = {}, knap: build = {} } = data;
    const measure = measureOf(data);
    const rollouts = run.rollouts?.total !== undefined ? ` from ${counted(run.rollouts.total, "rollout")}` : "";
    const facts = [
      data.test?.variations !== undefined && `${counted(data.test.variations, "test variation")} of seed ${data.test.seed}`,
      run.method && `method ${run.method}, seed ${run.seed}`,
      run.wall_s !== undefined && `learned in ${duration(run.wall_s)}${rollouts}`,
      run.started && `started ${run.started.replace("T", " ").replace("Z", " UTC")}${run.host ? ` on ${run.host}` : ""}`,
      build.version && `knap ${build.version}${build.build ? ` (${build.build})` : ""}`,
    ].filter(Boolean);
    return html("div", { class: "summary" }, headline(measure), intervalDrawing(measure), trust(data),
      html("p", { class: "facts" }, facts.join(" · ")));
  }

  // Rows of the test's summary beyond the headline, for both designs.
  function testTable(data) {
    const unit = data.loss_unit ?? "";
    const interval = (values, text) => (values ? ` (${values.map(text).join(" to ")})` : "");
    const loss = (value) => quantity(value, unit);
    const rows = [
      ["mean loss (95% interval)", (s) => loss(s.loss_mean) + interval(s.loss_mean_95, loss)],
      ["standard deviation of the loss", (s) => loss(s.loss_std)],
      ["mean of the worst tenth", (s) => loss(s.worst_decile_loss)],
      ["success (95% interval)", (s) => (s.success_rate === null || s.success_rate === undefined ? "none defined" :
        percent(s.success_rate) + interval(s.success_rate_95, percent))],
      ["not converged", (s) => count(s.not_converged ?? 0)],
      ["not finite", (s) => count(s.not_finite ?? 0)],
      ["not trusted", (s) => count(s.untrusted ?? 0)],
    ];
    const designs = knap.designs.filter((design) => data.test?.[design]);
    if (!designs.length) return null;
    return knap.elements.table(`The test: ${counted(data.test.variations, "variation")} that learning never saw`,
      ["", ...designs], rows.map(([name, text]) => [name, ...designs.map((design) => text(data.test[design]))]), [1, 2]);
  }

  // The share of a body's half width that the deepest contact used up is what makes a contact doubtful.
  function certificates(data) {
    const own = data.certificates;
    if (!own) return null;
    const of = (part, whole, noun, what) => (part ? `${count(part)} of ${counted(whole, noun)} ${what}` :
      `None of ${counted(whole, noun)} ${what}`);
    const sentences = [
      own.gradients !== undefined && `${of(own.gradients_flagged, own.gradients, "gradient", "was flagged")}: a flag says ` +
        "that a rollout passed a switch so closely that its gradient may not hold.",
      own.rollouts !== undefined && `${of(own.untrusted, own.rollouts, "rollout", "was not to be trusted")}; what is not ` +
        "trusted takes no part in the learning.",
      own.deepest !== undefined && own.deepest !== null && `The deepest contact used up ${percent(own.deepest)} of the ` +
        "depth that its bodies have.",
      own.largest_force !== undefined && own.largest_force !== null && `The largest contact force was ` +
        `${quantity(own.largest_force, "N")}.`,
    ].filter(Boolean);
    return html("div", { class: "certificates" },
      html("ul", null, ...sentences.map((sentence) => html("li", null, sentence))), testTable(data));
  }

  function repeat(data) {
    if (!data.repeat?.length) return null;
    const items = data.repeat.map((command) => {
      const code = html("code", null, command);
      return html("li", null, html("pre", null, code), copyButton(code, `Copy: ${command}`));
    });
    const { run = {} } = data;
    return html("div", { class: "repeat" }, html("ol", null, ...items),
      html("p", { class: "hint" }, [run.name && `Run ${run.name}`, run.config_hash && `configuration ${run.config_hash}`]
        .filter(Boolean).join(", ")));
  }

  knap.summary = { make, certificates, repeat };
})(window.knap = window.knap || {});
