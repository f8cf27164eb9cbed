// Scene on the page: canvas, labels, legend and camera control.

const VIEWS = { home: null, top: [-90, 89.9], front: [-90, 0], side: [0, 0] }; // azimuth and elevation, degrees
const MOST_SORTED = 5000; // triangles that a 2D canvas draws at 20 frames a second
const NAMED = "600 12px system-ui, sans-serif"; // numbers and names in the scene

class Viewer {
  constructor(root, data, state, films) {
    this.root = root;
    this.data = data;
    this.state = state;
    this.films = films;
    this.camera = this.makeCamera();
    this.canvas = root.querySelector("canvas.space");
    this.paper = root.querySelector("canvas.labels");
    this.options = { ghost: true, path: true, numbers: true, force: true, sensors: true, radius: this.camera.radius, selected: null };
    this.painter = this.makePainter();
    this.theme();
    this.hands();
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    this.resize();
  }

  // Show all films.
  makeCamera() {
    const low = [0, 1, 2].map((i) => Math.min(...this.films.map((film) => film.bounds[0][i])));
    const high = [0, 1, 2].map((i) => Math.max(...this.films.map((film) => film.bounds[1][i])));
    return new Camera([low, high], this.films[0].flat);
  }

  // Without a graphics card a 2D canvas is faster, unless there are too many triangles to sort.
  makePainter() {
    const triangles = this.films.reduce((sum, film) => sum + (film.corners ? film.corners.corners.length / 18 : 0), 0);
    if (!location.hash.includes("flat")) {
      try {
        const painter = new GlPainter(this.canvas, location.hash.includes("gl") || triangles > MOST_SORTED);
        this.canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); this.replace(); });
        return painter;
      } catch { this.fresh(); }
    }
    return new FlatPainter(this.canvas);
  }

  // A canvas with a WebGL context has no 2D context.
  fresh() {
    const canvas = this.canvas.cloneNode();
    this.canvas.replaceWith(canvas);
    this.canvas = canvas;
  }

  replace() {
    this.fresh();
    this.painter = new FlatPainter(this.canvas);
    this.hands();
    this.resize();
  }

  // Action of a button: select a view or toggle a part.
  act(name) {
    if (!(name in VIEWS)) this.options[name] = !this.options[name];
    else this.camera.home();
    if (VIEWS[name]) { this.camera.look(...VIEWS[name]); this.camera.fit(); }
  }

  // Colours for the current background.
  theme() {
    const dark = this.state.dark ? 1 : 0, { colours, cables, states } = this.data;
    const several = this.films.length > 1;
    const css = Object.fromEntries(Object.entries(colours).map(([key, pair]) => [key, pair[dark]]));
    const body = this.films[0].colours.platform;
    const base = {
      css, states, ramp: this.data.ramp[dark].map(rgb), slack: rgb(css.slack), limit: rgb(css.limit), ink: rgb(css.ink),
      desired: rgb(css.desired), force: rgb(css.force), sensor: rgb(css.sensor), edge: rgb(css.ink), opacity: 1,
      body: rgb(body || css.body),
    };
    this.looks = this.films.map((_, i) => {
      if (!several) return base;
      const run = rgb((this.films[i].colour || cables[i % cables.length])[dark]);
      return { ...base, run, edge: run, opacity: i === 0 ? 1 : 0.35, body: base.body.map((x, k) => 0.6 * x + 0.4 * run[k]) };
    });
    this.painter.forget();
    const fixed = still(this.films, this.data, dark, this.camera);
    this.fixed = [fixed.lines];
    this.axes = fixed.axes;
    this.ways = this.films.map((film, i) => {
      const colour = several ? this.looks[i].run : base.ink;
      return {
        desired: film.desired && i === 0 ? way(film.ledBy(...film.desired), this.camera.radius, base.desired, several ? 1.5 : 3.5, 0.75) : null,
        done: way(film.ledBy(film.position, film.orientation), this.camera.radius, colour, 1.8, 1),
      };
    });
    this.paint = true;
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    for (const canvas of [this.canvas, this.paper]) {
      canvas.width = Math.max(1, Math.round(box.width * this.ratio));
      canvas.height = Math.max(1, Math.round(box.height * this.ratio));
    }
    this.written = null; // resizing has cleared the canvas
    this.camera.resize(box.width, box.height);
    this.draw();
  }

  draw() {
    const t = this.state.time;
    const lines = [...this.fixed], solids = [], labels = [];
    this.pictures = this.films.map((film) => film.at(t));
    this.films.forEach((film, i) => {
      const picture = this.pictures[i];
      if (this.options.path) lines.push(...this.paths(i, picture));
      if (film.outlines) lines.push(this.outlines(film, picture, this.looks[i]));
      const found = moving(film, picture, this.looks[i], { ...this.options, ghost: this.options.ghost && i === 0, sensors: this.options.sensors && i === 0 });
      lines.push(found.lines);
      solids.push(...found.solids);
      if (i === 0) labels.push(...found.labels);
    });
    this.more(lines, solids, labels);
    this.painter.draw(this.camera, this.ratio, lines, solids);
    this.write(labels);
  }

  // Target and past path of film i.
  paths(i, picture) {
    const { desired, done } = this.ways[i], past = { ...done, count: done.upto[picture.index] };
    return desired ? [desired, past] : [past];
  }

  more() {} // hook for additional content

  outlines(film, picture, look) {
    const { rows, sizes, points } = film.outlines, lines = new Lines();
    const each = sizes.reduce((a, b) => a + b, 0);
    let at = 3 * each * nearest(rows, picture.index);
    for (const size of sizes) {
      for (let k = 1; k < size; k++) {
        lines.add(points.subarray(at + 3 * k - 3, at + 3 * k), points.subarray(at + 3 * k, at + 3 * k + 3), look.ink, 1.4);
      }
      at += 3 * size;
    }
    return lines.done();
  }

  write(labels) {
    const c = this.paper.getContext("2d"), view = this.camera.matrix(), dark = this.state.dark ? 1 : 0;
    const written = [dark, this.paper.width, this.paper.height, this.options.numbers, view.join(),
      ...labels.map(({ text, at }) => text + at.map((x) => x.toFixed(3)))].join();
    if (written === this.written) return;
    this.written = written;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, ...this.camera.size);
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.lineJoin = "round";
    const write = (at, text, colour, font) => {
      c.font = font;
      c.lineWidth = 4;
      c.strokeStyle = this.data.colours.ground[dark];
      c.strokeText(text, ...at);
      c.fillStyle = colour;
      c.fillText(text, ...at);
    };
    const middle = this.camera.project(view, this.camera.target) || [0, 0];
    if (this.options.numbers) {
      const placed = [];
      for (const { at, text, colour } of labels) {
        const p = this.camera.project(view, at);
        if (!p) continue;
        const near = placed.find((other) => Math.hypot(other.p[0] - p[0], other.p[1] - p[1]) < 12);
        if (near) near.texts.push([text, colour]); else placed.push({ p, texts: [[text, colour]] });
      }
      for (const { p, texts } of placed) {
        const away = [p[0] - middle[0], p[1] - middle[1]], n = Math.hypot(...away) || 1;
        c.font = NAMED;
        const widths = texts.map(([text]) => Math.max(20, c.measureText(text).width + 6)); // px
        const wide = widths.reduce((sum, width) => sum + width, 0), beyond = 0.5 * (wide - 20 * texts.length); // next to the point
        const at = [p[0] + (14 + beyond) * away[0] / n, p[1] + 14 * away[1] / n];
        let left = at[0] - 0.5 * wide;
        texts.forEach(([text, colour], i) => {
          const x = clamp(left + 0.5 * widths[i], 0.5 * widths[i], this.camera.size[0] - 0.5 * widths[i]);
          left += widths[i];
          write([x, clamp(at[1], 9, this.camera.size[1] - 9)], text, colour, NAMED);
        });
      }
    }
    const { origin, length } = this.axes, root = this.camera.project(view, origin);
    ["x", "y", "z"].forEach((name, i) => {
      const tip = origin.slice();
      tip[i] += 1.22 * length;
      const p = this.camera.project(view, tip);
      if (!p || Math.hypot(p[0] - root[0], p[1] - root[1]) < 8) return; // points to the viewer
      write(p, name, this.data.axes[i][dark], "700 13px system-ui, sans-serif");
    });
  }

  // One finger or the left button rotates, two fingers or the right button move, the wheel zooms.
  hands() {
    const at = new Map();
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      at.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = at.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before[0], dy = event.clientY - before[1];
      if (at.size === 2) {
        const [other] = [...at].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
        const gap = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        this.camera.pan(dx / 2, dy / 2);
        this.camera.nearer(gap([event.clientX, event.clientY]) / gap(before));
      } else if (event.shiftKey || event.buttons & 6) {
        this.camera.pan(dx, dy);
      } else {
        this.camera.orbit(0.008 * dx, 0.008 * dy);
      }
      at.set(event.pointerId, [event.clientX, event.clientY]);
      this.state.wake();
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => at.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => { this.camera.home(); this.state.wake(); });
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // else the page could not scroll
      event.preventDefault();
      this.camera.nearer(Math.exp(-0.0015 * event.deltaY));
      this.state.wake();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [8, 0], ArrowRight: [-8, 0], ArrowUp: [0, 8], ArrowDown: [0, -8] };
      const by = event.shiftKey && turns[event.key];
      if (by) this.camera.orbit(0.015 * by[0], 0.015 * by[1]);
      else if (event.key === "+" || event.key === "=") this.camera.nearer(1.2);
      else if (event.key === "-") this.camera.nearer(1 / 1.2);
      else if (event.key === "0") this.camera.home();
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.state.wake();
    });
  }
}
