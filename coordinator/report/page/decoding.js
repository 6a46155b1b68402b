// Numbers that the page carries as base64 of little-endian arrays, which is what every browser's machine uses.
(function (knap) {
  "use strict";

  function bytes(text) {
    const letters = atob(text ?? "");
    const array = new Uint8Array(letters.length);
    for (let i = 0; i < letters.length; ++i) array[i] = letters.charCodeAt(i);
    return array.buffer;
  }

  const floats = (text) => new Float32Array(bytes(text));
  const integers = (text) => new Uint32Array(bytes(text));

  // The 64 bits of a number, as hexadecimal digits: what "the same result" means to a reader who compares.
  function bitsOf(number) {
    const view = new DataView(new ArrayBuffer(8));
    view.setFloat64(0, number);
    return view.getBigUint64(0).toString(16).padStart(16, "0");
  }

  knap.decoding = { floats, integers, bitsOf };
})(window.knap = window.knap || {});
