// The bodies of the run, and the picture that they make at a time: what a view draws.
(function (knap) {
  "use strict";
  const { fromPose, identity, multiply, transformPoint, scale, unit } = knap.matrices;

  // How many moments of a recording the camera's frame looks at; enough for a swing to be seen whole.
  const framedMoments = 24;

  class Scene {
    constructor(data) {
      const fixed = data.fixed_poses ?? {};
      let movers = 0;
      this.bodies = (data.bodies ?? []).map((body) => {
        const shapes = (body.shapes ?? []).filter(Boolean);
        const place = fixed[body.name];
        return {
          name: body.name,
          mover: body.moves ? movers++ : null,
          pose: place ? fromPose(place.slice(0, 3), place.slice(3)) : identity(),
          shapes: shapes.filter((shape) => shape.type !== "half_space"),
          planes: shapes.filter((shape) => shape.type === "half_space").map(knap.meshes.poseOf),
          designed: shapes.some((shape) => shape.designed),
        };
      });
      this.movers = movers;
      this.up = unit(scale(data.gravity ?? [0, 0, -1], -1));
      this.surfaces = new Map();
    }

    // Shapes are alike in many links of a rope: each is made once.
    surface(shape, design, detail) {
      const key = shape.type === "mesh" ? shape : JSON.stringify(shape);
      const variant = shape.type === "mesh" ? design : detail;
      if (!this.surfaces.has(key)) this.surfaces.set(key, new Map());
      const made = this.surfaces.get(key);
      if (!made.has(variant)) made.set(variant, knap.meshes.fromShape(shape, design, detail));
      return made.get(variant);
    }

    // What was learned is another design from now on.
    reshape(theta) {
      for (const shape of this.bodies.flatMap((body) => body.shapes)) {
        if (!shape.designed || shape.type !== "mesh") continue;
        const mesh = new knap.DesignedMesh(shape, identity(), theta.initial);
        if (mesh.basis) this.surfaces.get(shape)?.set("learned", mesh.surface(mesh.verticesAt(theta.learned)));
      }
    }

    poseOf(body, recording, time) {
      return body.mover === null ? body.pose : recording.poseAt(time, body.mover);
    }

    // Free bodies leave a path; a rope's links would cover the picture with theirs.
    hasPath(body) {
      return body.mover !== null && !body.designed && this.movers <= 4;
    }

    // What a view draws at a time. A body whose pose is not finite is left out.
    pictureAt(recording, time, detail, { showForces, showPaths, metersPerNewton, size }) {
      const picture = { solids: [], planes: [], lines: [], arrows: [] };
      for (const body of this.bodies) {
        const pose = this.poseOf(body, recording, time);
        if (!pose) continue;
        for (const plane of body.planes) picture.planes.push({ pose: multiply(pose, plane) });
        const still = body.mover === null ? "fixed" : "moving";
        const colour = body.designed ? recording.about.design : still;
        for (const shape of body.shapes) {
          const surface = this.surface(shape, recording.about.design, detail);
          if (surface) picture.solids.push({ surface, pose, colour, alpha: 1 });
        }
        if (showPaths && this.hasPath(body)) {
          picture.lines.push({ points: recording.pathUntil(time, body.mover), colour: "muted" });
        }
      }
      if (showForces) picture.arrows = this.arrows(recording, time, metersPerNewton, size);
      return picture;
    }

    // No arrow is longer than the scene: a blow of many times the usual force would hide it.
    arrows(recording, time, metersPerNewton, size) {
      return recording.forcesAt(time).map(({ force, at }) => {
        const length = knap.matrices.norm(force) * metersPerNewton;
        return { from: at, vector: scale(force, metersPerNewton * Math.min(1, size / length)), colour: "force" };
      });
    }

    // The body to stay with: the first designed one that moves; null if none does.
    leader() {
      return this.bodies.find((body) => body.designed && body.mover !== null)?.mover ?? null;
    }

    // Corners of boxes around the bodies at one time, or if that is null at moments of the whole recordings: of
    // designed bodies at all of them, of the others where they stay within reach of what there was at the start.
    frame(recordings, time) {
      const corners = (bodies, momentsOf) => {
        const points = [];
        for (const body of bodies) {
          const local = this.cornersOf(body);
          for (const recording of recordings) {
            for (const moment of body.mover === null ? [0] : momentsOf(recording)) {
              const pose = this.poseOf(body, recording, moment);
              if (pose) points.push(...local.map((corner) => transformPoint(pose, corner)));
            }
          }
        }
        return points;
      };
      const finite = this.bodies.filter((body) => body.shapes.length);
      const moments = (recording) => momentsOf(recording, time);
      const begin = () => [time ?? 0];
      const core = [...corners(finite, begin), ...corners(finite.filter((body) => body.designed), moments)];
      return [...core, ...withinReach(corners(finite, moments), core)];
    }

    cornersOf(body) {
      const surfaces = body.shapes.flatMap((shape) =>
        (body.designed ? ["initial", "learned"] : ["initial"]).map((design) => this.surface(shape, design, 4)));
      return cornersOfBox(boxAround(surfaces.filter(Boolean).map((surface) => surface.positions)));
    }
  }

  function momentsOf(recording, time) {
    if (time !== null) return [time];
    return Array.from({ length: framedMoments }, (_, i) => (recording.end * i) / (framedMoments - 1));
  }

  function boxAround(arrays) {
    const box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
    for (const positions of arrays) {
      for (let i = 0; i < positions.length; ++i) {
        box.low[i % 3] = Math.min(box.low[i % 3], positions[i]);
        box.high[i % 3] = Math.max(box.high[i % 3], positions[i]);
      }
    }
    return box;
  }

  function cornersOfBox({ low, high }) {
    if (!(low[0] <= high[0])) return [];
    return [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [0, 1, 2].map((axis) => ((i >> axis) & 1 ? high[axis] : low[axis])));
  }

  // Those that lie within the box around `core`, or beside it by no more than a third of its size.
  function withinReach(points, core) {
    if (!core.length) return points;
    const { low, high } = boxAround([core.flat()]);
    const margin = knap.matrices.norm(knap.matrices.subtract(high, low)) / 3;
    return points.filter((point) => point.every((x, axis) => x >= low[axis] - margin && x <= high[axis] + margin));
  }

  knap.Scene = Scene;
  knap.frames = { boxAround, cornersOfBox };
})(window.knap = window.knap || {});
