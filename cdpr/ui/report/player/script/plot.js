// Panel: curves over time, limits, shades and events, on two canvases: static content, and the time cursor.

const EDGE = { left: 58, right: 22, top: 8, bottom: 6 };
const TAG = "600 10px system-ui, sans-serif", WIDEST_TAG = 58; // names at line ends; longer ones are only in the legend
const TIME_ROOM = 20; // pixels below the last panel of a figure
const POWERS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

class Plot {
  constructor(home, panel, data, state, last) {
    Object.assign(this, { panel, data, state, last });
    this.visible = false;
    this.stale = true;
    this.root = document.createElement("div");
    this.root.className = "plot";
    this.root.innerHTML = '<p class="label"></p><div class="area" tabindex="0" role="img"><canvas></canvas><canvas></canvas></div>'
      + '<div class="series" role="group"></div>';
    this.root.querySelector(".label").textContent = panel.label + (panel.note ? ` – ${panel.note}` : "");
    this.area = this.root.querySelector(".area");
    this.area.style.height = `${Math.round(78 * Math.max(panel.tall, 1.5)) + (last ? TIME_ROOM : 0)}px`;
    this.area.setAttribute("aria-label", `${panel.label} over time. ${state.hint}`);
    [this.base, this.top] = this.area.querySelectorAll("canvas");
    home.append(this.root);
    this.measure();
    this.legend();
    this.hands();
    new ResizeObserver(() => { this.stale = true; this.state.wake(); }).observe(this.area);
    new IntersectionObserver(([entry]) => {
      this.visible = entry.isIntersecting;
      this.state.wake();
    }, { rootMargin: "100px" }).observe(this.root);
  }

  key(series) { return series.group ? `${series.group}:${series.name}` : ""; }
  hidden(series) { return this.off?.has(series) || this.state.hidden.has(this.key(series)); }
  colour(series) { return series.colour[this.state.dark ? 1 : 0]; }
  tag(series, i) { return series.group === "cable" ? String(i + 1) : series.name; }
  get noise() { return 1e-9 * Math.max(...this.range.map(Math.abs)); } // smaller values are round-off, shown as 0
  get right() { return this.state.right ?? EDGE.right; } // common to all plots, which share the time axis

  // Names at line ends, if there are several and all are short, and their width.
  measure() {
    const c = this.base.getContext("2d");
    c.font = TAG;
    const tags = this.panel.series.map((series, i) => (["over", "band"].includes(series.group) ? "" : this.tag(series, i)));
    const wide = Math.max(0, ...tags.map((tag) => c.measureText(tag).width));
    this.tags = tags.length > 1 && wide <= WIDEST_TAG ? tags : tags.map(() => "");
    if (this.tags.some(Boolean)) this.state.right = Math.max(this.right, Math.ceil(wide) + 8);
  }

  // Buttons that toggle series, each with its value at the cursor or current time.
  legend() {
    const home = this.root.querySelector(".series");
    home.setAttribute("aria-label", `Series of ${this.panel.label}`);
    this.off = new Set();
    const bands = new Set(); // names of bands, whose lines share one entry without a value
    this.entries = this.panel.series.flatMap((series, i) => {
      const band = series.group === "band";
      if (band && bands.has(series.name)) return [];
      if (band) bands.add(series.name);
      const button = document.createElement("button");
      button.type = "button";
      button.innerHTML = '<svg width="22" height="8" aria-hidden="true"><line x1="1" x2="21" y1="4" y2="4"/></svg><span></span><b></b>';
      const number = series.group === "cable" && this.panel.series.length > 1 ? `${i + 1} ` : "";
      button.querySelector("span").textContent = number + (series.name || this.panel.label.replace(/ \(.*/, ""));
      button.addEventListener("click", () => {
        const key = this.key(series), set = key ? this.state.hidden : this.off, item = key || series;
        if (set.has(item)) set.delete(item); else set.add(item);
        this.state.restyle();
      });
      button.addEventListener("pointerenter", () => this.state.select(series.group === "cable" ? i : null));
      button.addEventListener("pointerleave", () => this.state.select(null));
      home.append(button);
      return [{ series, button, value: band ? null : button.querySelector("b") }];
    });
    for (const limit of this.panel.dashed) {
      const span = document.createElement("span");
      span.className = "limit";
      span.textContent = `- - ${limit.label}`;
      home.append(span);
    }
    this.dress();
  }

  dress() {
    for (const { series, button } of this.entries) {
      const line = button.querySelector("line");
      if (series.thing) line.dataset.thing = series.thing;
      line.style.stroke = series.group === "band" ? this.data.colours.soft[this.state.dark ? 1 : 0] : this.colour(series);
      line.style.strokeWidth = Math.max(2, series.width + 0.6);
      line.style.strokeDasharray = series.dash.map((x) => x * series.width).join(" ");
      button.setAttribute("aria-pressed", String(!this.hidden(series)));
    }
  }

  x(t) { const [a, b] = this.state.window; return EDGE.left + (t - a) / (b - a) * this.width; }
  timeAt(x) { const [a, b] = this.state.window; return clamp(a + (x - EDGE.left) / this.width * (b - a), a, b); }
  y(v) { const [a, b] = this.range; return EDGE.top + (b - v) / (b - a) * this.height; }

  layout() {
    const box = this.area.getBoundingClientRect(), ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (box.width === 0) return false;
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    for (const canvas of [this.base, this.top]) {
      if (canvas.width === width && canvas.height === height) continue; // slow even if unchanged
      canvas.width = width;
      canvas.height = height;
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.size = [box.width, box.height];
    this.width = box.width - EDGE.left - this.right;
    this.height = box.height - EDGE.top - EDGE.bottom - (this.last ? TIME_ROOM : 0);
    return true;
  }

  // Full range, or that of the visible time.
  spread() {
    if (!this.state.zoomed) return this.panel.range;
    const [from, to] = this.state.window;
    let low = Infinity, high = -Infinity;
    for (const series of this.panel.series) {
      if (this.hidden(series)) continue;
      const stop = Math.min(indexAt(series.time, to) + 1, series.value.length - 1);
      for (let i = indexAt(series.time, from); i <= stop; i++) {
        if (series.value[i] < low) low = series.value[i];
        if (series.value[i] > high) high = series.value[i];
      }
    }
    if (!(high >= low)) return this.panel.range;
    const reach = Math.max(high - low, this.panel.least); // limits farther away are not shown
    for (const value of this.panel.dashed.flatMap((limit) => limit.values)) {
      if (value < low && low - value <= reach) low = value;
      if (value > high && value - high <= reach) high = value;
    }
    const room = Math.max(high - low, this.panel.least * 0.1, 1e-4 * Math.max(Math.abs(low), Math.abs(high)), 1e-15);
    const middle = 0.5 * (low + high);
    return [middle - 0.56 * room, middle + 0.56 * room];
  }

  draw() {
    if (!this.layout()) return;
    this.stale = false;
    this.range = this.spread();
    const c = this.base.getContext("2d"), dark = this.state.dark ? 1 : 0;
    c.clearRect(0, 0, ...this.size);
    c.font = "11px system-ui, sans-serif";
    this.shades(c, dark);
    this.grid(c, dark);
    c.save();
    c.beginPath();
    c.rect(EDGE.left, EDGE.top - 2, this.width, this.height + 4);
    c.clip();
    this.happenings(c, dark);
    for (const limit of this.panel.dashed) for (const value of limit.values) this.level(c, value, dark);
    for (const series of this.panel.series) if (!this.hidden(series)) this.curve(c, series);
    c.restore();
    this.names(c);
    this.shown = null;
    this.follow();
  }

  shades(c, dark) {
    for (const { colour, intervals } of this.data.shades) {
      c.fillStyle = colour[dark];
      for (const [a, b] of intervals) {
        const left = clamp(this.x(a), EDGE.left, EDGE.left + this.width);
        const right = clamp(Math.max(this.x(b), this.x(a) + 1.5), EDGE.left, EDGE.left + this.width);
        c.fillRect(left, EDGE.top, right - left, this.height);
      }
    }
  }

  grid(c, dark) {
    const line = this.data.colours.grid[dark], text = this.data.colours.soft[dark];
    const [low, high] = this.range, [from, to] = this.state.window;
    c.lineWidth = 1;
    c.strokeStyle = line;
    c.fillStyle = text;
    c.textBaseline = "middle";
    c.textAlign = "right";
    let count = Math.max(this.height < 24 ? 1 : 2, this.height / 32), step = niceStep(high - low, count); // two numbers where three would touch
    const alone = () => Math.floor(high / step + 1e-9) <= Math.ceil(low / step); // a single number shows no scale
    while (!this.panel.log && count > 1 && count < this.height / 12 && alone()) step = niceStep(high - low, count *= 1.5);
    if (this.panel.log) step = Math.max(1, Math.ceil(step));
    for (let v = Math.ceil(low / step) * step; v <= high + 1e-9 * step; v += step) {
      const y = Math.round(this.y(v)) + 0.5;
      c.beginPath();
      c.moveTo(EDGE.left, y);
      c.lineTo(EDGE.left + this.width, y);
      c.stroke();
      c.fillText(this.panel.log ? power(v) : tick(v, step), EDGE.left - 6, y);
    }
    const every = niceStep(to - from, Math.max(2, this.width / 70));
    c.textAlign = "center";
    c.textBaseline = "top";
    for (let t = Math.ceil(from / every - 1e-9) * every; t <= to + 1e-9 * every; t += every) {
      const x = Math.round(this.x(t)) + 0.5;
      c.beginPath();
      c.moveTo(x, EDGE.top);
      c.lineTo(x, EDGE.top + this.height);
      c.stroke();
      if (this.last) c.fillText(tick(t, every) + (t + every > to + 1e-9 * every ? " s" : ""), x, EDGE.top + this.height + 7);
    }
  }

  happenings(c, dark) {
    c.strokeStyle = c.fillStyle = this.data.colours.ink[dark];
    c.setLineDash([1, 3]);
    for (const event of this.data.events) {
      const x = Math.round(this.x(event.time)) + 0.5;
      c.beginPath();
      c.moveTo(x, EDGE.top);
      c.lineTo(x, EDGE.top + this.height);
      c.stroke();
    }
    c.setLineDash([]);
    c.font = "600 10px system-ui, sans-serif";
    c.textAlign = "left";
    c.textBaseline = "top";
    let free = -Infinity;
    this.data.events.forEach((event, i) => {
      const x = this.x(event.time);
      if (x < free) return;
      free = x + 16;
      const text = String(i + 1), room = EDGE.left + this.width - x > 4 + c.measureText(text).width;
      c.fillText(text, room ? x + 3 : x - 3 - c.measureText(text).width, EDGE.top); // at the end, text is left of its line
    });
  }

  level(c, value, dark) {
    c.strokeStyle = this.data.colours.soft[dark];
    c.lineWidth = 1.3;
    c.setLineDash([7, 4]);
    c.beginPath();
    c.moveTo(EDGE.left, this.y(value));
    c.lineTo(EDGE.left + this.width, this.y(value));
    c.stroke();
    c.setLineDash([]);
  }

  curve(c, series) {
    const { time, value } = series, [from, to] = this.state.window;
    c.strokeStyle = c.fillStyle = this.colour(series);
    c.lineWidth = series.width + (this.state.selected !== null && series.group === "cable"
      && this.panel.series.indexOf(series) === this.state.selected ? 2 : 0.3);
    c.lineJoin = "round";
    c.setLineDash(series.dash.map((x) => x * series.width));
    c.beginPath();
    let pen = false;
    const stop = Math.min(indexAt(time, to) + 1, value.length - 1);
    for (let i = indexAt(time, from); i <= stop; i++) {
      if (Number.isNaN(value[i])) { pen = false; continue; }
      const x = this.x(time[i]), y = clamp(this.y(value[i]), -1e4, 1e4);
      if (pen) c.lineTo(x, y); else c.moveTo(x, y);
      pen = true;
    }
    c.stroke();
    c.setLineDash([]);
    if (!this.panel.dots) return;
    for (let i = 0; i < value.length; i++) {
      c.beginPath();
      c.arc(this.x(time[i]), this.y(value[i]), 2.5, 0, 7);
      c.fill();
    }
  }

  // Names at line ends, moved apart: lines must not be distinguished by colour only.
  names(c) {
    const tags = [];
    this.panel.series.forEach((series, i) => {
      if (this.hidden(series) || !this.tags[i] || !series.value.length) return;
      let k = Math.min(indexAt(series.time, this.state.window[1]), series.value.length - 1);
      while (k > 0 && Number.isNaN(series.value[k])) k--;
      const y = clamp(this.y(series.value[k]), EDGE.top, EDGE.top + this.height);
      if (Number.isFinite(y)) tags.push({ y, text: this.tags[i], colour: this.colour(series) });
    });
    tags.sort((a, b) => a.y - b.y);
    const gap = Math.min(11, this.height / Math.max(tags.length, 1));
    for (let i = 1; i < tags.length; i++) tags[i].y = Math.max(tags[i].y, tags[i - 1].y + gap);
    for (let i = tags.length - 1, limit = EDGE.top + this.height; i >= 0; i--, limit -= gap) tags[i].y = Math.min(tags[i].y, limit);
    c.textAlign = "left";
    c.textBaseline = "middle";
    c.font = TAG;
    for (const { y, text, colour } of tags) {
      c.fillStyle = colour;
      c.fillText(text, EDGE.left + this.width + 4, y);
    }
  }

  // Line at the current time, and at the cursor with dots; values are shown in the legend.
  follow() {
    if (!this.size) return;
    const hover = this.state.hover, t = hover ?? this.state.time;
    const shown = [Math.round(this.x(this.state.time)), hover, this.dragged, this.state.playing ? 0 : t].join();
    if (shown === this.shown) return; // unchanged to a pixel
    this.shown = shown;
    const c = this.top.getContext("2d"), dark = this.state.dark ? 1 : 0;
    c.clearRect(0, 0, ...this.size);
    this.upright(c, this.state.time, this.data.colours.ink[dark], 1.6);
    if (hover !== null) this.upright(c, hover, this.data.colours.soft[dark], 1);
    for (const { series, value } of this.entries) {
      if (!value) continue;
      const k = series.time.length ? nearest(series.time, t) : -1, v = k < 0 ? NaN : series.value[k];
      const text = this.panel.log ? shortNumber(10 ** v) : shortNumber(Math.abs(v) < this.noise ? 0 : v);
      if (value.textContent !== text) value.textContent = text;
      if (this.hidden(series) || Number.isNaN(v) || hover === null) continue;
      c.fillStyle = this.colour(series);
      c.beginPath();
      c.arc(this.x(series.time[k]), clamp(this.y(v), 0, this.size[1]), 3, 0, 7);
      c.fill();
    }
    if (this.dragged) {
      c.fillStyle = `${this.data.colours.ink[dark]}1f`;
      c.fillRect(Math.min(...this.dragged), EDGE.top, Math.abs(this.dragged[1] - this.dragged[0]), this.height);
    }
  }

  upright(c, t, colour, width) {
    const x = this.x(t);
    if (x < EDGE.left - 1 || x > EDGE.left + this.width + 1) return;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.beginPath();
    c.moveTo(x, EDGE.top - 4);
    c.lineTo(x, EDGE.top + this.height + 2);
    c.stroke();
  }

  hands() {
    const area = this.area, x = (event) => event.clientX - area.getBoundingClientRect().left;
    let down = null;
    area.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !this.size) return;
      down = x(event);
      area.setPointerCapture(event.pointerId);
      if (event.pointerType === "touch") this.state.seek(this.timeAt(down));
    });
    area.addEventListener("pointermove", (event) => {
      if (!this.size) return;
      if (event.pointerType === "touch") {
        if (down !== null) this.state.seek(this.timeAt(x(event)));
        return;
      }
      this.state.point(this.timeAt(x(event)));
      this.dragged = down !== null && Math.abs(x(event) - down) > 6 ? [down, x(event)] : null;
    });
    area.addEventListener("pointerup", (event) => {
      const [from, dragged] = [down, this.dragged];
      down = this.dragged = null;
      if (from === null || event.pointerType === "touch") return;
      if (dragged) this.state.zoom(this.timeAt(Math.min(...dragged)), this.timeAt(Math.max(...dragged)));
      else this.state.seek(this.timeAt(from));
    });
    area.addEventListener("pointercancel", () => { down = this.dragged = null; });
    area.addEventListener("pointerleave", () => this.state.point(null));
    area.addEventListener("dblclick", () => this.state.whole());
  }
}

function tick(value, step) {
  if (Math.abs(value) < 1e-9 * step && step < 1e-4) return "0";
  const digits = clamp(-Math.floor(Math.log10(step) + 1e-9) + (/25$/.test(String(step).replace(".", "")) ? 1 : 0), 0, 12);
  if (Math.abs(value) >= 1e6 || (step < 1e-4 && value !== 0)) return value.toExponential(1).replace(".0e", "e").replace(/-/g, "−");
  return (Math.abs(value) < 1e-12 * step ? 0 : value).toFixed(digits).replace("-", "−");
}

function power(value) {
  return "10" + String(Math.round(value)).replace("-", "⁻").replace(/\d/g, (d) => POWERS[d]);
}
