// Shapes as triangles to draw: { positions, normals } with nine numbers a triangle, { edges } with six a line.
(function (knap) {
  "use strict";
  const { add, subtract, cross, dot, norm, unit, fromPose, transformDirection, transformPoint } = knap.matrices;

  // Faces that meet at less than this look like one curved surface; the rest get a drawn edge.
  const creaseCosine = Math.cos((32 * Math.PI) / 180);

  // A triangle is split into at most 2 to this many.
  const mostSplits = 8;

  // Turns a profile of [distance from the axis, height, normal outwards, normal upwards] about z.
  function revolve(profile, segments) {
    const positions = [];
    const normals = [];
    const corner = ([rho, z, out, up], k) => {
      const [c, s] = [Math.cos((2 * Math.PI * k) / segments), Math.sin((2 * Math.PI * k) / segments)];
      positions.push(rho * c, rho * s, z);
      normals.push(out * c, out * s, up);
    };
    for (let i = 0; i + 1 < profile.length; ++i) {
      const [low, high] = [profile[i], profile[i + 1]];
      for (let k = 0; k < segments; ++k) {
        if (low[0] > 0) for (const [point, at] of [[low, k], [low, k + 1], [high, k + 1]]) corner(point, at);
        if (high[0] > 0) for (const [point, at] of [[low, k], [high, k + 1], [high, k]]) corner(point, at);
      }
    }
    return { positions: new Float32Array(positions), normals: new Float32Array(normals), edges: new Float32Array(0) };
  }

  // `rings` counts the bands of one half sphere.
  function capsule(radius, length, rings, segments) {
    const profile = [];
    for (const side of [-1, 1]) {
      for (let i = 0; i <= rings; ++i) {
        const latitude = ((side < 0 ? i - rings : i) / rings) * (Math.PI / 2);
        const pole = i === (side < 0 ? 0 : rings);
        const [out, up] = [pole ? 0 : Math.cos(latitude), Math.sin(latitude)];
        profile.push([radius * out, radius * up + (side * length) / 2, out, up]);
      }
    }
    return revolve(profile, segments);
  }

  function cylinder(radius, length, segments) {
    const half = length / 2;
    const solid = revolve([[0, -half, 0, -1], [radius, -half, 0, -1], [radius, -half, 1, 0], [radius, half, 1, 0],
      [radius, half, 0, 1], [0, half, 0, 1]], segments);
    const edges = [];
    for (const z of [-half, half]) {
      for (let k = 0; k < segments; ++k) {
        for (const end of [k, k + 1]) {
          const angle = (2 * Math.PI * end) / segments;
          edges.push(radius * Math.cos(angle), radius * Math.sin(angle), z);
        }
      }
    }
    return { ...solid, edges: new Float32Array(edges) };
  }

  function box(size) {
    const vertices = [];
    for (let i = 0; i < 8; ++i) {
      vertices.push(...size.map((length, axis) => (i & (1 << axis) ? 0.5 : -0.5) * length));
    }
    const triangles = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2,
      1, 3, 7, 1, 7, 5];
    return mesh(vertices, triangles);
  }

  function faceNormals(vertices, triangles) {
    const at = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
    const faces = [];
    for (let f = 0; f + 2 < triangles.length; f += 3) {
      const [a, b, c] = [at(triangles[f]), at(triangles[f + 1]), at(triangles[f + 2])];
      const areaVector = cross(subtract(b, a), subtract(c, a));
      faces.push({ corners: [a, b, c], areaVector, normal: unit(areaVector) });
    }
    return faces;
  }

  function facesAtVertices(triangles) {
    const around = new Map();
    triangles.forEach((vertex, i) => {
      if (!around.has(vertex)) around.set(vertex, []);
      around.get(vertex).push(Math.floor(i / 3));
    });
    return around;
  }

  // Edges between faces at an angle, and edges of one face alone.
  function featureEdges(triangles, faces) {
    const open = new Map();
    const edges = [];
    const keep = (face, k) => edges.push(...faces[face].corners[k], ...faces[face].corners[(k + 1) % 3]);
    for (let face = 0; face < faces.length; ++face) {
      for (let k = 0; k < 3; ++k) {
        const [from, to] = [triangles[3 * face + k], triangles[3 * face + ((k + 1) % 3)]];
        const opposite = open.get(`${to} ${from}`);
        if (opposite === undefined) {
          open.set(`${from} ${to}`, { face, k });
        } else {
          open.delete(`${to} ${from}`);
          if (dot(faces[face].normal, faces[opposite.face].normal) < creaseCosine) keep(face, k);
        }
      }
    }
    for (const { face, k } of open.values()) keep(face, k);
    return edges;
  }

  // A triangle mesh: smooth where it is meant to be round, flat and edged where it is not.
  function mesh(vertices, triangles) {
    const faces = faceNormals(vertices, triangles);
    const around = facesAtVertices(triangles);
    const positions = new Float32Array(9 * faces.length);
    const normals = new Float32Array(9 * faces.length);
    faces.forEach((face, f) => {
      face.corners.forEach((point, k) => {
        const near = around.get(triangles[3 * f + k]).filter((g) => dot(faces[g].normal, face.normal) > creaseCosine);
        const sum = near.reduce((total, g) => add(total, faces[g].areaVector), [0, 0, 0]);
        positions.set(point, 9 * f + 3 * k);
        normals.set(unit(sum, face.normal), 9 * f + 3 * k);
      });
    });
    return { positions, normals, edges: new Float32Array(featureEdges(triangles, faces)) };
  }

  // The surface with triangles split across their longest sides until none is longer: for painters, who order whole
  // triangles by their distance, and go wrong with long ones.
  function refine(surface, longest) {
    const positions = [];
    const normals = [];
    const middle = (a, b) => ({
      at: add(a.at, b.at).map((x) => x / 2), normal: unit(add(a.normal, b.normal), a.normal),
    });
    const split = (a, b, c, depth) => {
      const sides = [[a, b, c], [b, c, a], [c, a, b]].map((side) => [norm(subtract(side[0].at, side[1].at)), side]);
      const [length, [from, to, apex]] = sides.reduce((most, side) => (side[0] > most[0] ? side : most));
      if (length <= longest || depth === 0) {
        for (const { at, normal } of [a, b, c]) {
          positions.push(...at);
          normals.push(...normal);
        }
        return;
      }
      const between = middle(from, to);
      split(from, between, apex, depth - 1);
      split(between, to, apex, depth - 1);
    };
    for (let i = 0; i < surface.positions.length; i += 9) {
      split(...[i, i + 3, i + 6].map((k) => ({
        at: Array.from(surface.positions.subarray(k, k + 3)), normal: Array.from(surface.normals.subarray(k, k + 3)),
      })), mostSplits);
    }
    return { ...surface, positions: new Float32Array(positions), normals: new Float32Array(normals) };
  }

  // An arrow from `from` along `vector`; its head keeps its form and shrinks with an arrow too short for it.
  function arrow(from, vector, thickness) {
    const length = norm(vector);
    const head = Math.min(5 * thickness, 0.6 * length);
    const width = Math.min(1, head / (5 * thickness));
    const [shaft, barb] = [thickness * width, 2.2 * thickness * width];
    const surface = revolve([[0, 0, 0, -1], [shaft, 0, 0, -1], [shaft, 0, 1, 0], [shaft, length - head, 1, 0],
      [barb, length - head, 0, -1], [barb, length - head, 0.9, 0.4], [0, length, 0.9, 0.4]], 10);
    const axis = unit(vector);
    const side = knap.matrices.perpendicular(axis);
    const pose = new Float32Array([...side, 0, ...cross(axis, side), 0, ...axis, 0, ...from, 1]);
    return { surface, pose };
  }

  // Of one of the data's shapes in its body.
  function poseOf(shape) {
    const [x, y, z, ...quaternion] = shape.pose ?? [0, 0, 0, 1, 0, 0, 0];
    return fromPose([x, y, z], quaternion);
  }

  function place(pose, { positions, normals, edges }) {
    const map = (array, change) => {
      const out = new Float32Array(array.length);
      for (let i = 0; i < array.length; i += 3) out.set(change(pose, array.subarray(i, i + 3)), i);
      return out;
    };
    return {
      positions: map(positions, transformPoint), normals: map(normals, transformDirection),
      edges: map(edges, transformPoint),
    };
  }

  // One of the data's shapes, in its body; `detail` counts the bands of a quarter circle. Half-spaces are drawn as
  // grids instead.
  function fromShape(shape, design, detail) {
    const surface = atOrigin(shape, design, detail);
    return surface && shape.pose ? place(poseOf(shape), surface) : surface;
  }

  function atOrigin(shape, design, detail) {
    switch (shape.type) {
      case "sphere": return capsule(shape.radius, 0, detail + 2, 4 * detail + 4);
      case "capsule": return capsule(shape.radius, shape.length, detail, 4 * detail);
      case "cylinder": return cylinder(shape.radius, shape.length, 6 * detail);
      case "box": return box(shape.size);
      case "mesh": {
        const vertices = shape.vertices[design] ?? shape.vertices.initial;
        return mesh(knap.decoding.floats(vertices), knap.decoding.integers(shape.triangles));
      }
      default: return null;
    }
  }

  knap.meshes = { mesh, refine, arrow, fromShape, poseOf };
})(window.knap = window.knap || {});
