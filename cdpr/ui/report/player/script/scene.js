// Content of the 3D scene at a time: frame, cables, platform, desired pose, paths and forces of one or several runs.

// Picture between two rows: positions are interpolated linearly, the state of a cable is that of the row before.
class Film {
  constructor(scene) {
    Object.assign(this, scene);
    this.count = scene.time.length;
    this.corners = scene.body ? { corners: withNormals(scene.body) } : null;
    this.arm = (scene.tools || {})[scene.led] || null; // guided point, if it is not the origin
    this.room = scene.region ? { corners: withNormals(scene.region) } : null;
  }

  // Path of the guided point, from consecutive positions and attitudes.
  ledBy(places, attitudes) {
    if (!this.arm) return places;
    const out = new Float32Array(places.length);
    for (let k = 0; k < places.length / 3; k++) {
      out.set(moved(modelMatrix(places.subarray(3 * k, 3 * k + 3), attitudes.subarray(4 * k, 4 * k + 4)), this.arm), 3 * k);
    }
    return out;
  }

  at(t) {
    const i = indexAt(this.time, t), j = Math.min(i + 1, this.count - 1);
    const gap = this.time[j] - this.time[i];
    const part = gap > 0 ? clamp((t - this.time[i]) / gap, 0, 1) : 0;
    const mixed = (values, width) => {
      const out = new Array(width);
      for (let k = 0; k < width; k++) {
        const a = values[i * width + k], b = values[j * width + k];
        out[k] = part === 0 ? a : a + part * (b - a);
      }
      return out;
    };
    const attitude = (values) => {
      const q = mixed(values, 4), d = [0, 1, 2, 3].reduce((s, k) => s + values[4 * i + k] * values[4 * j + k], 0);
      const near = d < 0 ? Array.from(values.subarray(4 * i, 4 * i + 4)) : q;
      const n = Math.hypot(...near) || 1;
      return near.map((x) => x / n);
    };
    const m = this.cables.length;
    return this.picture(i, {
      position: mixed(this.position, 3),
      orientation: attitude(this.orientation),
      desired: this.desired ? [mixed(this.desired[0], 3), attitude(this.desired[1])] : null,
      tension: this.tension ? mixed(this.tension, m) : null,
      state: this.state ? this.state.subarray(i * m, (i + 1) * m) : null,
      force: this.force ? mixed(this.force, 3) : null,
      exits: this.exits ? mixed(this.exits, 3 * m) : null,
      curves: this.curves ? mixed(this.curves, this.curves.length / this.count) : null,
      readings: this.readingsAt(i),
    });
  }

  // Values of the sensors by name: a measurement is held until the next.
  readingsAt(i) {
    const known = (this.sensors || []).filter((sensor) => sensor.values);
    return Object.fromEntries(known.map(({ name, values }) => {
      const width = values.length / this.count;
      return [name, values.subarray(i * width, (i + 1) * width)];
    }));
  }

  // Picture of one row: everything follows from the same numbers.
  picture(index, { position, orientation, desired, tension, state, force, exits, curves, readings }) {
    const pose = modelMatrix(position, orientation);
    return {
      index,
      pose,
      desired: desired ? modelMatrix(...desired) : null,
      tension,
      state: state || new Uint8Array(this.cables.length),
      force,
      curves, // inner points of cables that sag
      readings: readings || {},
      exits: exits || this.anchors.flatMap((a) => a.slice(0, 3)),
      tips: this.anchors.map((a) => moved(pose, a.slice(3))),
    };
  }
}

const UNMOVED = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

// Column-major matrix of a position and quaternion (w, x, y, z).
function modelMatrix([x, y, z], [w, a, b, c]) {
  return new Float32Array([
    1 - 2 * (b * b + c * c), 2 * (a * b + w * c), 2 * (a * c - w * b), 0,
    2 * (a * b - w * c), 1 - 2 * (a * a + c * c), 2 * (b * c + w * a), 0,
    2 * (a * c + w * b), 2 * (b * c - w * a), 1 - 2 * (a * a + b * b), 0,
    x, y, z, 1]);
}

function moved(m, [x, y, z]) {
  return [0, 1, 2].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
}

// Triangle corners with normals: the area-weighted mean of adjacent faces that differ by at most 40°.
function withNormals({ vertices, triangles }) {
  const point = (i) => Array.from(vertices.subarray(3 * i, 3 * i + 3));
  const faces = [], around = new Map();
  for (let k = 0; k < triangles.length; k += 3) {
    const ids = [0, 1, 2].map((i) => Math.round(triangles[k + i])), [a, b, c] = ids.map(point);
    const area = cross(b.map((x, i) => x - a[i]), c.map((x, i) => x - a[i]));
    const face = { ids, area, normal: unit(area) };
    faces.push(face);
    for (const id of ids) around.set(id, [...(around.get(id) || []), face]);
  }
  const out = [];
  for (const face of faces) {
    for (const id of face.ids) {
      const sum = [0, 0, 0];
      for (const other of around.get(id)) {
        if (dot(other.normal, face.normal) > 0.766) for (let i = 0; i < 3; i++) sum[i] += other.area[i];
      }
      out.push(...point(id), ...unit(sum));
    }
  }
  return new Float32Array(out);
}

// Collector of lines for a painter.
class Lines {
  constructor() { this.data = []; }

  add(a, b, colour, width, opacity = 1, dash = 0) {
    this.data.push(a[0], a[1], a[2], b[0], b[1], b[2], colour[0], colour[1], colour[2], opacity, width, dash);
  }

  done(keep = false) {
    const data = new Float32Array(this.data);
    return { data, count: data.length / LINE, keep };
  }
}

// Static content: floor, frame, axes and paths. `dark` is 0 or 1.
function still(films, data, dark, camera) {
  const lines = new Lines(), soft = rgb(data.colours.soft[dark]), { low, high } = camera;
  if (camera.flat === null) {
    const step = niceStep(Math.max(high[0] - low[0], high[1] - low[1]), 10);
    const from = [0, 1].map((i) => Math.floor(low[i] / step - 1e-6)), to = [0, 1].map((i) => Math.ceil(high[i] / step + 1e-6));
    for (const [i, j] of [[0, 1], [1, 0]]) {
      for (let k = from[i]; k <= to[i]; k++) {
        const a = [0, 0, low[2]], b = [0, 0, low[2]];
        a[i] = b[i] = k * step;
        a[j] = from[j] * step;
        b[j] = to[j] * step;
        lines.add(a, b, soft, 1, 0.22);
      }
    }
  }
  const frame = films[0].colours.frame ? rgb(films[0].colours.frame) : soft;
  if (!films[0].frame.length && camera.flat === null) {
    for (let i = 0; i < 8; i++) {
      for (const bit of [1, 2, 4]) {
        const corner = (k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? high[axis] : low[axis]));
        if (!(i & bit)) lines.add(corner(i), corner(i | bit), soft, 1.2, 0.45);
      }
    }
  }
  for (const edge of films[0].frame) lines.add(edge.slice(0, 3), edge.slice(3), frame, 2, 0.85);
  const length = niceStep(2 * camera.radius, 14), origin = [0, 0, 0]; // of the world
  [0, 1, 2].forEach((i) => {
    const tip = origin.slice();
    tip[i] += length;
    lines.add(origin, tip, rgb(data.axes[i][dark]), 3.5);
  });
  return { lines: { ...lines.done(true), behind: true }, axes: { origin, length } };
}

const FINEST = 1e-3; // relative to the scene's radius, at most a pixel: of closer points only one is drawn

// Path of a point through all pictures, (n, 3) in sequence; `upto` is the number of lines up to each.
function way(points, radius, colour, width, opacity) {
  const lines = new Lines(), upto = new Uint32Array(points.length / 3), least = FINEST * radius;
  let last = points.subarray(0, 3), count = 0;
  for (let k = 1; k < upto.length; k++) {
    const next = points.subarray(3 * k, 3 * k + 3);
    if (!(Math.hypot(next[0] - last[0], next[1] - last[1], next[2] - last[2]) < least)) {
      lines.add(last, next, colour, width, opacity);
      last = next;
      count++;
    }
    upto[k] = count;
  }
  return { ...lines.done(true), behind: true, upto };
}

// True if two poses differ visibly: by more than this fraction of the scene.
function differ(a, b, radius) {
  const away = Math.hypot(a[12] - b[12], a[13] - b[13], a[14] - b[14]);
  let turned = 0;
  for (let i = 0; i < 11; i++) turned = Math.max(turned, Math.abs(a[i] - b[i]));
  return away > 0.004 * radius || turned > 0.03;
}

// Moving content of one film in a picture; returns lines, solids and labels.
function moving(film, picture, look, options) {
  const lines = new Lines(), solids = [], labels = [];
  const m = film.cables.length, [low, high] = film.range, { slack, lowest, highest, broken } = look.states;
  const number = (k) => picture.exits.slice(3 * k, 3 * k + 3);
  const curves = picture.curves || [], inner = curves.length / (3 * m);
  for (let k = 0; k < m; k++) {
    const state = picture.state[k], exit = number(k), tip = picture.tips[k], way = [exit];
    for (let j = k * inner; j < (k + 1) * inner; j++) way.push(curves.slice(3 * j, 3 * j + 3));
    way.push(tip);
    const draw = (...look) => way.slice(1).forEach((end, j) => lines.add(way[j], end, ...look));
    if (state === broken) { labels.push({ at: exit, text: `${k + 1} ×`, colour: look.css.soft }); continue; }
    const limit = state === lowest || state === highest;
    const share = picture.tension && high > low ? (picture.tension[k] - low) / (high - low) : 0.5;
    const ramp = look.ramp[Math.round(clamp(share, 0, 1) * (look.ramp.length - 1)) || 0];
    let colour = look.run || (picture.tension ? ramp : look.ink);
    if (state === slack) colour = look.slack;
    if (limit && !look.run) draw(look.limit, 7, 0.5);
    if (options.selected === k) draw(look.ink, 8, 0.35);
    draw(colour, look.run ? 2 : 3, 1, state === slack ? 5 : 0);
    const mark = limit ? (state === lowest ? " ▼" : " ▲") : "";
    labels.push({ at: exit, text: `${k + 1}${mark}`, colour: limit ? look.css.limit : look.css.ink, cable: k });
  }
  for (let k = 0; k < m; k++) lines.add(picture.tips[k], picture.tips[k], look.ink, 5);
  for (const [name, place] of Object.entries(film.tools || {})) {
    const at = moved(picture.pose, place);
    lines.add(at, at, look.force, 7);
    labels.push({ at, text: name, colour: look.css.force });
  }
  drawBody(film, picture.pose, look.body, look.opacity, look.edge, lines, solids);
  if (film.room) solids.push({ body: film.room, model: UNMOVED, colour: [...look.desired, 0.3] });
  if (options.ghost && picture.desired && differ(picture.pose, picture.desired, options.radius)) {
    drawBody(film, picture.desired, look.desired, 0.22, look.desired, lines, solids);
  }
  if (options.force && picture.force && film.strongest > 0) {
    arrow(lines, picture.pose, picture.force, 0.55 * options.radius / film.strongest, look.force);
  }
  if (options.sensors) for (const sensor of film.sensors || []) drawSensor(sensor, picture, look, lines, labels);
  return { lines: lines.done(), solids, labels };
}

// Point and name, frustum, rays to the measured distances, and marks: large where they are seen.
function drawSensor(sensor, picture, look, lines, labels) {
  const [own, other] = sensor.carried ? [picture.pose, UNMOVED] : [UNMOVED, picture.pose], values = picture.readings[sensor.name];
  const at = moved(own, sensor.at), ends = sensor.edges.map((end) => moved(own, end));
  lines.add(at, at, look.sensor, 6);
  labels.push({ at, text: sensor.name, colour: look.css.sensor });
  for (let k = 0; k + 1 < ends.length; k += 2) lines.add(ends[k], ends[k + 1], look.sensor, 1.6);
  sensor.rays.forEach((ray, k) => {
    if (!values || !Number.isFinite(values[k])) return;
    const tip = moved(own, ray.map((x, i) => sensor.at[i] + values[k] * x));
    lines.add(at, tip, look.sensor, 1.2, 0.6);
    lines.add(tip, tip, look.sensor, 4);
  });
  sensor.marks.forEach((mark, k) => {
    const there = moved(other, mark), seen = values && values[k] > 0.5;
    lines.add(there, there, seen ? look.sensor : look.slack, seen ? 7 : 4);
  });
}

function drawBody(film, pose, colour, opacity, edge, lines, solids) {
  if (!film.corners) { // lines to the anchors, if the shape is unknown
    const middle = moved(pose, [0, 0, 0]);
    for (const a of film.anchors) lines.add(middle, moved(pose, a.slice(3)), edge, 2.5, opacity === 1 ? 1 : 0.7);
    return;
  }
  solids.push({ body: film.corners, model: pose, colour: [...colour, opacity] });
  const vertex = (i) => moved(pose, film.body.vertices.subarray(3 * i, 3 * i + 3));
  for (const face of film.body.faces) {
    face.forEach((i, k) => lines.add(vertex(i), vertex(face[(k + 1) % face.length]), edge, 1.2, opacity === 1 ? 0.9 : 0.75));
  }
}

function arrow(lines, pose, force, scale, colour) {
  const size = Math.hypot(...force) * scale;
  if (!(size > 0)) return;
  const from = moved(pose, [0, 0, 0]), along = unit(force), side = unit(cross(along, Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const to = from.map((x, i) => x + size * along[i]), barb = 0.25 * size;
  lines.add(from, to, colour, 4);
  for (const sign of [1, -1]) {
    lines.add(to, to.map((x, i) => x - barb * along[i] + 0.45 * sign * barb * side[i]), colour, 4);
  }
}
