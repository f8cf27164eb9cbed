// Main script of the GUI: dispatch of messages, and one redraw for all received since the last.

class Live {
  constructor() {
    const night = matchMedia("(prefers-color-scheme: dark)");
    Object.assign(this, { dark: night.matches, time: 0, window: [0, 10], zoomed: true, hover: null, selected: null,
      hidden: new Set(), playing: false, hint: "Drag to zoom in on a time span, double click to follow again.",
      data: null, viewer: null, handles: null, frame: null, drawn: null });
    night.addEventListener("change", () => { this.dark = night.matches; this.restyle(); });
    const at = (id) => document.getElementById(id);
    this.form = new Form(at("form"), this);
    this.files = new Files(at("form").querySelector(".bar"), at("dialogs"), this);
    this.exchange = new Exchange(at("form").querySelector(".bar"), this.files, this);
    this.output = new Output(at("side").querySelector("[role=tablist]"), at("side").querySelector(".output"), this);
    this.transport = new Transport(at("transport"), this);
    this.disturb = new Disturb(at("disturb"), this);
    this.curves = new Curves(at("curves"), at("span"), this);
    for (const node of document.querySelectorAll("[data-do]")) {
      node.addEventListener("click", () => { this.viewer?.act(node.dataset.do); this.pressed(); this.wake(); });
    }
    this.folding(at("fold"));
    this.link = new Link(this);
  }

  // The form can be folded, and is at first on phones.
  folding(fold) {
    this.unfold = (open = true) => {
      document.body.classList.toggle("folded", !open);
      fold.setAttribute("aria-expanded", String(open));
    };
    fold.addEventListener("click", () => this.unfold(document.body.classList.contains("folded")));
    this.unfold(!matchMedia("(max-width: 61.99rem)").matches);
  }

  send(message, files) { return this.link.send(message, files); }
  note(level, text) { this.output.message({ level, text }); }

  receive(message) {
    const { kind } = message;
    if (kind === "hello") this.greet(message);
    else if (kind === "form") { this.form.show(message); this.files.settled(message); }
    else if (kind === "scene") this.load(message);
    else if (kind === "frame") this.feed(message);
    else if (kind === "images") this.output.picture(message);
    else if (kind === "samples") this.curves.add(message);
    else if (kind === "status") this.status(message);
    else if (kind === "message") {
      this.output.message(message);
      if (message.level === "error") this.files.after = null; // saving failed
    }
    else if (kind === "yaml") this.files.show(message);
    if (message.about) this.exchange.receive(message);
  }

  greet(hello) {
    this.data = { ...hello, scenes: [], shades: [], events: this.data?.events || [] };
    this.files.list(hello.examples || []);
    this.exchange.list(hello);
  }

  load(message) {
    const film = new LiveFilm(message), root = document.getElementById("scene");
    this.frame = null;
    if (this.viewer) this.viewer.load(film);
    else {
      this.viewer = new LiveViewer(root, this.data, this, [film]);
      this.viewer.options.handles = false;
      this.handles = new Handles(root.querySelector(".handles"), this.viewer, this);
    }
    this.handles.load(film);
    if (this.form.rows) this.handles.setCables(this.form.rows.rows, this.form.rows.applied);
    this.curves.load(message);
    this.output.load(message);
    this.disturb.load(message);
    this.restyle();
    this.pressed();
  }

  // Draw only the newest frame, but add all to the path.
  feed(frame) {
    if (!this.viewer) return;
    const [film] = this.viewer.films;
    if (this.frame && frame.t < this.frame.t) film.forget();
    this.frame = frame;
    this.time = frame.t;
    film.feed(frame);
    if (film.last) film.tread(this.viewer.options.radius);
    this.wake();
  }

  status(status) {
    this.playing = status.phase === "running";
    this.phase = status.phase;
    this.output.status(status);
    this.transport.show(status);
    this.disturb.show(status);
    if (status.limits) this.curves.limit(status.limits);
    document.body.dataset.phase = status.phase;
  }

  // Time interface for plots.
  seek() {}
  point(t) { this.hover = t; this.wake(); }
  zoom(from, to) { this.curves.hold(from, to); }
  whole() { this.curves.follow(); }

  select(cable) {
    if (this.selected === cable) return;
    this.selected = cable;
    if (this.viewer) this.viewer.options.selected = cable;
    this.redraw();
  }

  redraw() {
    for (const plot of this.curves.plots) plot.stale = true;
    this.wake();
  }

  restyle() {
    for (const plot of this.curves.plots) plot.dress();
    if (this.viewer) this.viewer.theme();
    if (this.data) {
      const css = (name) => this.data.colours[name][this.dark ? 1 : 0];
      document.getElementById("bar").style.background = `linear-gradient(90deg, ${this.data.ramp[this.dark ? 1 : 0].join(",")})`;
      document.querySelector(".swatch.slack").style.borderColor = css("slack");
      document.querySelector(".swatch.limit").style.borderColor = css("limit");
    }
    this.redraw();
  }

  pressed() {
    for (const node of document.querySelectorAll("[data-do]")) {
      const on = this.viewer?.options[node.dataset.do];
      if (typeof on === "boolean") node.setAttribute("aria-pressed", String(on));
    }
  }

  wake() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    if (!this.viewer) return;
    const { frame } = this, [film] = this.viewer.films;
    this.viewer.draw();
    const [picture] = this.viewer.pictures; // current picture, for tests and debugging
    this.drawn = { n: picture.n, t: picture.t, pose: Array.from(picture.pose), tips: picture.tips, exits: picture.exits };
    this.curves.draw();
    if (!frame) return;
    this.transport.tick(frame.t);
    const [low, high] = film.range;
    this.output.count(frame, high > 0 ? high : 1);
    setText(document.getElementById("least"), high > low ? shortNumber(low) : "–");
    setText(document.getElementById("largest"), high > low ? shortNumber(high) : "–");
  }
}

window.cdpr = new Live();
