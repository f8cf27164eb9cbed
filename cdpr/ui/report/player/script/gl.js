// Painter with WebGL 2: lines of a width in pixels, and shaded triangles. Throws if WebGL 2 is missing.
//
// A line is 12 numbers: two ends (world), red, green, blue, opacity, width and dash length (pixels, 0 for none).

const LINE = 12;

const LINE_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec2 corner;
layout(location=1) in vec3 a;
layout(location=2) in vec3 b;
layout(location=3) in vec4 colour;
layout(location=4) in vec2 style;
uniform mat4 view;
uniform vec2 size;
uniform float ratio;
out vec4 paint;
out vec3 place;
out float inside;
void main() {
  vec4 p = view * vec4(a, 1.0), q = view * vec4(b, 1.0);
  float near = 1e-3;
  if (p.w < near && q.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (p.w < near) p = mix(p, q, (near - p.w) / (q.w - p.w));
  if (q.w < near) q = mix(q, p, (near - q.w) / (p.w - q.w));
  vec2 s = p.xy / p.w * size * 0.5, t = q.xy / q.w * size * 0.5;
  float len = length(t - s);
  vec2 along = len > 1e-4 ? (t - s) / len : vec2(1.0, 0.0);
  float half_width = 0.5 * style.x * ratio, rim = half_width + 1.0;
  vec2 at = mix(s, t, corner.x) + rim * (corner.y * vec2(-along.y, along.x) + (2.0 * corner.x - 1.0) * along * 0.5);
  vec4 end = mix(p, q, corner.x);
  gl_Position = vec4(at / (size * 0.5) * end.w, end.z - 4e-4 * end.w, end.w);
  paint = colour;
  inside = max(half_width, 0.5);
  place = vec3(corner.y * rim, corner.x * len, style.y * ratio);
  if (half_width < 0.5) paint.a *= 2.0 * half_width;
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec4 paint;
in vec3 place;
in float inside;
out vec4 result;
void main() {
  if (place.z > 0.0 && fract(place.y / (2.0 * place.z)) > 0.5) discard;
  float alpha = paint.a * clamp(inside + 0.5 - abs(place.x), 0.0, 1.0);
  if (alpha < 0.01) discard;
  result = vec4(paint.rgb * alpha, alpha);
}`;

const SOLID_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec3 point;
layout(location=1) in vec3 normal;
uniform mat4 view;
uniform mat4 model;
out vec3 facing;
void main() {
  gl_Position = view * model * vec4(point, 1.0);
  facing = mat3(model) * normal;
}`;

const SOLID_FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing;
uniform vec3 light;
uniform vec4 colour;
out vec4 result;
void main() {
  float shade = 0.62 + 0.38 * dot(normalize(facing), light);
  result = vec4(colour.rgb * shade * colour.a, colour.a);
}`;

class GlPainter {
  constructor(canvas, inSoftware) {
    const gl = canvas.getContext("webgl2", { antialias: false });
    if (!gl) throw new Error("no WebGL 2");
    const extension = gl.getExtension("WEBGL_debug_renderer_info");
    const name = extension ? gl.getParameter(extension.UNMASKED_RENDERER_WEBGL) : "";
    if (!inSoftware && /swiftshader|llvmpipe|software|basic render/i.test(name)) throw new Error("WebGL in software");
    this.gl = gl;
    this.canvas = canvas;
    this.lines = program(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.solids = program(gl, SOLID_VERTEX, SOLID_FRAGMENT);
    this.corners = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([0, -1, 1, -1, 0, 1, 1, 1]), gl.STATIC_DRAW);
    this.kept = new Map(); // buffers of constant arrays
    this.passing = gl.createBuffer(); // buffer of changing arrays
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthFunc(gl.LEQUAL);
  }

  // `lines` contains {data, count, keep}, `solids` {body, model, colour}, opaque ones first.
  draw(camera, ratio, lines, solids) {
    const gl = this.gl, { width, height } = this.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = camera.matrix();
    for (const solid of solids) if (solid.colour[3] === 1) this.solid(view, camera, solid);
    this.allLines(view, [width, height], ratio, lines);
    gl.depthMask(false);
    for (const solid of solids) if (solid.colour[3] < 1) this.solid(view, camera, solid);
    gl.depthMask(true);
  }

  allLines(view, size, ratio, lines) {
    const gl = this.gl, { used, at } = this.lines;
    gl.useProgram(used);
    gl.uniformMatrix4fv(at.view, false, view);
    gl.uniform2f(at.size, ...size);
    gl.uniform1f(at.ratio, ratio);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.vertexAttribDivisor(0, 0);
    for (const { data, count, keep, behind } of lines) {
      if (!count) continue;
      gl.depthMask(!behind); // background does not hide later objects
      this.bind(data, keep);
      [[1, 3, 0], [2, 3, 3], [3, 4, 6], [4, 2, 10]].forEach(([place, parts, from]) => {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, parts, gl.FLOAT, false, 4 * LINE, 4 * from);
        gl.vertexAttribDivisor(place, 1);
      });
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    }
    gl.depthMask(true);
    [1, 2, 3, 4].forEach((place) => { gl.vertexAttribDivisor(place, 0); gl.disableVertexAttribArray(place); });
  }

  solid(view, camera, { body, model, colour }) {
    const gl = this.gl, { used, at } = this.solids, { right, above, back } = camera.axes();
    const light = unit([0, 1, 2].map((i) => 0.35 * right[i] + 0.55 * above[i] + 0.75 * back[i]));
    gl.useProgram(used);
    gl.uniformMatrix4fv(at.view, false, view);
    gl.uniformMatrix4fv(at.model, false, model);
    gl.uniform3f(at.light, ...light);
    gl.uniform4f(at.colour, ...colour);
    this.bind(body.corners, true);
    [[0, 0], [1, 3]].forEach(([place, from]) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribDivisor(place, 0);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, 4 * from);
    });
    gl.enable(gl.CULL_FACE);
    gl.drawArrays(gl.TRIANGLES, 0, body.corners.length / 6);
    gl.disable(gl.CULL_FACE);
    gl.disableVertexAttribArray(1);
  }

  bind(data, keep) {
    const gl = this.gl;
    if (keep && this.kept.has(data)) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.kept.get(data));
      return;
    }
    const buffer = keep ? gl.createBuffer() : this.passing;
    if (keep) this.kept.set(data, buffer);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, keep ? gl.STATIC_DRAW : gl.DYNAMIC_DRAW);
  }

  // Clear the kept buffers after a change of colours.
  forget() {
    for (const buffer of this.kept.values()) this.gl.deleteBuffer(buffer);
    this.kept.clear();
  }
}

// Program `used` with its uniform locations `at`, queried once.
function program(gl, vertex, fragment) {
  const p = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(p, shader);
  }
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
  const at = {};
  for (let i = gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS) - 1; i >= 0; i--) {
    const { name } = gl.getActiveUniform(p, i);
    at[name] = gl.getUniformLocation(p, name);
  }
  return { used: p, at };
}
