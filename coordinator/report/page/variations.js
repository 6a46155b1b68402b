// The test variations and what both designs made of them.
(function (knap) {
  "use strict";

  const designs = ["initial", "learned"];

  class Variations {
    constructor(data) {
      const variation = data.variation ?? {};
      this.keys = variation.keys ?? [];
      this.values = variation.values ?? [];
      this.results = { initial: variation.initial, learned: variation.learned };
      this.hasSuccess = data.has_success === true;
      this.lossUnit = data.loss_unit ?? "";
      this.takeReplays(data.replays ?? []);
    }

    takeReplays(replays) {
      this.replays = new Map();
      for (const replay of replays) {
        if (!this.replays.has(replay.variation)) this.replays.set(replay.variation, {});
        this.replays.get(replay.variation)[replay.design] = replay;
      }
    }

    get count() {
      return Math.max(this.values.length, ...designs.map((design) => this.results[design]?.loss?.length ?? 0));
    }

    // undefined where a design was not tested, null where its rollout failed.
    loss(design, row) {
      const replay = this.replays.get(row)?.[design];
      return this.results[design]?.loss?.[row] ?? replay?.loss ?? (this.tested(design, row) ? null : undefined);
    }

    tested(design, row) {
      return row < (this.results[design]?.loss?.length ?? 0) || this.replays.get(row)?.[design] !== undefined;
    }

    success(design, row) {
      if (!this.hasSuccess || !this.tested(design, row)) return null;
      const told = this.results[design]?.success?.[row] ?? this.replays.get(row)?.[design]?.success;
      return told === undefined || told === null ? null : Boolean(told);
    }

    // Why a rollout is not to be trusted; empty if it is.
    distrust(design, row) {
      return this.results[design]?.distrust?.[row] || (this.replays.get(row)?.[design]?.distrust ?? []).join("; ");
    }

    // Whether the rollout passed a switch so closely that its gradient may not hold; false where nothing is said.
    gradientFlagged(design, row) {
      const told = this.results[design]?.gradient_reliable?.[row];
      return told !== undefined && told !== null && !told;
    }

    embedded(row) {
      return this.replays.has(row);
    }

    // Variations with a replay, those first that the learned tool does worst at; failed ones before all.
    worstFirst() {
      const badness = (row) => {
        const loss = this.loss("learned", row) ?? this.loss("initial", row);
        return loss === null || loss === undefined ? Infinity : loss;
      };
      return [...this.replays.keys()].sort((a, b) => badness(b) - badness(a) || a - b);
    }

    lossText(design, row) {
      const loss = this.loss(design, row);
      return loss === undefined ? "not tested" : knap.quantities.quantity(loss, this.lossUnit);
    }

    // The same as part of a sentence: "loss 3 mm²", "failed".
    lossPhrase(design, row) {
      const known = Number.isFinite(this.loss(design, row) ?? NaN);
      return `${known ? "loss " : ""}${this.lossText(design, row)}`;
    }

    keyText(row, k) {
      return knap.quantities.quantity(this.values[row]?.[k] ?? null, this.keys[k].unit);
    }

    // A short name of a key: "pea position[0]" of "bodies.pea.initial.position[0]".
    static shortName(key) {
      return key.replace(/^(bodies|grips|policy|rollout)\./, "").replace(".initial.", " ").replaceAll(".", " ");
    }
  }

  knap.Variations = Variations;
  knap.designs = designs;
})(window.knap = window.knap || {});
