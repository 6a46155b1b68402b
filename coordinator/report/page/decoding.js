// Numbers that the page carries as base64 of little-endian arrays, which is what every browser's machine uses.
(function (knap) {
  "use strict";

  function bytes(text) {
    return Uint8Array.from(atob(text ?? ""), (letter) => letter.charCodeAt(0)).buffer;
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
