// Vectors (arrays of 3), quaternions (w, x, y, z) and 4×4 matrices (column by column, as WebGL takes them).
(function (knap) {
  "use strict";

  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const norm = (a) => Math.hypot(a[0], a[1], a[2]);

  function unit(a, otherwise = [0, 0, 1]) {
    const length = norm(a);
    return length > 0 && Number.isFinite(length) ? scale(a, 1 / length) : otherwise;
  }

  // A unit vector at right angles to `a`.
  function perpendicular(a) {
    const least = Math.abs(a[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
    return unit(cross(a, least));
  }

  function multiply(a, b) {
    const c = new Float32Array(16);
    for (let column = 0; column < 4; ++column) {
      for (let row = 0; row < 4; ++row) {
        let sum = 0;
        for (let k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
        c[4 * column + row] = sum;
      }
    }
    return c;
  }

  const transformDirection = (m, v) => [
    m[0] * v[0] + m[4] * v[1] + m[8] * v[2],
    m[1] * v[0] + m[5] * v[1] + m[9] * v[2],
    m[2] * v[0] + m[6] * v[1] + m[10] * v[2],
  ];
  const transformPoint = (m, p) => add(transformDirection(m, p), [m[12], m[13], m[14]]);

  // X_WB as a matrix, from position and quaternion; the quaternion need not be of length 1.
  function fromPose(p, [w, x, y, z]) {
    const s = 2 / (w * w + x * x + y * y + z * z || 1);
    return new Float32Array([
      1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y), 0,
      s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x), 0,
      s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y), 0,
      p[0], p[1], p[2], 1,
    ]);
  }

  const identity = () => fromPose([0, 0, 0], [1, 0, 0, 0]);

  // The shorter way round; nearly equal quaternions are mixed linearly, where the formula would divide by zero.
  function slerp(a, b, share) {
    let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const sign = cosine < 0 ? -1 : 1;
    cosine *= sign;
    let [left, right] = [1 - share, share];
    if (cosine < 0.9995) {
      const angle = Math.acos(cosine);
      left = Math.sin((1 - share) * angle) / Math.sin(angle);
      right = Math.sin(share * angle) / Math.sin(angle);
    }
    return [0, 1, 2, 3].map((i) => left * a[i] + sign * right * b[i]);
  }

  function lookAt(eye, target, up) {
    const backward = unit(subtract(eye, target));
    const right = unit(cross(up, backward));
    const top = cross(backward, right);
    return new Float32Array([
      right[0], top[0], backward[0], 0,
      right[1], top[1], backward[1], 0,
      right[2], top[2], backward[2], 0,
      -dot(right, eye), -dot(top, eye), -dot(backward, eye), 1,
    ]);
  }

  // `slope` is the tangent of half the vertical angle of view.
  function perspective(slope, aspect, near, far) {
    return new Float32Array([
      1 / (slope * aspect), 0, 0, 0,
      0, 1 / slope, 0, 0,
      0, 0, (near + far) / (near - far), -1,
      0, 0, (2 * near * far) / (near - far), 0,
    ]);
  }

  // Throws shadows along `light` (towards the light) onto the plane through `point` with unit normal n.
  function shadowOnto(point, n, light) {
    const height = dot(n, light);
    const m = new Float32Array(16);
    for (let column = 0; column < 3; ++column) {
      for (let row = 0; row < 3; ++row) {
        m[4 * column + row] = (row === column ? 1 : 0) - (light[row] * n[column]) / height;
      }
    }
    const offset = dot(n, point) / height;
    for (let row = 0; row < 3; ++row) m[12 + row] = light[row] * offset;
    m[15] = 1;
    return m;
  }

  knap.matrices = {
    add, subtract, scale, dot, cross, norm, unit, perpendicular, multiply, transformDirection, transformPoint,
    fromPose, identity, slerp, lookAt, perspective, shadowOnto,
  };
})(window.knap = window.knap || {});
