// New, Open, Save and the YAML texts: dialogs, opened by buttons above the form.

const STAYS = "stays"; // marks a dialog that waits for an answer

class Files {
  constructor(home, dialogs, live) {
    Object.assign(this, { dialogs, live });
    this.opening();
    this.savingAs();
    this.texts = make("div", { className: "texts" });
    this.yaml = this.dialog("YAML", "", null, this.texts);
    const making = this.making();
    const request = () => { this.requested = true; live.send({ do: "yaml" }); };
    home.append(
      button("New…", () => making.showModal()), button("Open…", () => this.open.showModal()),
      button("Save", () => live.form.act("save"), { title: "Ctrl+S: into the files they come from, comments kept" }),
      button("Save as…", () => this.saveAs.showModal()), button("YAML", request, { title: "The files as they would be saved" }),
    );
  }

  // Before another file is shown: save or discard unsaved changes, or cancel.
  leaving(go) {
    this.after = null;
    if (!this.live.form.message?.modified) { go(); return; }
    this.go = go;
    this.leaveDialog ||= this.unsaved();
    this.leaveDialog.showModal();
  }

  unsaved() {
    const what = make("p", { text: "The form has changes that are not saved." });
    const save = () => {
      if (!this.live.form.message.unsaved) this.after = this.go; // after saving, if no file name is required first
      this.save();
    };
    const dialog = this.dialog("Unsaved changes", "Save", save, what);
    const discard = button("Discard", () => { dialog.close(); this.go(); });
    dialog.querySelector("[type=submit]").after(discard);
    return dialog;
  }

  // New form received: continue what waited for saving, unless it failed.
  settled({ modified }) {
    const go = modified ? null : this.after;
    this.after = null;
    go?.();
  }

  dialog(title, act, done, ...parts) {
    const id = fresh("dialog"), submit = act ? make("button", { type: "submit", className: "main", text: act }) : null;
    const form = make("form", { method: "dialog" }, make("h2", { text: title, id }), ...parts,
      bar(submit, button(act ? "Cancel" : "Close", () => dialog.close())));
    form.addEventListener("submit", (event) => { event.preventDefault(); if (done?.() !== STAYS) dialog.close(); });
    const dialog = make("dialog", { "aria-labelledby": id }, form);
    this.dialogs.append(dialog);
    return dialog;
  }

  row(text, input) {
    input.id ||= fresh("given");
    return make("p", { className: "row" }, make("label", { for: input.id, text }), input);
  }

  text(given = {}) { return make("input", { type: "text", autocomplete: "off", ...given }); }

  opening() {
    const name = this.text({ list: "examples", required: true });
    this.examples = make("datalist", { id: "examples" });
    this.listed = make("div", { className: "listed" });
    const open = () => this.leaving(() => this.live.send({ do: "open", name: name.value.trim() }));
    this.open = this.dialog("Open a file or an example", "Open", open, this.row("Name or path", name), this.examples, this.listed);
  }

  savingAs() {
    const target = this.text({ required: true });
    this.why = make("p", { className: "none" });
    const save = () => this.live.send({ do: "save_as", file: target.value.trim() });
    this.saveAs = this.dialog("Save as", "Save", save, this.why, this.row("File or folder", target));
  }

  // Ask for a file name, and send it with the request.
  keep(what, title, name, otherwise = "") {
    const place = this.text({ required: !otherwise, value: name, placeholder: otherwise });
    return this.dialog(title, "Save", () => this.live.send({ do: what, out: place.value.trim() }), this.row("File or folder", place));
  }

  // Arguments as for `cdpr new`: empty fields use its defaults.
  making() {
    const kind = make("select", {}, option("scenario", "scenario"), option("robot", "robot"));
    const file = this.text({ placeholder: "scenario.yaml" });
    const robot = this.text({ list: "examples", placeholder: "a new one" });
    const sizes = (label, usual) => ["width", "depth", "height"].map((size, i) => numberBox(`${label} ${size}, m`,
      { placeholder: `${size} ${usual[i]}` }));
    const frame = sizes("Frame", [4, 3, 2.5]), platform = sizes("Platform", [0.4, 0.3, 0.2]), mass = numberBox(null, { placeholder: "20" });
    const cables = numberBox(null, { placeholder: "8, or 7; suspended 8, 6, of a point 4, 3; planar 4" });
    const crossed = make("select", {}, option("", "crossed"), option("false", "straight"));
    const planar = make("input", { type: "checkbox" });
    const suspended = make("input", { type: "checkbox" });
    const three = (text, inputs) => make("p", { className: "row", role: "group", "aria-label": text }, span("", text),
      make("span", { className: "vector of3" }, ...inputs));
    const all = (inputs) => (inputs.some((input) => input.value.trim()) ? inputs.map((input) => reading(input.value)) : "");
    const act = () => {
      const given = { kind: kind.value, file: file.value.trim(), frame: all(frame), platform: all(platform), mass: reading(mass.value),
        cables: reading(cables.value), crossed: crossed.value && false, planar: planar.checked || "", suspended: suspended.checked || "",
        robot: kind.value === "scenario" ? robot.value.trim() : "" };
      const options = Object.fromEntries(Object.entries(given).filter(([, value]) => value !== ""));
      this.leaving(() => this.live.send({ do: "new", ...options }));
    };
    // Fields that do not apply are disabled: an existing robot has its sizes.
    const fit = () => {
      const made = kind.value === "robot", there = !made && robot.value.trim() !== "";
      file.placeholder = `${kind.value}.yaml`;
      robot.disabled = made;
      for (const input of [...frame, ...platform, mass, cables, crossed, planar, suspended]) input.disabled = there;
    };
    kind.addEventListener("change", fit);
    robot.addEventListener("input", fit);
    fit();
    return this.dialog("New from a template", "Create", act, this.row("Kind", kind), this.row("File", file), three("Frame (m)", frame),
      three("Platform (m)", platform), this.row("Mass (kg)", mass), this.row("Cables", cables),
      this.row("Cables at the platform", crossed), this.row("Suspended (from above)", suspended),
      this.row("Planar (x and z)", planar), this.row("Robot of a scenario", robot));
  }

  // Examples that can be opened.
  list(examples) {
    this.examples.replaceChildren(...examples.map(({ name, shows }) => option(name, shows)));
    const open = ({ label, name, shows }) => button(label, () => {
      this.open.close();
      this.leaving(() => this.live.send({ do: "open", name }));
    }, { title: shows });
    this.listed.replaceChildren(...["scenario", "robot"].flatMap((kind) => [make("h3", { text: `${kind}s that come with cdpr` }),
      ...examples.filter((each) => each.kind === kind).map(open)]));
  }

  // If files cannot be saved in place, ask for another name.
  save() {
    const { unsaved } = this.live.form.message || {};
    if (!unsaved) { this.live.send({ do: "save" }); return; }
    setText(this.why, unsaved);
    this.saveAs.showModal();
  }

  show({ files }) {
    if (!this.requested) return; // requested by another window
    this.requested = false;
    const texts = files.flatMap(({ name, text }) => [make("h3", { text: name }), make("pre", { tabindex: 0, text })]);
    this.texts.replaceChildren(...texts);
    this.yaml.showModal();
  }
}
