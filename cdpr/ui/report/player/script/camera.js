// Camera that orbits about a point, z up. Matrices are column-major, as in WebGL.

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
function unit(a) { const n = Math.hypot(a[0], a[1], a[2]) || 1; return [a[0] / n, a[1] / n, a[2] / n]; }

class Camera {
  constructor(bounds, flat) {
    const [low, high] = bounds;
    this.low = low;
    this.high = high;
    this.radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) || 1;
    this.flat = flat;
    this.field = (flat === null ? 30 : 14) * Math.PI / 180;
    this.size = [1, 1];
    this.home();
  }

  home() {
    this.target = [0, 1, 2].map((i) => 0.5 * (this.low[i] + this.high[i]));
    const views = { 0: [0, 0], 1: [-90, 0], 2: [-90, 89.9] };
    this.look(...(this.flat === null ? [-62, 18] : views[this.flat]));
    this.zoom = 1;
    this.fit();
  }

  look(azimuth, elevation) {
    this.azimuth = azimuth * Math.PI / 180;
    this.elevation = elevation * Math.PI / 180;
  }

  orbit(across, up) {
    this.azimuth -= across;
    this.elevation = clamp(this.elevation + up, -1.55, 1.55);
  }

  // Move the target in the view plane by pixels.
  pan(across, up) {
    const { right, above } = this.axes();
    const scale = 2 * this.distance * Math.tan(this.field / 2) / this.size[1];
    for (let i = 0; i < 3; i++) this.target[i] += scale * (-across * right[i] + up * above[i]);
  }

  nearer(factor) {
    this.zoom = clamp(this.zoom * factor, 0.1, 30);
    this.fit();
  }

  // Distance at which all corners of the bounds are in view.
  fit() {
    const { right, above, back } = this.axes();
    const half = Math.tan(this.field / 2), aspect = this.size[0] / this.size[1];
    let distance = 0.1 * this.radius;
    const middle = [0, 1, 2].map((i) => 0.5 * (this.low[i] + this.high[i]));
    for (let k = 0; k < 8; k++) {
      const corner = [0, 1, 2].map((i) => (k >> i & 1 ? this.high[i] : this.low[i]) - middle[i]);
      const depth = dot(corner, back);
      const need = Math.max(Math.abs(dot(corner, right)) / (half * aspect), Math.abs(dot(corner, above)) / half);
      distance = Math.max(distance, depth + 1.12 * need);
    }
    this.distance = distance / this.zoom;
  }

  resize(width, height) {
    this.size = [Math.max(width, 1), Math.max(height, 1)];
    this.fit();
  }

  axes() {
    const ca = Math.cos(this.azimuth), sa = Math.sin(this.azimuth);
    const ce = Math.cos(this.elevation), se = Math.sin(this.elevation);
    return { right: [-sa, ca, 0], above: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  }

  // Matrix from world to clip space.
  matrix() {
    const { right, above, back } = this.axes();
    const eye = [0, 1, 2].map((i) => this.target[i] + this.distance * back[i]);
    const f = 1 / Math.tan(this.field / 2), g = f * this.size[1] / this.size[0];
    const near = Math.max(this.distance - 3 * this.radius, 0.02 * this.distance);
    const far = this.distance + 3 * this.radius;
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    const rows = [[g, right], [f, above], [a, back]];
    const m = new Float32Array(16);
    rows.forEach(([scale, axis], r) => {
      for (let i = 0; i < 3; i++) m[4 * i + r] = scale * axis[i];
      m[12 + r] = -scale * dot(axis, eye);
    });
    m[14] += b;
    for (let i = 0; i < 3; i++) m[4 * i + 3] = -back[i];
    m[15] = dot(back, eye);
    return m;
  }

  // Pixels and depth of a world point; null if it is behind the eye.
  project(m, point) {
    const [x, y, z] = point;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 1e-6) return null;
    const u = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w, v = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
    return [0.5 * (u + 1) * this.size[0], 0.5 * (1 - v) * this.size[1], w];
  }
}
