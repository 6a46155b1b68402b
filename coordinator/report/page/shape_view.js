// The designed bodies after each batch, and each parameter inside its bounds; sliders try other values.
(function (knap) {
  "use strict";
  const { html, svg } = knap.elements;
  const { quantity } = knap.quantities;

  // One designed mesh: vertices are linear in the parameters, vertices(theta) = initial + Σ (theta − initial) basis.
  class DesignedMesh {
    constructor(shape, pose, initialTheta) {
      this.pose = pose;
      this.triangles = knap.decoding.integers(shape.triangles);
      this.initial = knap.decoding.floats(shape.vertices.initial);
      this.learned = shape.vertices.learned ? knap.decoding.floats(shape.vertices.learned) : this.initial;
      this.basis = shape.basis ? knap.decoding.floats(shape.basis) : null;
      this.initialTheta = initialTheta;
      if (this.basis && this.basis.length !== this.initial.length * initialTheta.length) this.basis = null;
    }

    verticesAt(theta) {
      const vertices = this.initial.slice();
      theta.forEach((value, k) => {
        const change = value - this.initialTheta[k];
        if (change === 0) return;
        const start = k * vertices.length;
        for (let i = 0; i < vertices.length; ++i) vertices[i] += change * this.basis[start + i];
      });
      return vertices;
    }

    surface(vertices) {
      return knap.meshes.mesh(vertices, this.triangles);
    }
  }

  function designedMeshes(data, scene, theta) {
    return scene.bodies.flatMap((body) => {
      const pose = body.mover === null ? body.pose : firstPose(data, scene, body);
      return body.shapes.filter((shape) => shape.designed && shape.type === "mesh")
        .map((shape) => new DesignedMesh(shape, pose, theta.initial));
    });
  }

  function firstPose(data, scene, body) {
    const replay = data.replays?.[0];
    const pose = replay && new knap.Recording(replay, scene.movers).poseAt(0, body.mover);
    return pose ?? knap.matrices.identity();
  }

  // The shapes that the slider goes through: the initial one, the one after each batch, the learned one.
  function stepsOf(theta, learning) {
    const steps = [{ name: "initial", theta: theta.initial }];
    for (const batch of learning?.batches ?? []) {
      const whole = batch.theta?.length === theta.initial.length;
      if (whole) steps.push({ name: `batch ${batch.batch}`, theta: batch.theta });
    }
    const last = steps[steps.length - 1];
    if (last.theta.every((value, k) => value === theta.learned[k]) && steps.length > 1) last.name += ", learned";
    else steps.push({ name: "learned", theta: theta.learned });
    return steps;
  }

  class ShapeView {
    constructor(data, scene) {
      this.theta = data.theta;
      this.meshes = designedMeshes(data, scene, this.theta);
      this.steps = stepsOf(this.theta, data.learning);
      this.mayTry = this.meshes.length > 0 && this.meshes.every((mesh) => mesh.basis !== null);
      this.camera = new knap.Camera(scene.up);
      this.node = html("div", { class: "shape" }, this.meshes.length ? this.makeStage() : null, this.makeParameters());
      this.showStep(this.steps.length - 1);
    }

    // The run has a design more; who looked at the latest goes on to it.
    update(data) {
      const atLast = this.step === this.steps.length - 1 && this.label.textContent !== "tried";
      this.theta = data.theta;
      this.steps = stepsOf(this.theta, data.learning);
      this.slider.max = this.steps.length - 1;
      for (const row of this.rows) row.mark();
      if (atLast) this.showStep(this.steps.length - 1);
    }

    makeStage() {
      this.view = new knap.View("Shape of the tool", this.camera, () => this.picture());
      this.view.onResize = () => this.frame();
      knap.attachCamera(this.view.canvas, this.camera, () => this.view.redraw(), () => this.reset());
      this.ghost = html("input", { type: "checkbox", checked: true, onchange: () => this.view.redraw() });
      return html("div", { class: "stage" }, html("div", { class: "canvas" }, this.view.canvas),
        html("p", { class: "hint" }, html("label", null, this.ghost, " initial shape, clear"), " · drag to turn"));
    }

    makeParameters() {
      this.slider = html("input", { type: "range", class: "steps", min: 0, max: this.steps.length - 1, step: 1,
        "aria-label": "Shape after batch", oninput: () => this.showStep(Number(this.slider.value)) });
      this.label = html("output");
      this.note = html("p", { class: "hint" });
      this.rows = this.theta.names.map((name, k) => this.makeRow(name, k));
      return html("div", { class: "parameters" },
        html("div", { class: "controls" }, html("span", null, "Shape: "), this.slider, this.label),
        html("div", { class: "rows" }, ...this.rows.map((row) => row.node)), this.note);
    }

    makeRow(name, k) {
      const [lower, upper] = [this.theta.lower[k], this.theta.upper[k]];
      const unit = this.theta.kinds?.[k] ?? "";
      const input = html("input", { type: "range", min: lower, max: upper, step: "any", disabled: !this.mayTry,
        "aria-label": `Try ${name}`, oninput: () => this.tryValues() });
      const value = html("output", { class: "value" });
      const marks = html("span", { class: "marks", "aria-hidden": "true" });
      const mark = () => marks.replaceChildren(...knap.designs.map((design) => {
        const own = this.theta[design][k];
        const node = html("span", { class: `mark ${design}`, title: `${design} ${quantity(own, unit)}` });
        // The middle of a slider's thumb stays half its width inside the ends.
        const share = upper > lower ? (own - lower) / (upper - lower) : 0;
        node.style.left = `calc(7px + ${share} * (100% - 14px))`;
        return node;
      }));
      mark();
      const node = html("div", { class: "row" }, html("span", { class: "name" }, name),
        html("span", { class: "bound" }, quantity(lower, unit)), html("span", { class: "bar" }, marks, input),
        html("span", { class: "bound" }, quantity(upper, unit)), value);
      return { node, input, value, unit, mark };
    }

    showStep(step) {
      this.step = step;
      this.slider.value = step;
      this.label.textContent = this.steps[step].name;
      this.slider.setAttribute("aria-valuetext", this.steps[step].name);
      this.steps[step].theta.forEach((value, k) => { this.rows[k].input.value = value; });
      this.note.textContent = this.noteFor(step);
      // A slider's value is rounded as its text; what was learned is shown as it is.
      this.showTheta(this.steps[step].theta);
    }

    noteFor(step) {
      const marks = "○ initial, ● learned. ";
      const between = step > 0 && step < this.steps.length - 1;
      if (this.mayTry) return `${marks}Move a parameter to try a shape; the upper slider goes back to the batches.`;
      if (!this.meshes.length || !between) return marks;
      return `${marks}For the batches this file holds the parameters alone; the shape drawn is the initial one.`;
    }

    tryValues() {
      this.label.textContent = "tried";
      this.showTheta(this.rows.map((row) => Number(row.input.value)));
    }

    showTheta(theta) {
      theta.forEach((value, k) => { this.rows[k].value.textContent = quantity(value, this.rows[k].unit); });
      this.surfaces = this.meshes.map((mesh) => mesh.surface(this.verticesOf(mesh, theta)));
      this.view?.redraw();
    }

    verticesOf(mesh, theta) {
      if (mesh.basis) return mesh.verticesAt(theta);
      return this.step === this.steps.length - 1 ? mesh.learned : mesh.initial;
    }

    picture() {
      const solids = this.meshes.map((mesh, i) =>
        ({ surface: this.surfaces[i], pose: mesh.pose, colour: "learned", alpha: 1, transient: true }));
      if (this.ghost.checked) {
        for (const mesh of this.meshes) {
          mesh.initialSurface ??= mesh.surface(mesh.initial);
          solids.push({ surface: mesh.initialSurface, pose: mesh.pose, colour: "initial", alpha: 0.18 });
        }
      }
      return { solids, planes: [], lines: [], arrows: [] };
    }

    reset() {
      this.camera.turn(...knap.Camera.start);
      this.frame();
    }

    frame() {
      const points = this.meshes.flatMap((mesh) =>
        knap.frames.cornersOfBox(knap.frames.boxAround([mesh.initial, mesh.learned]))
          .map((corner) => knap.matrices.transformPoint(mesh.pose, corner)));
      this.camera.fit(points, this.view.aspect || 4 / 3);
      this.view.redraw();
    }
  }

  knap.DesignedMesh = DesignedMesh;
  knap.ShapeView = ShapeView;
})(window.knap = window.knap || {});
