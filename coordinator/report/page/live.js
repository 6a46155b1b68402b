// A run that goes on: how far it is and who works for it. The page asks for news every two seconds.
(function (knap) {
  "use strict";
  const { html, table } = knap.elements;
  const { number, quantity, percent, count, counted, duration } = knap.quantities;

  const period = 2000;  // [ms]
  const silence = 3;    // [s] a run speaks twice a second

  const phases = { waiting: "waiting for workers", learning: "learning", evaluating: "testing both tools on unseen " +
    "variations", done: "done, the report is being made" };

  function sentence(run) {
    const left = run.eta_s === null || run.eta_s === undefined ? "" : `, about ${duration(run.eta_s)} left`;
    const batch = run.state === "learning" && run.batch ? `, batch ${run.batch} of ${run.batches}` : "";
    return `${percent(run.progress ?? 0)}: ${phases[run.state] ?? run.state}${batch}${left}`;
  }

  function figures(run, unit) {
    const known = (value) => value !== null && value !== undefined;
    return [
      known(run.loss) && `loss ${quantity(run.loss, unit)}`,
      known(run.best_loss) && `best of the batch ${quantity(run.best_loss, unit)}`,
      counted(run.evaluations, "evaluation"),
      `${counted(run.rollouts, "rollout")} (${number(run.rollouts_per_s, 2)} a second)`,
      counted(run.workers, "worker"),
      `${count(run.open)} open`,
      run.retries > 0 && `${count(run.retries)} sent again`,
      run.rollouts_untrusted > 0 && `${counted(run.rollouts_untrusted, "rollout")} not to be trusted`,
      run.gradients_flagged > 0 && `${counted(run.gradients_flagged, "gradient")} flagged`,
      run.messages_refused > 0 && `${counted(run.messages_refused, "message")} refused`,
      `${duration(run.elapsed_s)} so far`,
    ].filter(Boolean).join(" · ");
  }

  function workerTable(workers) {
    const rows = [...workers].sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true })).map((one) => {
      const step = one.steps_total > 0 ? percent(one.steps_done / one.steps_total) : "";
      const state = one.age_s > silence ? `silent for ${duration(one.age_s)}` : one.state;
      return [one.name, one.host, state, step, percent(one.busy ?? 0), count(one.finished),
        number(one.rollouts_per_s, 2)];
    });
    return html("details", { class: "workers" }, html("summary", null, counted(workers.length, "worker")),
      table("Who works for the run now", ["worker", "host", "state", "rollout", "busy", "finished", "a second"], rows,
        [3, 4, 5, 6]));
  }

  // What stands in the place of an outcome.
  function make(data) {
    const { run, workers = [] } = data.live;
    const method = data.run?.method ? `method ${data.run.method}, seed ${data.run.seed}` : null;
    const started = data.run?.started?.replace("T", " ").replace("Z", " UTC");
    const facts = [method, started && `started ${started}${data.run.host ? ` on ${data.run.host}` : ""}`];
    const state = run ? [
      html("p", { class: "now" }, sentence(run)),
      html("progress", { max: 1, value: run.progress ?? 0, "aria-label": "Share of the run that is done" }),
      html("p", { class: "figures" }, figures(run, data.loss_unit ?? "")),
      run.age_s > silence ? html("p", { class: "warning" },
        `Nothing was heard of the coordinator for ${duration(run.age_s)}.`) : null,
    ] : [html("p", { class: "now" }, "Nothing has been heard of the run on its bus yet.")];
    return html("div", { class: "live" }, ...state, workers.length ? workerTable(workers) : null,
      html("p", { class: "facts" }, facts.filter(Boolean).join(" · ")));
  }

  const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

  function newsAddress(seen) {
    const address = new URL("news.json", location.href);
    address.search = location.search;
    address.searchParams.set("seen", seen);
    return address;
  }

  async function ask(seen) {
    try {
      const response = await fetch(newsAddress(seen), { cache: "no-store" });
      return response.ok ? await response.json() : null;
    } catch {
      return null;
    }
  }

  // Takes news into `data` and calls show(hasNewDesign). A page that nobody sees asks for none. When the run has ended,
  // its report is where this page was.
  async function follow(data, show, showSilence) {
    const replaysOf = (design) => data.replays.filter((replay) => replay.design === design);
    let heard = Date.now();
    for (;;) {
      await pause(period);
      if (document.hidden) continue;
      const news = await ask(data.live.version);
      showSilence(news ? 0 : (Date.now() - heard) / 1000);
      if (!news) continue;
      heard = Date.now();
      if (news.ended) {
        location.reload();
        return;
      }
      const { theta, replays, ...rest } = news;
      Object.assign(data, rest);
      if (theta) data.theta.learned = theta.learned;
      if (replays) data.replays = [...replaysOf("initial"), ...replays];
      show(Boolean(theta));
    }
  }

  knap.live = { make, follow };
})(window.knap = window.knap || {});
