// Scene of a running robot: a film of one picture, replaced by each frame.

const MOST_OF_TRAIL = 3000; // points of the past path; beyond, every other one is dropped
const FINEST_TRAIL = 0.002; // relative to the scene's radius: closer points are skipped

class LiveFilm extends Film {
  constructor(message) {
    super(replaceArrays(message.scene, bufferOf(message.bytes)));
    this.base = message.base || null;
    this.plan = message.path?.length ? Float32Array.from(message.path.flat()) : null;
    this.strongest = 0;
    this.last = null;
    this.trail = [];
  }

  at(t) { return this.last || super.at(t); }

  // One row: everything is drawn from this frame only.
  feed(frame) {
    if ([...frame.p, ...frame.q].some((x) => x === null)) return; // diverged run: keep the last valid picture
    const force = frame.force && frame.force.some((x) => x) ? frame.force : null;
    this.last = this.picture(0, {
      position: frame.p,
      orientation: frame.q,
      desired: frame.dp && frame.dp[0] !== null ? [frame.dp, frame.dq] : null,
      tension: frame.tension,
      state: frame.state,
      force,
      exits: frame.exits || null,
      curves: frame.curves || null,
      readings: frame.sensors || {},
    });
    this.last.n = frame.n;
    this.last.t = frame.t;
    this.last.bends = frame.outlines || null;
    if (frame.range) this.range = frame.range;
    if (frame.outlines) this.outlines = null; // static outlines of the home pose
    if (force) this.strongest = Math.max(this.strongest, Math.hypot(...force));
  }

  // Extend the past path by the position of the platform, or of the guided tool.
  tread(radius) {
    const here = moved(this.last.pose, this.arm || [0, 0, 0]), before = this.trail[this.trail.length - 1];
    if (before && Math.hypot(...here.map((x, i) => x - before[i])) < FINEST_TRAIL * radius) return;
    this.trail.push(here);
    if (this.trail.length > MOST_OF_TRAIL) this.trail = this.trail.filter((_, i) => i % 2 === 0);
    this.trodden = null;
  }

  forget() {
    this.trail = [];
    this.trodden = null;
    this.last = null;
    this.strongest = 0;
  }
}

class LiveViewer extends Viewer {
  // Show another film, with the current camera if possible.
  load(film) {
    const before = this.camera, [old] = this.films;
    this.films = [film];
    this.camera = this.makeCamera();
    if (before.flat === this.camera.flat) {
      Object.assign(this.camera, { azimuth: before.azimuth, elevation: before.elevation });
      if (String(old.bounds) === String(film.bounds)) Object.assign(this.camera, { zoom: before.zoom, target: before.target });
    }
    this.camera.resize(...before.size);
    this.options.radius = this.camera.radius;
    this.written = null;
    this.theme();
  }

  theme() {
    super.theme();
    const [film] = this.films, [look] = this.looks;
    this.planned = film.plan ? way(film.plan, this.camera.radius, look.desired, 3.5, 0.75) : null;
    film.trodden = null;
  }

  paths() {
    const [film] = this.films, lines = this.planned ? [this.planned] : [];
    if (film.trail.length < 2) return lines;
    film.trodden ??= { ...way(Float32Array.from(film.trail.flat()), this.camera.radius, this.looks[0].ink, 1.8, 1), keep: false };
    return [...lines, film.trodden];
  }

  more(lines, solids, labels) {
    const [film] = this.films, [picture] = this.pictures, [look] = this.looks, own = new Lines();
    for (const line of picture.bends || []) {
      for (let k = 1; k < line.length; k++) own.add(line[k - 1], line[k], look.ink, 1.4);
    }
    this.state.handles?.draw(own, solids, labels, film, picture, look);
    if (own.data.length) lines.push(own.done());
  }
}
