// A 3-D view in the page: a canvas of the right number of pixels, drawn by WebGL where there is any.
(function (knap) {
  "use strict";
  const { add, scale, subtract, dot, unit } = knap.matrices;

  // From above, beside where the eye is at first: sides differ in shade, and shadows lie beside bodies.
  knap.keyLight = (camera) => unit(add(camera.up, add(scale(camera.east, 0.12), scale(camera.north, -0.7))));

  // Where a point lies above a plane, in the plane's own x and y.
  knap.onPlane = (pose, point) => {
    const offset = subtract(point, [pose[12], pose[13], pose[14]]);
    return [dot(offset, [pose[0], pose[1], pose[2]]), dot(offset, [pose[4], pose[5], pose[6]])];
  };

  // 1, 2 or 5 times a power of ten, about an eighth of the scene.
  function gridStepFor(size) {
    const wanted = size / 8;
    const power = 10 ** Math.floor(Math.log10(wanted));
    return power * [1, 2, 5, 10].find((step) => step * power >= wanted * 0.999);
  }

  // Drawings are kept, so that printing and the page's test see what the reader sees.
  const contextOptions = { antialias: true, stencil: true, preserveDrawingBuffer: true };

  function makeRenderer(makeCanvas) {
    const canvas = makeCanvas();
    const gl = canvas.getContext("webgl2", contextOptions);
    if (!gl) return new knap.CanvasView(canvas, canvas.getContext("2d"));
    try {
      return new knap.WebglView(canvas, gl);
    } catch (error) {
      // Graphics may die at any time, also while shaders compile. A canvas that had WebGL gives no other context.
      if (!gl.isContextLost()) throw error;
      const plain = makeCanvas();
      return new knap.CanvasView(plain, plain.getContext("2d"));
    }
  }

  // `picture(detail)` makes what is to be drawn. redraw() asks for a drawing at the next frame of the screen.
  class View {
    constructor(label, camera, picture) {
      const attributes = { tabindex: 0, role: "img", "aria-label": label, class: "view" };
      this.renderer = makeRenderer(() => knap.elements.html("canvas", attributes));
      this.canvas = this.renderer.canvas;
      this.camera = camera;
      this.picture = picture;
      this.asked = false;
      knap.elements.onSize(this.canvas, () => this.resize());
    }

    get aspect() {
      return this.canvas.width / this.canvas.height;
    }

    get gridStep() {
      return gridStepFor(this.camera.size);
    }

    resize() {
      const ratio = devicePixelRatio || 1;
      const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((x) => Math.round(x * ratio));
      if (!width || !height || (width === this.canvas.width && height === this.canvas.height)) return;
      this.canvas.width = width;
      this.canvas.height = height;
      this.onResize?.();
      this.draw();
    }

    redraw() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => this.draw());
    }

    draw() {
      this.asked = false;
      const scale = { gridStep: this.gridStep, size: this.camera.size };
      this.renderer.draw(this.picture(this.renderer.detail), this.camera, knap.theme.palette(), scale);
    }
  }

  knap.View = View;
})(window.knap = window.knap || {});
