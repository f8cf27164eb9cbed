// Common time of all views: playback controls, keyboard, colour scheme and redrawing.

class Player {
  constructor(data) {
    this.data = data;
    this.time = data.span[0];
    this.window = data.span.slice();
    this.hover = null;
    this.selected = null;
    this.hidden = new Set();
    this.playing = false;
    this.speed = 1;
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.loop = !calm;
    const night = matchMedia("(prefers-color-scheme: dark)");
    this.dark = night.matches;
    night.addEventListener("change", () => { this.dark = night.matches; this.restyle(); });
    this.hint = "Click to go to a time, drag to zoom, double click for all.";
    this.plots = [];
    for (const [key, panels] of Object.entries(data.figures)) {
      const home = document.querySelector(`[data-panels="${key}"]`);
      panels.forEach((panel, i) => this.plots.push(new Plot(home, panel, data, this, i === panels.length - 1)));
    }
    const root = document.getElementById("viewer");
    const films = data.scenes.map((scene) => new Film(scene));
    this.viewer = root && films.length ? new Viewer(root, data, this, films) : null;
    this.images = new Images(data.images || []);
    this.transport();
    this.keys();
    this.links();
    this.restyle();
  }

  get zoomed() { return this.window[0] !== this.data.span[0] || this.window[1] !== this.data.span[1]; }

  seek(t) {
    this.time = clamp(t, ...this.data.span);
    this.wake();
  }

  point(t) { this.hover = t; this.wake(); }
  select(cable) {
    this.selected = cable;
    if (this.viewer) this.viewer.options.selected = cable;
    this.redraw();
  }

  zoom(from, to) {
    const [a, b] = this.data.span, least = 1e-4 * (b - a);
    const middle = 0.5 * (from + to), half = Math.max(0.5 * (to - from), least);
    this.window = [Math.max(a, middle - half), Math.min(b, middle + half)];
    this.redraw();
  }

  whole() { this.zoom(...this.data.span); }

  redraw() {
    for (const plot of this.plots) plot.stale = true;
    this.wake();
  }

  restyle() {
    for (const plot of this.plots) plot.dress();
    if (this.viewer) { this.viewer.theme(); this.bar(); }
    this.redraw();
  }

  // Draw at the next frame, once for all requests until then.
  wake() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.frame(now);
    });
  }

  frame(now) {
    if (this.playing) {
      const [a, b] = this.data.span, passed = this.before === undefined ? 0 : (now - this.before) / 1000;
      this.time += this.speed * Math.min(passed, 0.25);
      if (this.time >= b) {
        if (this.loop) this.time = a + (this.time - b) % Math.max(b - a, 1e-9);
        else { this.time = b; this.play(false); }
      }
      this.before = now;
    }
    if (this.viewer) this.viewer.draw();
    this.images.show(this.time);
    for (const plot of this.plots) {
      if (!plot.visible) continue;
      if (plot.stale) plot.draw(); else plot.follow();
    }
    this.show();
    if (this.playing) this.wake();
  }

  play(on) {
    this.playing = on;
    this.before = undefined;
    if (on && this.time >= this.data.span[1]) this.time = this.data.span[0];
    if (this.buttons.play) {
      this.buttons.play.setAttribute("aria-label", on ? "Pause" : "Play");
      this.buttons.play.classList.toggle("on", on);
    }
    this.wake();
  }

  // Step one frame forward or back.
  step(count) {
    this.play(false);
    const times = this.viewer ? this.viewer.films[0].time : [];
    if (!times.length) return;
    const k = clamp(nearest(times, this.time) + count, 0, times.length - 1);
    this.seek(times[k]);
  }

  transport() {
    this.buttons = {};
    for (const button of document.querySelectorAll("[data-do]")) {
      this.buttons[button.dataset.do] = button;
      button.addEventListener("click", () => this.act(button.dataset.do));
    }
    this.pressed();
    this.slider = document.getElementById("slider");
    if (!this.slider) return;
    const [a, b] = this.data.span;
    this.slider.min = a;
    this.slider.max = b;
    this.slider.step = "any";
    this.slider.addEventListener("input", () => { this.seek(Number(this.slider.value)); });
    const speed = document.getElementById("speed");
    speed.addEventListener("change", () => { this.speed = Number(speed.value); });
    const marks = document.getElementById("marks");
    this.data.events.forEach((event, i) => {
      const mark = document.createElement("i");
      mark.style.left = `${100 * clamp((event.time - a) / (b - a), 0, 1)}%`;
      mark.title = `${i + 1}: ${event.text}`;
      marks.append(mark);
    });
  }

  pressed() {
    for (const [name, button] of Object.entries(this.buttons)) {
      const options = this.viewer ? this.viewer.options : {};
      const on = name === "loop" ? this.loop : options[name];
      if (typeof on === "boolean") button.setAttribute("aria-pressed", String(on));
    }
  }

  act(name) {
    if (name === "play") this.play(!this.playing);
    else if (name === "loop") this.loop = !this.loop;
    else if (name === "start") this.seek(this.data.span[0]);
    else if (name === "whole") this.whole();
    else this.viewer.act(name);
    this.pressed();
    this.wake();
  }

  keys() {
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target.closest("select, summary, a, input:not(#slider)")) return;
      const pushed = event.target.closest("button");
      const span = this.window[1] - this.window[0], many = event.shiftKey ? 10 : 1;
      const acts = {
        " ": () => this.play(!this.playing),
        ArrowLeft: () => this.step(-many),
        ArrowRight: () => this.step(many),
        Home: () => this.seek(this.data.span[0]),
        End: () => this.seek(this.data.span[1]),
        l: () => this.act("loop"),
        "+": () => this.zoom(this.time - 0.25 * span, this.time + 0.25 * span),
        "-": () => this.zoom(this.time - span, this.time + span),
        0: () => this.act("whole"),
      };
      if (!(event.key in acts) || !this.slider || (pushed && event.key === " ")) return;
      event.preventDefault();
      acts[event.key]();
    });
  }

  // Events in the table jump to their times.
  links() {
    for (const link of document.querySelectorAll("[data-time]")) {
      link.addEventListener("click", () => this.seek(Number(link.dataset.time)));
    }
  }

  show() {
    if (!this.slider) return;
    this.slider.value = this.time;
    const text = `${this.time.toFixed(3)} s`;
    this.slider.setAttribute("aria-valuetext", text);
    document.getElementById("now").textContent = text;
    if (this.buttons.whole) this.buttons.whole.hidden = !this.zoomed;
  }

  // Colour bar of tensions.
  bar() {
    const home = document.getElementById("bar");
    if (!home) return;
    const ramp = this.data.ramp[this.dark ? 1 : 0];
    home.style.background = `linear-gradient(90deg, ${ramp.join(",")})`;
  }
}

const block = document.getElementById("data");
if (block) {
  document.documentElement.classList.add("playing");
  const player = new Player(readData(block.textContent));
  window.cdpr = player; // for tests and debugging
}
