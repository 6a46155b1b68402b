// Draws a picture on a 2-D canvas, far triangles first: for browsers without WebGL, and with the same calls.
(function (knap) {
  "use strict";
  const { dot, unit, subtract, transformPoint, transformDirection } = knap.matrices;

  const css = (colour, alpha = 1) =>
    `rgba(${colour.map((c) => Math.round(255 * Math.min(1, c))).join(",")},${alpha})`;

  class CanvasView {
    constructor(canvas, context) {
      this.canvas = canvas;
      this.context = context;
      // Every triangle costs a path here, so that round bodies have fewer.
      this.detail = 3;
      this.refined = new WeakMap();
    }

    // Triangles no longer than a sixth of the scene, kept until the scene is framed anew.
    refine(surface, size) {
      const kept = this.refined.get(surface);
      if (kept?.size === size) return kept.surface;
      const made = knap.meshes.refine(surface, size / 6);
      this.refined.set(surface, { size, surface: made });
      return made;
    }

    draw(picture, camera, colours, scale) {
      const { canvas, context } = this;
      this.look = camera.look(canvas.width / canvas.height);
      this.light = knap.keyLight(camera);
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.lineJoin = "round";
      for (const plane of picture.planes) this.drawGround(plane, camera, colours, scale);
      const triangles = picture.solids.flatMap((solid) => this.project(solid, camera, colours, scale.size));
      triangles.sort((a, b) => b.depth - a.depth);
      for (const triangle of triangles) this.fill(triangle);
      context.lineWidth = this.canvas.width / 500;
      for (const line of picture.lines) this.stroke(line.points, css(colours[line.colour]));
      for (const arrow of picture.arrows) this.drawArrow(arrow, css(colours[arrow.colour]), scale);
    }

    // Pixels and distance of a point of the world; null behind the eye.
    place(point) {
      const m = this.look.viewProjection;
      const w = m[3] * point[0] + m[7] * point[1] + m[11] * point[2] + m[15];
      if (w < this.look.near) return null;
      const [x, y] = transformPoint(m, point);
      return [(0.5 + (0.5 * x) / w) * this.canvas.width, (0.5 - (0.5 * y) / w) * this.canvas.height, w];
    }

    // Faces that look at the eye, with the same light as the WebGL view; of clear ones both sides.
    project({ surface, pose, colour, alpha }, camera, colours, size) {
      const projected = [];
      const { positions, normals } = this.refine(surface, size);
      for (let i = 0; i < positions.length; i += 9) {
        const world = [0, 3, 6].map((k) => transformPoint(pose, positions.subarray(i + k, i + k + 3)));
        const normal = unit(knap.matrices.cross(subtract(world[1], world[0]), subtract(world[2], world[0])));
        const toEye = unit(subtract(this.look.eye, world[0]));
        if (alpha === 1 && dot(normal, toEye) <= 0) continue;
        const corners = world.map((point) => this.place(point));
        if (corners.includes(null)) continue;
        const n = unit(transformDirection(pose, [0, 1, 2].map((k) => normals[i + k] + normals[i + 3 + k] +
          normals[i + 6 + k])));
        const shade = 0.34 + 0.09 * (1 + dot(n, camera.up)) + 0.40 * Math.max(0, dot(n, this.light)) +
          0.18 * Math.abs(dot(n, toEye));
        const depth = corners[0][2] + corners[1][2] + corners[2][2];
        projected.push({ corners, depth, style: css(colours[colour].map((c) => c * shade), alpha), alpha });
      }
      return projected;
    }

    // Neighbours would let the background shine through between them: the outline covers the seam.
    fill({ corners, style, alpha }) {
      const { context } = this;
      context.beginPath();
      for (const [x, y] of corners) context.lineTo(x, y);
      context.closePath();
      context.fillStyle = style;
      context.fill();
      if (alpha !== 1) return;
      context.strokeStyle = style;
      context.lineWidth = 1;
      context.stroke();
    }

    stroke(points, style) {
      const { context } = this;
      context.beginPath();
      let down = false;
      for (let i = 0; i + 2 < points.length; i += 3) {
        const at = this.place(points.slice(i, i + 3));
        if (at && down) context.lineTo(at[0], at[1]);
        else if (at) context.moveTo(at[0], at[1]);
        down = at !== null;
      }
      context.strokeStyle = style;
      context.stroke();
    }

    // Lines in short pieces: a piece that reaches behind the eye is left out, not drawn wrongly.
    drawGround({ pose }, camera, colours, { gridStep, size }) {
      const middle = knap.onPlane(pose, camera.target);
      const reach = Math.ceil((2 * size) / gridStep);
      const start = middle.map((x) => Math.round(x / gridStep));
      this.context.lineWidth = this.canvas.width / 900;
      for (let i = -reach; i <= reach; ++i) {
        const points = [[], []];
        for (let j = -reach; j <= reach; ++j) {
          points[0].push(...transformPoint(pose, [(start[0] + i) * gridStep, (start[1] + j) * gridStep, 0]));
          points[1].push(...transformPoint(pose, [(start[0] + j) * gridStep, (start[1] + i) * gridStep, 0]));
        }
        points.forEach((line, axis) => {
          const strong = (start[axis] + i) % 5 === 0;
          this.stroke(line, css(colours.grid, (strong ? 0.8 : 0.4) * (1 - Math.abs(i) / (reach + 1))));
        });
      }
    }

    drawArrow({ from, vector }, style, { size }) {
      const tip = knap.matrices.add(from, vector);
      const [start, end] = [this.place(from), this.place(tip)];
      if (!start || !end) return;
      const { context } = this;
      const head = Math.min(0.04 * size, 0.6 * knap.matrices.norm(vector));
      const pixels = (head * this.canvas.height) / (2 * Math.tan(Math.PI / 12) * end[2]);
      const angle = Math.atan2(end[1] - start[1], end[0] - start[0]);
      context.lineWidth = this.canvas.width / 220;
      this.stroke([...from, ...tip], style);
      context.beginPath();
      context.moveTo(end[0] + 0.5 * pixels * Math.cos(angle), end[1] + 0.5 * pixels * Math.sin(angle));
      for (const side of [2.6, -2.6]) {
        context.lineTo(end[0] + pixels * Math.cos(angle + side), end[1] + pixels * Math.sin(angle + side));
      }
      context.fillStyle = style;
      context.fill();
    }
  }

  knap.CanvasView = CanvasView;
})(window.knap = window.knap || {});
