// What is done to a robot that runs: pushes, cut and jammed cables, limits, another target; and saving what was done.

class Disturb {
  constructor(home, live) {
    this.live = live;
    this.pushes = make("span", { className: "pushes" });
    this.cable = make("select", { id: "cable", "aria-label": "Cable to cut or jam" });
    this.changes = live.told.tabs.panel("change", "Change");
    this.changes.classList.add("changes");
    home.append(this.push(), this.cables(), this.limits(), this.target(), this.saving());
  }

  part(title, ...inputs) { return make("fieldset", {}, make("legend", { text: title }), ...inputs); }

  numbers(label, names, unit, values = names.map(() => "0")) {
    const inputs = names.map((name, i) => make("input", { type: "text", inputmode: "decimal", className: "number", value: values[i], "aria-label": `${label}, ${name}`.replace(/, $/, ""), title: name || label }));
    return { inputs, root: make("span", { className: "vector" }, make("span", { className: "what", text: label.replace(/^\w+ /, "") }), ...inputs, make("span", { className: "unit", text: unit })) };
  }

  // Numbers of fields, or null with the field marked where one holds none.
  read({ inputs }, empty = null) {
    const values = inputs.map((input) => (input.value.trim() === "" ? empty : reading(input.value)));
    values.forEach((value, i) => inputs[i].setAttribute("aria-invalid", String(typeof value !== "number" && value !== empty)));
    if (values.every((value) => typeof value === "number" || value === empty)) return values;
    this.live.note("error", "A number is expected in the field that is marked: nothing was sent.");
    return undefined;
  }

  push() {
    const force = this.numbers("Push force", ["x", "y", "z"], "N"), moment = this.numbers("Push moment", ["x", "y", "z"], "N m");
    const last = this.numbers("Push duration", [""], "s", ["0.5"]);
    last.inputs[0].title = "Empty: until it is released";
    const act = () => {
      const [f, m, d] = [this.read(force, 0), this.read(moment, 0), this.read(last)];
      if (f && m && d) this.live.send({ do: "push", force: f, moment: m, duration: d[0] });
    };
    return this.part("Push", force.root, moment.root, last.root, button("Push", act), this.pushes);
  }

  cables() {
    const act = (what) => () => { if (this.cable.value) this.live.send({ do: what, cable: this.cable.value }); };
    this.cable.addEventListener("change", () => this.live.select(this.cable.selectedIndex));
    this.cable.addEventListener("blur", () => this.live.select(null));
    return this.part("Cable", this.cable, button("Cut", act("cut"), { title: "It breaks" }), button("Jam", act("jam"), { title: "Its winch stands still" }));
  }

  limits() {
    this.least = this.numbers("Limits least", [""], "", [""]);
    this.most = this.numbers("Limits most", [""], "N", [""]);
    const act = () => {
      const [low, high] = [this.read(this.least), this.read(this.most)];
      if (!low || !high) return;
      const given = { do: "limits" };
      if (low[0] !== null) given.tension_min = low[0];
      if (high[0] !== null) given.tension_max = high[0];
      this.live.send(given);
    };
    return this.part("Limits", this.least.root, this.most.root, button("Set", act, { "aria-label": "Set limits", title: "Tension limits of all cables from now on; empty: as they are" }));
  }

  target() {
    this.position = this.numbers("Target position", ["x", "y", "z"], "m", ["", "", ""]);
    this.attitude = this.numbers("Target rpy", ["roll", "pitch", "yaw"], "rad", ["0", "0", "0"]);
    this.within = this.numbers("Target in", [""], "s", [""]);
    this.within.inputs[0].title = "Empty: as the program finds fit";
    const act = () => {
      const [position, rpy, within] = [this.read(this.position), this.read(this.attitude, 0), this.read(this.within)];
      if (!position || !rpy || !within) return;
      const here = this.live.frame?.dp || this.live.frame?.p || [0, 0, 0];
      const given = { do: "target", position: position.map((x, i) => x ?? here[i]), rpy };
      if (within[0] !== null) given.duration = within[0];
      this.live.send(given);
    };
    const here = () => {
      const { frame } = this.live;
      if (!frame) return;
      rounded(frame.p).forEach((x, i) => { this.position.inputs[i].value = x; });
      rounded(anglesOf(frame.q), 1e-4).forEach((x, i) => { this.attitude.inputs[i].value = x; });
    };
    return this.part("Target", this.position.root, this.attitude.root, this.within.root, button("Go", act, { "aria-label": "Go to the target" }),
      button("Here", here, { title: "Fills in the pose of now" }));
  }

  saving() {
    const ask = (what, title, name) => {
      const input = make("input", { type: "text", required: true, value: name, autocomplete: "off" });
      const dialog = this.live.files.dialog(title, "Save", () => this.live.send({ do: what, out: input.value.trim() }), this.live.files.row("Where", input));
      return () => dialog.showModal();
    };
    return this.part("Keep", button("Save run…", () => (this.askRun ??= ask("save_run", "Save the run as a folder", "runs/gui"))(), { title: "As a run folder, as cdpr run writes it" }),
      button("Save session…", () => (this.askSession ??= ask("save_session", "Save the session as a scenario", "session.yaml"))(), { title: "As a scenario: what was done are its events" }));
  }

  load({ limits }) {
    if (!limits) return;
    const one = (values) => { const all = [...new Set([values].flat())]; return all.length === 1 ? String(all[0]) : ""; };
    this.least.inputs[0].value = one(limits.tension_min);
    this.most.inputs[0].value = one(limits.tension_max);
  }

  show(status) {
    const cables = status.cables || [], told = JSON.stringify(cables);
    if (told !== this.known) {
      const before = this.cable.value;
      this.cable.replaceChildren(...cables.map(({ name, broken, jammed }, i) => make("option", { value: name, text: `${i + 1} ${name}${broken ? " (broken)" : jammed ? " (jammed)" : ""}` })));
      if (cables.some(({ name }) => name === before)) this.cable.value = before;
      this.known = told;
    }
    const pushes = JSON.stringify(status.pushes || []);
    if (pushes !== this.pushed) {
      this.pushes.replaceChildren(...(status.pushes || []).map(({ id, text }) => button(`${text} ×`, () => this.live.send({ do: "release", id }), { className: "chip", "aria-label": `Release ${text}` })));
      this.pushed = pushes;
    }
    this.change(status.changeable || []);
  }

  // What else may be changed while it runs, as the program lists it.
  change(list) {
    const shape = JSON.stringify(list.map(({ key, choices }) => [key, choices]));
    if (shape !== this.shape) {
      this.shape = shape;
      this.lines = list.map((item) => {
        const desk = { edit: (_, value) => this.live.send({ do: "set", key: item.key, value }), clear() {} };
        const kind = item.choices ? "choice" : typeof item.value === "boolean" ? "flag" : Array.isArray(item.value) ? "vector" : "number";
        const widget = WIDGETS[kind]({ ...item, kind, path: item.key, single: true }, desk, `Change ${item.label || words(item.key)}`);
        return { widget, root: make("div", { className: "line" }, make("span", { className: "name", text: item.label || item.key }), make("span", { className: "hold" }, widget.root)) };
      });
      this.changes.replaceChildren(...this.lines.map(({ root }) => root));
      if (!list.length) this.changes.append(make("p", { className: "none", text: "Nothing can be changed while it runs." }));
    }
    this.lines?.forEach(({ widget }, i) => widget.show(list[i]));
  }
}
