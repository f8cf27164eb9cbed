// Plots of a running simulation: tensions, and errors of position and attitude.

const SPANS = [1, 2, 5, 10, 30, 60]; // s, selectable time spans

// Time and value of one curve, in growing arrays; the server decimates the data.
class Curve {
  constructor() { this.clear(); }

  clear() {
    this.t = new Float64Array(256);
    this.v = new Float64Array(256);
    this.n = 0;
    this.settle();
  }

  // Show added points: plots read the filled part of the arrays.
  settle() {
    this.time = this.t.subarray(0, this.n);
    this.value = this.v.subarray(0, this.n);
  }

  add(time, value) {
    if (this.n === this.t.length) {
      for (const key of ["t", "v"]) {
        const more = new Float64Array(2 * this.n);
        more.set(this[key]);
        this[key] = more;
      }
    }
    this.t[this.n] = time;
    this.v[this.n] = value === null ? NaN : value;
    this.n += 1;
  }
}

class Curves {
  constructor(home, bar, live) {
    Object.assign(this, { home, bar, live, plots: [], span: 10, latest: 0 });
    const choice = make("select", { id: "seconds", "aria-label": "Time in the plots", onchange: () => {
      this.span = Number(choice.value);
      this.follow();
    } });
    for (const seconds of SPANS) choice.append(option(seconds, `last ${seconds} s`));
    choice.append(option(0, "whole time"));
    choice.value = this.span;
    this.lengths = button("Lengths", () => this.show(!this.long), { "aria-pressed": "false", title: "Cable lengths, too" });
    this.long = false;
    this.back = button("Follow", () => this.follow(), { hidden: true, title: "Show the last seconds again" });
    bar.append(make("label", { for: "seconds", text: "Plots" }), choice, this.lengths, this.back);
  }

  // Reset for another robot: one curve per cable.
  load(message) {
    const { scene: { cables }, limits } = message, { data } = this.live, dashes = data.dashes || [[]];
    const looks = cables.map((name, i) => ({
      name, group: "cable", width: 1.4, colour: data.cables[i % data.cables.length],
      dash: dashes[Math.floor(i / data.cables.length) % dashes.length],
    }));
    const one = (colour) => [{ name: "", group: "", width: 1.6, colour, dash: [] }];
    this.tension = this.panel("tension (N)", 2.6, looks, 1, this.levels(limits));
    this.position = this.panel("position error (mm)", 1.5, one(data.cables[0]), 1e-3);
    this.attitude = this.panel("attitude error (mrad)", 1.5, one(data.cables[1]), 1e-3);
    this.length = this.panel("cable length (m)", 1.5, looks, 1e-3);
    this.panels = [this.tension, this.position, this.attitude, this.length];
    this.home.replaceChildren();
    // The time axis is below the attitudes, or below the lengths if they are shown.
    this.plots = this.panels.map((panel, i) => new Plot(this.home, panel, data, this.live, i > 1));
    this.show(this.long);
    this.clear();
  }

  // Lengths are shown on request.
  show(long) {
    this.long = long;
    this.lengths.setAttribute("aria-pressed", String(long));
    if (this.plots.length) this.plots[3].root.hidden = !long;
  }

  panel(label, tall, looks, least, dashed = []) {
    const series = looks.map((look) => Object.assign(new Curve(), look));
    return { label, note: "", tall, least, dashed, series, range: [0, 1], log: false, dots: false };
  }

  levels(limits) {
    if (!limits) return [];
    const few = (values) => [...new Set([values].flat().filter((x) => x !== null))];
    return [{ label: "limits", values: [...few(limits.tension_min), ...few(limits.tension_max)] }];
  }

  // Current limits.
  limit(limits) {
    const text = JSON.stringify(limits);
    if (!this.tension || text === this.known) return;
    this.known = text;
    this.tension.dashed = this.levels(limits);
    this.live.redraw();
  }

  add(message) {
    if (!this.tension) return;
    if (message.reset) this.clear();
    const { t = [], tension = [], position_error: away = [], attitude_error: turned = [], length = [] } = message;
    t.forEach((time, k) => {
      this.tension.series.forEach((curve, i) => curve.add(time, tension[k]?.[i] ?? null));
      this.length.series.forEach((curve, i) => curve.add(time, length[k]?.[i] ?? null));
      this.position.series[0].add(time, away[k] == null ? null : 1e3 * away[k]);
      this.attitude.series[0].add(time, turned[k] == null ? null : 1e3 * turned[k]);
    });
    for (const panel of this.panels) for (const curve of panel.series) curve.settle();
    if (t.length) this.latest = t[t.length - 1];
    if (this.following) this.follow(); else this.live.redraw();
  }

  clear() {
    for (const panel of this.panels) panel.series.forEach((curve) => curve.clear());
    this.latest = 0;
    this.follow();
  }

  // Show the last seconds, continuously.
  follow() {
    this.following = true;
    this.back.hidden = true;
    // At first the axis has the smallest sufficient span, so that it is constant and well filled.
    const soon = SPANS.find((seconds) => seconds >= this.latest) ?? this.latest;
    const end = this.span ? Math.max(this.latest, Math.min(soon, this.span)) : soon;
    this.live.window = [this.span ? Math.max(0, end - this.span) : 0, end];
    this.live.redraw();
  }

  // Show a fixed part of the time.
  hold(from, to) {
    this.following = false;
    this.back.hidden = false;
    const middle = 0.5 * (from + to), half = Math.max(0.5 * (to - from), 1e-4);
    this.live.window = [Math.max(0, middle - half), middle + half];
    this.live.redraw();
  }

  draw() {
    for (const plot of this.plots) if (plot.visible) { if (plot.stale) plot.draw(); else plot.follow(); }
  }
}
