// Writes SI numbers for people: three digits, a unit of fitting size, a true minus sign.
(function (knap) {
  "use strict";

  // Per unit of the data, what it is shown in from which size on, largest first.
  const scales = {
    "m": [[1, 1, "m"], [1e-3, 1e-3, "mm"], [0, 1e-6, "µm"]],
    "m²": [[0.1, 1, "m²"], [0, 1e-6, "mm²"]],
    "N": [[1, 1, "N"], [1e-3, 1e-3, "mN"], [0, 1e-6, "µN"]],
    "s": [[0.5, 1, "s"], [0, 1e-3, "ms"]],
  };
  const superscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";

  function powerOfTen(exponent) {
    const digits = String(Math.abs(exponent)).replace(/\d/g, (digit) => superscripts[digit]);
    return `10${exponent < 0 ? "⁻" : ""}${digits}`;
  }

  function number(value, digits = 3) {
    if (value === null || value === undefined || Number.isNaN(value)) return "none";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size < 1e-3 || size >= 1e6) {
      const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
      return `${mantissa.replace("-", "−")}·${powerOfTen(Number(exponent))}`;
    }
    const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    return count(Number(value.toFixed(decimals)), decimals);
  }

  // Thousands are set apart by a thin space, which no language takes for a decimal mark.
  function count(value, decimals = 0) {
    if (!Number.isFinite(value)) return "?";
    const [whole, rest] = value.toFixed(decimals).replace("-", "−").split(".");
    const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u2009") : whole;
    return rest ? `${grouped}.${rest}` : grouped;
  }

  // The factor and unit in which numbers up to `largest` are best read.
  function scaleFor(largest, unit) {
    const rows = scales[unit];
    if (!rows) return { factor: 1, unit: unit ?? "" };
    const size = largest === 0 || !Number.isFinite(largest) ? 1e-3 : Math.abs(largest);
    const [, factor, name] = rows.find(([from]) => size >= from);
    return { factor, unit: name };
  }

  function quantity(value, unit, digits = 3) {
    if (value === null || value === undefined) return "failed";
    const scale = scaleFor(value, unit);
    return `${number(value / scale.factor, digits)}${scale.unit ? `\u00a0${scale.unit}` : ""}`;
  }

  function percent(share) {
    return `${Number((share * 100).toFixed(1))}%`;
  }

  function duration(seconds) {
    if (seconds < 120) return quantity(seconds, "s");
    if (seconds < 7200) return `${Math.floor(seconds / 60)}\u00a0min ${Math.round(seconds % 60)}\u00a0s`;
    return `${Math.floor(seconds / 3600)}\u00a0h ${Math.round((seconds % 3600) / 60)}\u00a0min`;
  }

  // "1 rollout", "2 rollouts".
  const counted = (value, noun) => `${count(value)} ${noun}${value === 1 ? "" : "s"}`;

  knap.quantities = { number, count, counted, scaleFor, quantity, percent, duration, powerOfTen };
})(window.knap = window.knap || {});
