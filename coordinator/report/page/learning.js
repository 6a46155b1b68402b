// How the learning went: losses of the optimizer's evaluations and, as a table, its batches.
(function (knap) {
  "use strict";
  const { html, table } = knap.elements;
  const { quantity, count } = knap.quantities;

  const lossSeries = [["task_loss", "task", "task"], ["distillation_loss", "distillation", "distillation"],
    ["best_loss", "best of the batch", "best"]];

  // Evaluations are numbered from 1, as the logs number them.
  const numbersOf = (evaluations) => Array.from(evaluations.loss ?? evaluations.task_loss ?? [], (_, i) => i + 1);

  function series(evaluations, field, name, style, more = {}) {
    const ys = evaluations[field];
    if (!ys?.some((value) => value !== null && Number.isFinite(value))) return null;
    return { name, style, xs: numbersOf(evaluations), ys, ...more };
  }

  // Lines before the first evaluation of each batch but the first.
  function bordersOf({ batch = [] }) {
    return batch.flatMap((value, i) => (i > 0 && value !== batch[i - 1] ? [i + 0.5] : []));
  }

  // Of each evaluation, over the variations of its batch.
  function shares(evaluations, batches) {
    const sizes = new Map(batches.map((batch) => [batch.batch, batch.variations]));
    return (evaluations.successes ?? []).map((successes, i) => {
      const size = sizes.get(evaluations.batch?.[i]);
      return size ? successes / size : null;
    });
  }

  // The same variations for all designs: what may be compared from batch to batch.
  function validationCharts(validations, lossUnit, hasSuccess) {
    const common = { xLabel: "batches learned", height: 200 };
    const xs = validations.map((one) => one.batch);
    const marks = validations.map((one) => one.best);
    const made = [{ ...common, title: "Validation: mean loss", unit: lossUnit, logarithmic: true,
      series: [{ name: "a dot: the best so far", style: "task", xs, marks,
        ys: validations.map((one) => one.loss_mean) }] }];
    if (hasSuccess) {
      made.push({ ...common, title: "Validation: share that succeeds", fromZero: true,
        series: [{ name: "a dot: the best so far", style: "best", xs, marks,
          ys: validations.map((one) => one.success_rate) }] });
    }
    return made.map((options) => new knap.LineChart(options).node);
  }

  function charts(evaluations, batches, lossUnit, hasSuccess) {
    const common = { xLabel: "evaluation", borders: bordersOf(evaluations) };
    // What is zero throughout, as distillation may be, has no place on a logarithmic axis.
    const losses = lossSeries.map(([field, name, style]) => series(evaluations, field, name, style,
      field === "task_loss" ? { marks: evaluations.accepted } : { stepped: field === "best_loss" }))
      .filter((one) => one?.ys.some((loss) => loss > 0));
    const gradient = series(evaluations, "gradient_norm", "gradient", "task");
    const made = [];
    if (losses.length) {
      made.push({ ...common, title: "Loss", unit: lossUnit, series: losses, logarithmic: true, height: 240 });
    }
    if (gradient) made.push({ ...common, title: "Norm of the gradient", series: [gradient], logarithmic: true });
    const success = hasSuccess && shares(evaluations, batches);
    if (success && success.some((share) => share !== null)) {
      const one = { name: "success", style: "best", xs: numbersOf(evaluations), ys: success, stepped: true };
      made.push({ ...common, title: "Share of the batch that succeeds", series: [one], fromZero: true });
    }
    return made.map((options) => new knap.LineChart(options).node);
  }

  function batchTable(batches, lossUnit) {
    const rows = batches.map((batch) => [String(batch.batch), quantity(batch.start_loss, lossUnit),
      quantity(batch.best_loss, lossUnit), count(batch.evaluations), batch.stop ?? ""]);
    return html("details", null, html("summary", null, `The ${batches.length} batches as a table`),
      table("Loss at the start of each batch, the best in it, and why it ended",
        ["batch", "start", "best", "evaluations", "ended"], rows, [0, 1, 2, 3]));
  }

  function make(data) {
    const { evaluations, batches = [], validations = [] } = data.learning ?? {};
    if (!evaluations || !numbersOf(evaluations).length) return null;
    return html("div", { class: "learning" },
      html("p", { class: "hint" }, "A dot is a step that the optimizer accepted; upright lines part the batches, " +
        "each of which has variations of its own, so that losses jump there."),
      html("div", { class: "charts" },
        ...(validations.length ? validationCharts(validations, data.loss_unit ?? "", data.has_success === true) : []),
        ...charts(evaluations, batches, data.loss_unit ?? "", data.has_success === true)),
      batches.length ? batchTable(batches, data.loss_unit ?? "") : null);
  }

  knap.learning = { make };
})(window.knap = window.knap || {});
