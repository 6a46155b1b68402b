// Axes of drawings: where a value goes, and which values get a tick.
(function (knap) {
  "use strict";

  // The ends of finite numbers; for a single value some room around it.
  function rangeOf(values) {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) {
      if (value === null || !Number.isFinite(value)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    return low <= high ? [low, high] : null;
  }

  function niceStep(span, wanted) {
    const rough = span / wanted;
    const power = 10 ** Math.floor(Math.log10(rough));
    return power * [1, 2, 5, 10].find((step) => step * power >= rough * 0.999);
  }

  // An axis from `from` to `to` pixels. `tight` ends it at the values, otherwise it ends at ticks.
  function linear([low, high], [from, to], { tight = false, wanted = 4 } = {}) {
    if (high - low <= 1e-9 * Math.max(Math.abs(low), Math.abs(high))) {
      const room = Math.abs(low) * 0.1 || 1;
      [low, high] = [low - room, high + room];
    }
    const step = niceStep(high - low, wanted);
    if (!tight) [low, high] = [Math.floor(low / step + 1e-9) * step, Math.ceil(high / step - 1e-9) * step];
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const ticks = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
      ticks.push({ value: k * step, text: tickText(k * step, decimals) });
    }
    return { at: (value) => from + ((value - low) / (high - low)) * (to - from), ticks, low, high, logarithmic: false };
  }

  function tickText(value, decimals) {
    const size = Math.abs(value);
    if (size >= 1e5 || decimals > 4) return knap.quantities.number(value, 2);
    return knap.quantities.count(value, decimals);
  }

  // For positive values that span decades; values that are not positive have no place.
  function logarithmic([low, high], [from, to]) {
    const [first, last] = [Math.floor(Math.log10(low) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
    const span = Math.max(1, last - first);
    const every = Math.ceil(span / 5);
    const plain = first >= -2 && first + span <= 3;
    const ticks = [];
    for (let decade = first; decade <= first + span; decade += every) {
      ticks.push({ value: 10 ** decade, text: decadeText(decade, plain) });
    }
    const at = (value) => (value > 0 ? from + ((Math.log10(value) - first) / span) * (to - from) : NaN);
    return { at, ticks, low: 10 ** first, high: 10 ** (first + span), logarithmic: true };
  }

  function decadeText(decade, plain) {
    if (plain) return knap.quantities.count(10 ** decade, Math.max(0, -decade));
    return knap.quantities.powerOfTen(decade);
  }

  // Logarithmic where that is allowed and positive values span more than two decades; null without values.
  function fitting(values, pixels, mayBeLogarithmic) {
    const range = rangeOf(values);
    if (!range) return null;
    const positive = rangeOf(values.filter((value) => value > 0));
    const wide = range[0] >= 0 && positive && positive[1] > 100 * positive[0];
    return mayBeLogarithmic && wide ? logarithmic(positive, pixels) : linear(range, pixels);
  }

  knap.axes = { rangeOf, linear, fitting };
})(window.knap = window.knap || {});
