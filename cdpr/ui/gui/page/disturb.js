// Disturbances of a running robot: pushes, payloads, cable faults, limits, targets and jogs; and saving the session.

class Disturb {
  constructor(home, live) {
    this.live = live;
    this.pushes = make("span", { className: "pushes" });
    this.cable = make("select", { id: "cable", "aria-label": "Cable to cut or jam" });
    this.changes = live.output.tabs.panel("change", "Change");
    this.parts = [this.push(), this.payload(), this.cables(), this.limits(), this.target(), this.winches(), this.sensing()];
    home.append(...this.parts, this.saving());
  }

  part(title, ...inputs) { return make("fieldset", {}, make("legend", { text: title }), ...inputs); }

  // Number fields of a group; the second word of the label precedes them.
  numbers(label, names, unit, values = names.map(() => "0")) {
    const inputs = names.map((name, i) => numberBox(name ? `${label}, ${name}` : label, { value: values[i], title: name || label }));
    const root = make("span", { className: "vector" }, span("what", label.replace(/^\w+ /, "")), ...inputs, span("unit", unit));
    return { inputs, root };
  }

  // Numbers in fields, `empty` for empty fields; undefined, with marked fields, for invalid input.
  read({ inputs }, empty = null) {
    const values = inputs.map((input) => (input.value.trim() === "" ? empty : reading(input.value)));
    const sound = values.map((value) => typeof value === "number" || value === empty);
    inputs.forEach((input, i) => input.setAttribute("aria-invalid", String(!sound[i])));
    if (!sound.includes(false)) return values;
    this.live.note("error", "Enter a number in the marked field: nothing was sent.");
    return undefined;
  }

  push() {
    const force = this.numbers("Push force", ["x", "y", "z"], "N"), moment = this.numbers("Push moment", ["x", "y", "z"], "N m");
    const last = this.numbers("Push duration", [""], "s", ["0.5"]);
    last.inputs[0].title = "Empty: until released";
    const act = () => {
      const [f, m, d] = [this.read(force, 0), this.read(moment, 0), this.read(last)];
      if (f && m && d) this.live.send({ do: "push", force: f, moment: m, duration: d[0] });
    };
    return this.part("Push", force.root, moment.root, last.root, button("Push", act), this.pushes);
  }

  payload() {
    const mass = this.numbers("Payload mass", [""], "kg", ["10"]), center = this.numbers("Payload center", ["x", "y", "z"], "m");
    const known = make("input", { type: "checkbox", title: "The controller takes it into account" });
    const act = () => {
      const [m, c] = [this.read(mass), this.read(center, 0)];
      if (m && c) this.live.send({ do: "attach", mass: m[0], center: c, known: known.checked });
    };
    const label = make("label", {}, known, span("what", "known"));
    return this.part("Payload", mass.root, center.root, label, button("Attach", act, { title: "Until released" }));
  }

  cables() {
    const act = (what) => () => { if (this.cable.value) this.live.send({ do: what, cable: this.cable.value }); };
    this.cable.addEventListener("change", () => this.live.select(this.cable.selectedIndex));
    this.cable.addEventListener("blur", () => this.live.select(null));
    const cut = button("Cut", act("cut"), { title: "The cable breaks" });
    return this.part("Cable", this.cable, cut, button("Jam", act("jam"), { title: "The tension of the cable no longer changes" }));
  }

  // Failure and occlusion of a sensor, and a step of its bias.
  sensing() {
    this.sensor = make("select", { id: "sensor", "aria-label": "Sensor to disturb" });
    const time = this.numbers("Occlusion time", [""], "s", ["0.5"]), step = this.numbers("Sensor bias", [""], "", ["0.01"]);
    step.inputs[0].title = "Added to the first quantity of the sensor, in its unit";
    const send = (what, more) => { if (this.sensor.value) this.live.send({ do: what, sensor: this.sensor.value, ...more }); };
    const occlude = () => { const d = this.read(time); if (d) send("occlude_sensor", { duration: d[0] }); };
    const bump = () => { const b = this.read(step); if (b) send("bump_sensor", { bias: b[0] }); };
    this.sensors = this.part("Sensor", this.sensor, button("Fail", () => send("fail_sensor"), { title: "No measurements from now on" }),
      time.root, button("Occlude", occlude, { title: "No measurements for this time" }), step.root, button("Bump", bump, { title: "The bias jumps" }));
    this.sensors.hidden = true;
    return this.sensors;
  }

  limits() {
    this.least = this.numbers("Tension min", [""], "", [""]);
    this.most = this.numbers("Tension max", [""], "N", [""]);
    const act = () => {
      const [low, high] = [this.read(this.least), this.read(this.most)];
      if (!low || !high) return;
      const given = { do: "limits" };
      if (low[0] !== null) given.tension_min = low[0];
      if (high[0] !== null) given.tension_max = high[0];
      this.live.send(given);
    };
    const title = "Tension limits of all cables from now on; empty: unchanged";
    return this.part("Limits", this.least.root, this.most.root, button("Set", act, { "aria-label": "Set limits", title }));
  }

  target() {
    const position = this.numbers("Target position", ["x", "y", "z"], "m", ["", "", ""]);
    const attitude = this.numbers("Target rpy", ["roll", "pitch", "yaw"], "deg");
    const within = this.numbers("Target in", [""], "s", [""]);
    within.inputs[0].title = "Empty: chosen automatically";
    const go = () => {
      const [p, rpy, seconds] = [this.read(position), this.read(attitude, 0), this.read(within)];
      if (!p || !rpy || !seconds) return;
      const here = this.live.frame?.dp || this.live.frame?.p || [0, 0, 0]; // default: stay in place
      const duration = seconds[0] === null ? {} : { duration: seconds[0] };
      this.live.send({ do: "target", position: p.map((x, i) => x ?? here[i]), rpy: rpy.map(toRadians), ...duration });
    };
    const here = () => {
      const { frame } = this.live;
      if (!frame) return;
      rounded(frame.p).forEach((x, i) => { position.inputs[i].value = x; });
      rounded(anglesOf(frame.q).map(toDegrees), 0.01).forEach((x, i) => { attitude.inputs[i].value = x; });
    };
    return this.part("Target", position.root, attitude.root, within.root, button("Go", go, { "aria-label": "Go to the target" }),
      button("Here", here, { title: "Fill in the current pose" }));
  }

  // Jog of single winches that take lengths or rates; all others hold.
  winches() {
    const label = "Winch to jog", rate = this.numbers("Jog rate", [""], "m/s", ["0.05"]), end = this.numbers("Jog to", [""], "m", [""]);
    rate.inputs[0].title = "Positive pays out, negative winds in";
    end.inputs[0].title = "Unwound length at which the winch stops; empty: it winds until Hold";
    this.winch = make("select", { id: "winch", "aria-label": label });
    this.unwound = make("output", { className: "unit", "aria-label": "Unwound length", title: "Unwound length" });
    const act = () => {
      const [speed, length] = [this.read(rate), this.read(end)];
      if (!speed || !length) return;
      const to = length[0] === null ? {} : { length: length[0] };
      this.live.send({ do: "jog", cable: this.winch.value, rate: speed[0], ...to });
    };
    const hold = button("Hold", () => this.live.send({ do: "hold" }), { title: "All winches hold their lengths; the controller has no effect" });
    this.back = button("Controller", () => this.live.send({ do: "control" }), { title: "Return control of the winches to the controller" });
    this.winch.addEventListener("change", () => {
      this.live.select([...this.cable.options].findIndex(({ value }) => value === this.winch.value));
      this.measure();
    });
    this.winch.addEventListener("blur", () => this.live.select(null));
    this.jog = this.part("Winch", this.winch, this.unwound, rate.root, end.root, button("Jog", act), hold, this.back);
    this.jog.hidden = true;
    return this.jog;
  }

  // Present unwound length of the chosen winch.
  measure() {
    const length = this.wound.find(({ name }) => name === this.winch.value)?.unwound;
    setText(this.unwound, Number.isFinite(length) ? `${length.toFixed(4)} m` : "");
  }

  saving() {
    const { files } = this.live;
    const run = files.keep("save_run", "Save the run as a folder", "", "a new one in runs/");
    const session = files.keep("save_session", "Save the session as a scenario", "session.yaml");
    return this.part("Save", button("Save run…", () => run.showModal(), { title: "Folder with log, summary and report, as from cdpr run" }),
      button("Save session…", () => session.showModal(), { title: "Scenario with all live changes as events" }));
  }

  load({ limits }) {
    if (!limits) return;
    const one = (values) => { const all = [...new Set([values].flat())]; return all.length === 1 ? String(all[0] ?? "") : ""; };
    this.least.inputs[0].value = one(limits.tension_min);
    this.most.inputs[0].value = one(limits.tension_max);
  }

  // Ended or failed runs cannot be disturbed, but can be saved.
  show({ phase, cables = [], pushes = [], changeable = [], winches = [], sensors = [], manual = false }) {
    for (const part of this.parts) {
      part.disabled = OVER.includes(phase);
      part.title = part.disabled ? "The run is over: reset it, or run it again" : "";
    }
    const text = JSON.stringify([cables, pushes]);
    if (text !== this.known) {
      this.known = text;
      const before = this.cable.value, fate = ({ broken, jammed }) => (broken ? " (broken)" : jammed ? " (jammed)" : "");
      this.cable.replaceChildren(...cables.map((cable, i) => option(cable.name, `${i + 1} ${cable.name}${fate(cable)}`)));
      if (cables.some(({ name }) => name === before)) this.cable.value = before;
      const release = (id) => () => this.live.send({ do: "release", id });
      const chip = ({ id, text }) => button(`${text} ×`, release(id), { className: "chip", "aria-label": `Release ${text}` });
      this.pushes.replaceChildren(...pushes.map(chip));
    }
    this.change(changeable);
    const names = winches.map(({ name }) => name);
    if (String(names) !== String(this.wound?.map(({ name }) => name))) this.winch.replaceChildren(...names.map((name) => option(name, name)));
    Object.assign(this, { wound: winches });
    this.jog.hidden = !winches.length;
    this.sensors.hidden = !sensors.length;
    const known = [...this.sensor.options].map(({ value }) => value);
    if (String(sensors) !== String(known)) this.sensor.replaceChildren(...sensors.map((name) => option(name, name)));
    this.back.disabled = !manual;
    this.measure();
  }

  // Other changeable options, as listed by the server.
  change(list) {
    const shape = JSON.stringify(list.map(({ key, choices, value }) => [key, choices, kindOf(value, choices)]));
    if (shape !== this.shape) {
      this.shape = shape;
      this.widgets = list.map((item) => this.widget(item));
      const lines = list.map((item, i) => make("div", { className: "line" }, span("name", item.label || item.key),
        make("span", { className: "hold" }, this.widgets[i].root)));
      this.changes.replaceChildren(...lines);
      if (!list.length) this.changes.append(make("p", { className: "none", text: "Nothing can be changed while it runs." }));
    }
    this.widgets.forEach((widget, i) => widget.show(list[i]));
  }

  widget(item) {
    const editor = { edit: (_, value) => this.live.send({ do: "set", key: item.key, value }), clear() {} };
    const kind = kindOf(item.value, item.choices);
    return WIDGETS[kind]({ ...item, kind, path: item.key, single: true }, editor, `Change ${item.label || words(item.key)}`);
  }
}

function kindOf(value, choices) {
  if (choices) return "choice";
  return typeof value === "boolean" ? "flag" : Array.isArray(value) ? "vector" : "number";
}
