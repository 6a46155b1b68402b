// A camera that orbits a point, and the gestures and keys that move it.
(function (knap) {
  "use strict";
  const { add, subtract, scale, dot, cross, unit, perpendicular } = knap.matrices;

  const slope = Math.tan((15 * Math.PI) / 180);

  class Camera {
    // Yaw and pitch from which scenes are seen at first, in radians.
    static start = [-0.95, 0.6];

    constructor(up) {
      this.aim(up);
      this.target = [0, 0, 0];
      this.distance = 1;
      this.size = 1;
      this.turn(...Camera.start);
    }

    // What is up from here on: gravity may differ from variation to variation.
    aim(up) {
      this.up = up;
      // East and north span the ground: x and y themselves where z is up.
      this.east = Math.abs(up[2]) > 0.9 ? unit(cross(cross(up, [1, 0, 0]), up)) : perpendicular(up);
      this.north = cross(up, this.east);
    }

    turn(yaw, pitch) {
      this.yaw = yaw;
      this.pitch = Math.min(1.5, Math.max(-1.5, pitch));
    }

    backward() {
      const ground = add(scale(this.east, Math.cos(this.yaw)), scale(this.north, Math.sin(this.yaw)));
      return add(scale(ground, Math.cos(this.pitch)), scale(this.up, Math.sin(this.pitch)));
    }

    // Fills the view with the points, seen from the present direction.
    fit(points, aspect) {
      if (!points.length) return;
      const box = knap.frames.boxAround([points.flat()]);
      this.target = scale(add(box.low, box.high), 0.5);
      this.size = Math.max(1e-6, knap.matrices.norm(subtract(box.high, box.low)) / 2);
      const backward = this.backward();
      const right = unit(cross(this.up, backward));
      const top = cross(backward, right);
      const needed = points.map((point) => {
        const offset = subtract(point, this.target);
        const across = Math.max(Math.abs(dot(offset, right)) / aspect, Math.abs(dot(offset, top)));
        return across / slope + dot(offset, backward);
      });
      this.distance = 1.06 * needed.reduce((most, one) => Math.max(most, one), 1e-6);
    }

    eye() {
      return add(this.target, scale(this.backward(), this.distance));
    }

    // Eye, matrix from the world to the screen, and what a point's distance along the view is measured by.
    look(aspect) {
      const eye = this.eye();
      const near = Math.max(this.distance - 6 * this.size, 0.02 * this.distance);
      const view = knap.matrices.lookAt(eye, this.target, this.up);
      const projection = knap.matrices.perspective(slope, aspect, near, this.distance + 8 * this.size);
      return { eye, near, viewProjection: knap.matrices.multiply(projection, view), backward: this.backward() };
    }

    shift(offset) {
      this.target = add(this.target, offset);
    }

    orbit(dx, dy) {
      this.turn(this.yaw - dx, this.pitch + dy);
    }

    // By shares of the view's height.
    pan(dx, dy) {
      const backward = this.backward();
      const right = unit(cross(this.up, backward));
      const reach = 2 * slope * this.distance;
      this.shift(add(scale(right, -dx * reach), scale(cross(backward, right), dy * reach)));
    }

    zoom(factor) {
      this.distance = Math.min(40 * this.size, Math.max(0.05 * this.size, this.distance * factor));
    }
  }

  // One pointer turns (moves with shift or the right button), two pinch and move.
  function followPointers(canvas, camera, changed) {
    const pointers = new Map();
    const middle = () => {
      const all = [...pointers.values()];
      const [x, y] = [0, 1].map((i) => all.reduce((sum, point) => sum + point[i], 0) / all.length);
      return { x, y, spread: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0 };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!pointers.has(event.pointerId)) return;
      const before = middle();
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      const after = middle();
      const [dx, dy] = [(after.x - before.x) / canvas.clientHeight, (after.y - before.y) / canvas.clientHeight];
      if (before.spread > 0 && after.spread > 0) camera.zoom(before.spread / after.spread);
      if (pointers.size > 1 || event.shiftKey || event.buttons & 2) camera.pan(dx, dy);
      else camera.orbit(4 * dx, 3 * dy);
      changed();
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    }
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  // The wheel zooms in a view that was clicked, or with control: a page must scroll past its pictures.
  function followWheel(canvas, camera, changed) {
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      camera.zoom(Math.exp(0.0015 * event.deltaY));
      changed();
    }, { passive: false });
  }

  function followKeys(canvas, camera, changed, reset) {
    const turns = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] };
    canvas.addEventListener("keydown", (event) => {
      if (event.shiftKey && turns[event.key]) camera.orbit(...turns[event.key]);
      else if (event.key === "+" || event.key === "=") camera.zoom(0.9);
      else if (event.key === "-") camera.zoom(1 / 0.9);
      else if (event.key === "0") reset();
      else return;
      event.preventDefault();
      event.stopPropagation();
      changed();
    });
  }

  function attach(canvas, camera, changed, reset) {
    followPointers(canvas, camera, changed);
    followWheel(canvas, camera, changed);
    followKeys(canvas, camera, changed, reset);
    canvas.addEventListener("dblclick", () => {
      reset();
      changed();
    });
  }

  knap.Camera = Camera;
  knap.attachCamera = attach;
})(window.knap = window.knap || {});
