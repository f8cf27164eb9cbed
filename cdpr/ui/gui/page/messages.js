// Server output: status sentence, current numbers, events and messages.

const LEVELS = { building: "wait", ready: "good", running: "good", paused: "good", done: "good", ended: "warn", failed: "bad" };
// Default texts of phases.
const PHASES = {
  building: "Building the simulation …", ready: "Ready to run.", running: "Running.", paused: "Paused.",
  done: "The run is complete.", ended: "The run has ended early.", failed: "There is nothing to run.",
};
const TROUBLES = {
  INFEASIBLE: "no tensions within the limits balance the required wrench",
  NOT_FOUND: "the solver has found no tensions",
  UNSUPPORTED: "the solver does not support this robot",
  BAD_INPUT: "the solver's input is not finite",
  DIVERGED: "the motion has diverged",
};
const MOST_MESSAGES = 200;

class Output {
  constructor(list, home, live) {
    this.live = live;
    this.tabs = new Tabs(list, home, "output");
    this.numbers = make("table", { className: "numbers", "aria-label": "Numbers" });
    this.tensions = make("table", { className: "numbers", "aria-label": "Tensions" });
    this.events = make("ol", { className: "events" });
    this.messages = make("ol", { className: "messages", "aria-live": "polite" });
    this.tabs.panel("numbers", "Numbers").append(this.numbers, this.tensions);
    this.tabs.panel("events", "Events").append(this.events);
    this.tabs.panel("messages", "Messages").append(this.messages);
    this.unread = 0;
    list.addEventListener("click", () => this.seen());
  }

  // Rows of numbers for a robot: the platform, then its cables.
  load({ scene: { cables } }) {
    this.cells = {};
    const row = (key, name, unit, parts) => {
      this.cells[key] = parts.map(() => make("td", { className: "n" }));
      const last = make("td", { className: "unit", text: unit });
      return make("tr", {}, make("th", { scope: "row", text: name }), ...this.cells[key], last);
    };
    const xyz = ["x", "y", "z"], heads = xyz.map((text) => make("th", { scope: "col", text, className: "n" }));
    const pose = make("tbody", {}, make("tr", {}, make("td"), ...heads, make("td")),
      row("p", "position", "m", xyz), row("dp", "desired", "m", xyz), row("a", "attitude", "deg", xyz),
      row("da", "desired", "deg", xyz), row("force", "force", "N", xyz));
    this.numbers.replaceChildren(pose);
    this.cables = cables.map((name, i) => {
      const cells = [make("th", { scope: "row", text: `${i + 1} ${name}`, title: name }), make("td", { className: "n gauge" }), make("td", { className: "unit" })];
      for (const cell of cells) {
        cell.addEventListener("pointerenter", () => this.live.select(i));
        cell.addEventListener("pointerleave", () => this.live.select(null));
      }
      return cells;
    });
    const pair = (i) => make("tr", {}, ...this.cables.slice(i, i + 2).flat()); // two per line, so that eight are visible
    this.tensions.replaceChildren(make("tbody", {}, ...cables.map((_, i) => i).filter((i) => i % 2 === 0).map(pair)));
    this.jammed = new Set();
    this.counted = 0;
  }

  // At most ten updates a second, for readability.
  count(frame, most) {
    const now = performance.now();
    if (!this.cells || now - (this.counted || 0) < 100) return;
    this.counted = now;
    const put = (key, values, digits) => this.cells[key].forEach((cell, i) => {
      const x = values?.[i];
      setText(cell, x === null || x === undefined ? "–" : x.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−"));
    });
    const degrees = (q) => q && q[0] !== null && anglesOf(q).map(toDegrees);
    put("p", frame.p, 4);
    put("dp", frame.dp, 4);
    put("a", degrees(frame.q), 2);
    put("da", degrees(frame.dq), 2);
    put("force", frame.force, 1);
    const { broken, slack } = this.live.data.states;
    this.cables.forEach(([, cell, unit], i) => {
      const tension = frame.tension?.[i], state = frame.state?.[i], gone = state === broken;
      setText(cell, gone ? "broken" : tension === null || tension === undefined ? "–" : tension.toFixed(1));
      setText(unit, gone ? "" : this.jammed.has(i) ? "jammed" : state === slack ? "slack" : "N");
      cell.style.backgroundSize = `${gone || !(tension > 0) ? 0 : (100 * clamp(tension / most, 0, 1)).toFixed(1)}% 100%`;
    });
  }

  // Latest image of each camera, in a tab that only scenarios with cameras have.
  picture({ cameras }) {
    if (!cameras.length) { this.tabs.keep([...this.tabs.all.keys()].filter((key) => key !== "images")); return; }
    const box = ({ name, t, png }) => make("figure", {},
      make("figcaption", { text: t === null ? `${name}: no image before the first step` : `${name}, ${t.toFixed(3)} s` }),
      png ? make("img", { src: `data:image/png;base64,${png}`, alt: `Image of camera ${name}` }) : null);
    this.tabs.panel("images", "Images").replaceChildren(make("div", { className: "cameras" }, ...cameras.map(box)));
  }

  // Status sentence: the server's text if it has one.
  status(status) {
    const root = document.getElementById("status"), trouble = TROUBLES[status.status];
    const known = PHASES[status.phase] || status.phase, name = (status.status || "").toLowerCase().replace("_", " ");
    root.className = trouble ? "bad" : LEVELS[status.phase] || "good";
    const text = status.text || (trouble ? `${known.replace(/\.$/, "")}; ${name}: ${trouble}.` : known);
    setText(root.querySelector(".text"), text);
    this.report(status, text, Boolean(trouble));
    setText(document.getElementById("rtf"), Number.isFinite(status.rtf) ? status.rtf.toFixed(2) : "–");
    const parts = [status.backend, status.solver, status.controller].filter(Boolean);
    setText(document.getElementById("parts"), parts.join(" · ") || "–");
    this.jammed = new Set((status.cables || []).flatMap(({ jammed }, i) => (jammed ? [i] : [])));
    this.counted = 0; // a status follows the last frame: refresh numbers and cable states
    this.live.wake();
    this.happened(status.events || []);
  }

  // Errors are also shown as a message, once, because the status line changes.
  report({ phase, status }, text, trouble) {
    const wrong = trouble || ["ended", "failed"].includes(phase) ? [phase, status].join() : "";
    if (wrong && wrong !== this.reported && this.messages.firstChild?.dataset.text !== text) {
      this.message({ level: trouble || phase === "failed" ? "error" : "warning", text });
    }
    this.reported = wrong;
  }

  happened(events) {
    const text = JSON.stringify(events);
    if (text === this.known) return;
    this.known = text;
    const item = ({ t, text }) => make("li", {}, make("b", { text: `${t.toFixed(3)} s` }), ` ${text}`);
    this.events.replaceChildren(...events.map(item));
    if (!events.length) this.events.append(make("li", { className: "none", text: "No events yet." }));
    this.tabs.count("events", events.length);
    this.live.data.events = events.map(({ t, text }) => ({ time: t, text }));
    this.live.redraw();
  }

  message({ level, text }) {
    const now = make("time", { text: new Date().toTimeString().slice(0, 8) });
    this.messages.prepend(make("li", { className: { error: "bad", warning: "warn" }[level] || "", "data-text": text }, now, ` ${text}`));
    while (this.messages.children.length > MOST_MESSAGES) this.messages.lastChild.remove();
    if (this.tabs.chosen !== "messages") {
      this.unread += 1;
      this.tabs.count("messages", this.unread);
      if (level !== "info") this.tabs.choose("messages"); // show warnings and errors immediately
    }
    this.seen();
  }

  seen() {
    if (this.tabs.chosen !== "messages") return;
    this.unread = 0;
    this.tabs.count("messages", 0);
  }
}
