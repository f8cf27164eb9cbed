// Run, pause, step, reset, speed and emergency stop, with their keyboard shortcuts.

const SPEEDS = [[0.1, "0.1×"], [1, "1×"], [null, "max"]];
const OVER = ["done", "ended", "failed"]; // phases that only a reset ends

class Transport {
  constructor(home, live) {
    this.live = live;
    this.phase = null;
    this.run = button("", () => this.toggle(), { className: "run main", title: "Space" });
    this.step = button("", () => this.once(), { "aria-label": "Step", title: "One control step: . (with Shift ten)" });
    this.step.append(sign("step"), "Step");
    this.reset = button("", () => live.send({ do: "reset" }), { "aria-label": "Reset", title: "Back to the start: R" });
    this.reset.append(sign("reset"), "Reset");
    this.speeds = SPEEDS.map(([value, text]) => button(text, () => live.send({ do: "speed", value }), {
      "aria-label": value === null ? "Maximum speed" : `Speed ${value}`, "aria-pressed": "false",
    }));
    this.bar = make("progress", { max: 1, value: 0, "aria-label": "Progress of the run" });
    this.time = make("output", { id: "time", text: "–" });
    const title = "Same as the event emergency_stop";
    this.stop = button("Emergency stop", () => live.send({ do: "stop" }), { className: "stop", title });
    const speeds = make("span", { className: "speeds", role: "group", "aria-label": "Speed" }, ...this.speeds);
    home.append(this.reset, this.run, this.step, speeds, this.bar, this.time, this.stop);
    this.show({ phase: "building" });
    document.addEventListener("keydown", (event) => this.key(event));
  }

  toggle() {
    if (OVER.includes(this.phase)) this.live.send({ do: "reset" });
    this.live.send({ do: this.phase === "running" ? "pause" : "run" });
  }

  once(n = 1) { this.live.send({ do: "step", n }); }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest?.("input, select, textarea, dialog, summary")) return; // typing
    const ten = () => this.once(10), reset = () => this.live.send({ do: "reset" });
    const act = { " ": () => this.toggle(), ".": () => this.once(), ":": ten, ">": ten, r: reset }[event.key.toLowerCase()];
    const pushes = event.key === " " && (event.repeat || event.target.closest?.("button")); // the focused button
    if (!act || pushes) return;
    event.preventDefault();
    act();
  }

  show(status) {
    this.phase = status.phase;
    this.duration = status.duration;
    const running = status.phase === "running", over = OVER.includes(status.phase);
    const word = running ? "Pause" : over ? "Run again" : "Run";
    if (this.word !== word) {
      this.run.replaceChildren(sign(running ? "pause" : "run"), word);
      this.run.setAttribute("aria-label", word);
      this.word = word;
    }
    this.run.disabled = status.phase === "building";
    this.step.disabled = running || over || status.phase === "building";
    this.stop.disabled = over;
    this.speeds.forEach((node, i) => node.setAttribute("aria-pressed", String((status.speed ?? null) === SPEEDS[i][0])));
    if (Number.isFinite(status.t)) this.tick(status.t);
  }

  tick(t) {
    const whole = Number.isFinite(this.duration) && this.duration > 0;
    setText(this.time, whole ? `${t.toFixed(3)} of ${shortNumber(this.duration)} s` : `${t.toFixed(3)} s`);
    setText(document.getElementById("now"), `${t.toFixed(3)} s`);
    this.bar.hidden = !whole;
    if (whole) this.bar.value = clamp(t / this.duration, 0, 1);
  }
}
