// Draws a picture with WebGL 2: a key light from above with its shadow, a light from the eye, edges, ground grids.
(function (knap) {
  "use strict";

  const solidVertex = `#version 300 es
    in vec3 position; in vec3 normal;
    uniform mat4 viewProjection, pose;
    out vec3 place, toward;
    void main() {
      vec4 world = pose * vec4(position, 1.0);
      place = world.xyz;
      toward = mat3(pose) * normal;
      gl_Position = viewProjection * world;
    }`;

  const solidFragment = `#version 300 es
    precision highp float;
    in vec3 place, toward;
    uniform vec3 colour, eye, up, light;
    uniform float alpha;
    out vec4 ink;
    void main() {
      vec3 toEye = normalize(eye - place);
      vec3 n = normalize(toward);
      if (dot(n, toEye) < 0.0) n = -n;
      float sky = 0.5 + 0.5 * dot(n, up);
      float key = max(dot(n, light), 0.0);
      float shine = pow(max(dot(n, normalize(light + toEye)), 0.0), 48.0);
      vec3 lit = colour * (0.34 + 0.18 * sky + 0.40 * key + 0.18 * dot(n, toEye)) + 0.10 * shine;
      ink = vec4(lit, 1.0) * alpha;
    }`;

  const flatVertex = `#version 300 es
    in vec3 position;
    uniform mat4 viewProjection, pose;
    void main() { gl_Position = viewProjection * (pose * vec4(position, 1.0)); }`;

  const flatFragment = `#version 300 es
    precision highp float;
    uniform vec3 colour;
    uniform float alpha;
    out vec4 ink;
    void main() { ink = vec4(colour, 1.0) * alpha; }`;

  const groundVertex = `#version 300 es
    in vec3 position;
    uniform mat4 viewProjection, pose;
    uniform vec2 middle;
    uniform float reach;
    out vec2 spot;
    void main() {
      spot = middle + reach * position.xy;
      gl_Position = viewProjection * (pose * vec4(spot, 0.0, 1.0));
    }`;

  const groundFragment = `#version 300 es
    precision highp float;
    in vec2 spot;
    uniform vec3 colour, gridColour;
    uniform vec2 middle;
    uniform float gridStep, reach;
    out vec4 ink;
    float onLine(float spacing) {
      vec2 width = fwidth(spot / spacing);
      vec2 away = abs(fract(spot / spacing - 0.5) - 0.5) / width;
      return (1.0 - min(min(away.x, away.y), 1.0)) * clamp(0.35 / max(width.x, width.y), 0.0, 1.0);
    }
    void main() {
      float fade = 1.0 - smoothstep(0.35, 1.0, distance(spot, middle) / reach);
      float line = max(0.45 * onLine(gridStep), onLine(5.0 * gridStep));
      ink = vec4(mix(colour, gridColour, line), 1.0) * fade * mix(0.55, 0.9, line);
    }`;

  function compile(gl, vertex, fragment) {
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "position");
    gl.bindAttribLocation(program, 1, "normal");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return { program, places: new Map() };
  }

  class WebglView {
    constructor(canvas, gl) {
      this.canvas = canvas;
      this.gl = gl;
      this.detail = 8;
      this.prepare();
      // A browser may take the context away, from a sleeping laptop for one, and give a new one later.
      canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
      canvas.addEventListener("webglcontextrestored", () => {
        this.prepare();
        if (this.drawn) this.draw(...this.drawn);
      });
    }

    prepare() {
      this.solid = compile(this.gl, solidVertex, solidFragment);
      this.flat = compile(this.gl, flatVertex, flatFragment);
      this.ground = compile(this.gl, groundVertex, groundFragment);
      this.stored = new WeakMap();
      this.scratch = [this.gl.createBuffer(), this.gl.createBuffer()];
      this.square = this.store(new Float32Array([-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0]));
    }

    store(values) {
      const { gl } = this;
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      return buffer;
    }

    use(shader, uniforms) {
      const { gl } = this;
      gl.useProgram(shader.program);
      for (const [name, value] of Object.entries(uniforms)) {
        if (!shader.places.has(name)) shader.places.set(name, gl.getUniformLocation(shader.program, name));
        const place = shader.places.get(name);
        if (typeof value === "number") gl.uniform1f(place, value);
        else if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
        else gl[`uniform${value.length}fv`](place, value);
      }
    }

    // Values that stay are kept on the graphics card; what is made anew for each picture goes through one buffer.
    attribute(index, values, transient) {
      const { gl } = this;
      if (!transient && !this.stored.has(values)) this.stored.set(values, this.store(values));
      gl.bindBuffer(gl.ARRAY_BUFFER, transient ? this.scratch[index] : this.stored.get(values));
      if (transient) gl.bufferData(gl.ARRAY_BUFFER, values, gl.STREAM_DRAW);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, 3, gl.FLOAT, false, 0, 0);
    }

    // `scale` has the ground's grid step and the scene's size; `colours` is the theme's palette.
    draw(picture, camera, colours, scale) {
      this.drawn = [picture, camera, colours, scale];
      const { gl, canvas } = this;
      if (gl.isContextLost()) return;
      const look = camera.look(canvas.width / canvas.height);
      const light = knap.keyLight(camera);
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LEQUAL);
      gl.depthMask(false);
      for (const plane of picture.planes) this.drawGround(plane, look, camera, colours, scale);
      for (const plane of picture.planes) this.drawShadows(plane, picture, look, light, colours);
      gl.depthMask(true);
      const opaque = picture.solids.filter((solid) => solid.alpha === 1);
      for (const solid of opaque) this.drawSolid(solid, look, camera, light, colours);
      for (const line of picture.lines) this.drawLine(line, look, colours);
      for (const arrow of picture.arrows) this.drawArrow(arrow, look, camera, light, colours, scale);
      gl.depthMask(false);
      for (const solid of picture.solids) {
        if (solid.alpha !== 1) this.drawSolid(solid, look, camera, light, colours);
      }
      gl.depthMask(true);
    }

    drawGround({ pose }, { viewProjection }, camera, colours, { gridStep, size }) {
      const { gl } = this;
      const middle = knap.onPlane(pose, camera.target);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.square);
      gl.enableVertexAttribArray(0);
      gl.disableVertexAttribArray(1);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      this.use(this.ground, {
        viewProjection, pose, middle, reach: 4 * size, gridStep, colour: colours.ground, gridColour: colours.grid,
      });
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }

    // Each pixel of the ground is darkened once, however many triangles throw a shadow on it: the stencil counts.
    drawShadows({ pose }, picture, { viewProjection }, light, colours) {
      const { gl } = this;
      const n = [pose[8], pose[9], pose[10]];
      if (knap.matrices.dot(n, light) < 0.2) return;
      const flatten = knap.matrices.shadowOnto([pose[12], pose[13], pose[14]], n, light);
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.disableVertexAttribArray(1);
      for (const solid of picture.solids) {
        if (solid.alpha !== 1) continue;
        const shadow = knap.matrices.multiply(flatten, solid.pose);
        this.use(this.flat, { viewProjection, pose: shadow, colour: colours.ground.map((c) => 0.25 * c), alpha: 0.16 });
        this.attribute(0, solid.surface.positions, solid.transient);
        gl.drawArrays(gl.TRIANGLES, 0, solid.surface.positions.length / 3);
      }
      gl.disable(gl.STENCIL_TEST);
    }

    drawSolid({ surface, pose, colour, alpha, transient }, { viewProjection, eye }, camera, light, colours) {
      const { gl } = this;
      const ink = colours[colour];
      // Filled faces step back a little, so that their edges are not half buried in them.
      gl.enable(gl.POLYGON_OFFSET_FILL);
      // Clear ones more so: faces that they share with a body inside or outside are the body's.
      gl.polygonOffset(alpha === 1 ? 1 : 3, alpha === 1 ? 1 : 3);
      this.use(this.solid, { viewProjection, pose, colour: ink, alpha, eye, up: camera.up, light });
      this.attribute(0, surface.positions, transient);
      this.attribute(1, surface.normals, transient);
      gl.drawArrays(gl.TRIANGLES, 0, surface.positions.length / 3);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      gl.disableVertexAttribArray(1);
      if (!surface.edges.length) return;
      this.use(this.flat, { viewProjection, pose, colour: ink.map((c) => 0.45 * c), alpha: alpha === 1 ? 0.8 : 0.6 });
      this.attribute(0, surface.edges, transient);
      gl.drawArrays(gl.LINES, 0, surface.edges.length / 3);
    }

    drawLine({ points, colour }, { viewProjection }, colours) {
      const { gl } = this;
      this.use(this.flat, { viewProjection, pose: knap.matrices.identity(), colour: colours[colour], alpha: 1 });
      this.attribute(0, new Float32Array(points), true);
      gl.drawArrays(gl.LINE_STRIP, 0, points.length / 3);
    }

    drawArrow({ from, vector, colour }, look, camera, light, colours, { size }) {
      const { gl } = this;
      const solid = { ...knap.meshes.arrow(from, vector, 0.008 * size), colour, transient: true };
      // Contacts lie inside what touches: what a body hides of an arrow shows through it, faintly.
      gl.depthFunc(gl.GREATER);
      gl.depthMask(false);
      this.drawSolid({ ...solid, alpha: 0.35 }, look, camera, light, colours);
      gl.depthMask(true);
      gl.depthFunc(gl.LEQUAL);
      this.drawSolid({ ...solid, alpha: 1 }, look, camera, light, colours);
    }
  }

  knap.WebglView = WebglView;
})(window.knap = window.knap || {});
