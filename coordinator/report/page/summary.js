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
    const name = data.loss_note ? `Mean loss ${data.loss_note}` : "Mean loss";
    return { name, values: pick("loss_mean"), intervals: pick("loss_mean_95"), text };
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
      const troubles = [["untrusted", "not trusted"], ["not_converged", "not converged"], ["not_finite", "not finite"]]
        .filter(([field]) => summary[field] > 0)
        .map(([field, what]) => `${count(summary[field])} ${what}`);
      if (!troubles.length) return [];
      const reasons = Object.entries(summary.distrust ?? {}).map(([reason, n]) => `${reason} (${count(n)})`);
      const why = reasons.length ? `: ${reasons.join(", ")}` : "";
      return [`Of the ${design} tool's ${count(data.test.variations)} test rollouts: ${troubles.join(", ")}${why}.`];
    });
  }

  function trust(data) {
    if (data.comparison) return null;
    const sentences = trustSentences(data);
    const variations = data.test?.variations;
    if (sentences.length) return html("p", { class: "trust warning" }, sentences.join(" "));
    return html("p", { class: "trust" }, variations ? `No rollout of the ${count(variations)} test variations is ` +
      "untrusted: all converged and kept their certificates." : "This run has no test.");
  }

  function make(data) {
    const { run = {}, knap: build = {} } = data;
    const measure = data.test ? measureOf(data) : null;
    const rollouts = run.rollouts?.total !== undefined ? ` from ${counted(run.rollouts.total, "rollout")}` : "";
    const started = run.started?.replace("T", " ").replace("Z", " UTC");
    const facts = [
      data.test && `${counted(data.test.variations, "test variation")} of seed ${data.test.seed}`,
      run.method && `method ${run.method}, seed ${run.seed}`,
      Number.isFinite(run.wall_s) && `learned in ${duration(run.wall_s)}${rollouts}`,
      started && `started ${started}${run.host ? ` on ${run.host}` : ""}`,
      build.version && `knap ${build.version}${build.build ? ` (${build.build})` : ""}`,
    ].filter(Boolean);
    const result = measure ? [headline(measure), intervalDrawing(measure)] : [];
    return html("div", { class: "summary" }, ...result, trust(data),
      html("p", { class: "facts" }, facts.join(" · ")));
  }

  // Rows of the test's summary beyond the headline, for both designs.
  function testTable(data) {
    const designs = knap.designs.filter((design) => data.test?.[design]);
    if (!designs.length) return null;
    const loss = (value) => quantity(value, data.loss_unit ?? "");
    const interval = (values, text) => (values ? ` (${values.map(text).join(" to ")})` : "");
    const success = ({ success_rate: rate, success_rate_95: ends }) => percent(rate) + interval(ends, percent);
    const rows = [
      ["mean loss (95% interval)", (s) => loss(s.loss_mean) + interval(s.loss_mean_95, loss)],
      ["standard deviation of the loss", (s) => loss(s.loss_std)],
      ["mean of the worst tenth", (s) => loss(s.worst_decile_loss)],
      data.has_success && ["success (95% interval)", (s) => (Number.isFinite(s.success_rate) ? success(s) : "none")],
      ["not converged", (s) => count(s.not_converged ?? 0)],
      ["not finite", (s) => count(s.not_finite ?? 0)],
      ["not trusted", (s) => count(s.untrusted ?? 0)],
    ].filter(Boolean);
    const cells = rows.map(([name, text]) => [name, ...designs.map((design) => text(data.test[design]))]);
    const caption = `The test: ${counted(data.test.variations, "variation")} that learning never saw`;
    return knap.elements.table(caption, ["", ...designs], cells, [1, 2]);
  }

  // "3 of 20 rollouts were flagged", "None of 20 rollouts was flagged".
  function share(part, whole, noun, what) {
    const verb = part > 1 ? "were" : "was";
    return `${part ? count(part) : "None"} of ${counted(whole, noun)} ${verb} ${what}`;
  }

  function certificates(data) {
    const own = data.certificates;
    if (!own) return testTable(data);
    const known = (value) => value !== undefined && value !== null;
    const flagged = share(own.gradients_flagged, own.gradients, "gradient", "flagged");
    const untrusted = share(own.untrusted, own.rollouts, "rollout", "untrusted");
    const sentences = [
      known(own.gradients) && `${flagged}: a flag says that a rollout passed a switch so closely that its gradient ` +
        "may not hold.",
      known(own.rollouts) && `${untrusted}; what is untrusted takes no part in the learning.`,
      known(own.deepest) && `The deepest contact used up ${percent(own.deepest)} of the depth that its bodies have.`,
      known(own.largest_force) && `The largest contact force was ${quantity(own.largest_force, "N")}.`,
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
    const { name, config_hash: hash } = data.run ?? {};
    const origin = [name && `Run ${name}`, hash && `configuration ${hash}`].filter(Boolean).join(", ");
    return html("div", { class: "repeat" }, html("ol", null, ...items), html("p", { class: "hint" }, origin));
  }

  knap.summary = { make, certificates, repeat };
})(window.knap = window.knap || {});
