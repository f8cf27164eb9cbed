// New, Open, Save and the texts of the files: dialogs, opened by the buttons above the form.

class Files {
  constructor(bar, home, live) {
    Object.assign(this, { home, live });
    bar.append(
      button("New…", () => this.fresh.showModal()), button("Open…", () => this.open.showModal()),
      button("Save", () => live.form.act("save"), { title: "Ctrl+S: into the files they come from, comments kept" }),
      button("Save as…", () => this.saveAs.showModal()),
      button("YAML", () => { live.send({ do: "yaml" }); this.asked = true; }, { title: "The files as they would be saved" }),
    );
    this.name = make("input", { type: "text", id: "open-name", list: "examples", required: true, autocomplete: "off" });
    this.examples = make("datalist", { id: "examples" });
    this.listed = make("div", { className: "listed" });
    this.open = this.dialog("Open a file or an example", "Open", () => live.send({ do: "open", name: this.name.value.trim() }),
      this.row("Name or path", this.name), this.examples, this.listed);
    this.target = make("input", { type: "text", id: "save-name", required: true, autocomplete: "off" });
    this.why = make("p", { className: "none" });
    this.saveAs = this.dialog("Save as", "Save", () => live.send({ do: "save_as", file: this.target.value.trim() }), this.why, this.row("File or folder", this.target));
    this.texts = make("div", { className: "texts" });
    this.yaml = this.dialog("YAML", "", null, this.texts);
    this.fresh = this.newDialog();
  }

  dialog(title, act, done, ...parts) {
    const id = fresh("dialog");
    const close = button(act ? "Cancel" : "Close", () => dialog.close());
    const form = make("form", { method: "dialog", onsubmit: (event) => { event.preventDefault(); done?.(); dialog.close(); } },
      make("h2", { text: title, id }), ...parts, make("div", { className: "bar" }, act ? make("button", { type: "submit", className: "main", text: act }) : null, close));
    const dialog = make("dialog", { "aria-labelledby": id }, form);
    this.home.append(dialog);
    return dialog;
  }

  row(text, input) {
    input.id ||= fresh("given");
    return make("p", { className: "row" }, make("label", { for: input.id, text }), input);
  }

  // As `cdpr new` takes them: what is left empty is as it would be there.
  newDialog() {
    const kind = make("select", {}, make("option", { value: "scenario", text: "scenario" }), make("option", { value: "robot", text: "robot" }));
    const three = (label) => ["width", "depth", "height"].map((name) => make("input", { type: "text", inputmode: "decimal", className: "number", "aria-label": `${label} ${name}, m`, placeholder: name }));
    const frame = three("Frame"), platform = three("Platform");
    const mass = make("input", { type: "text", inputmode: "decimal", className: "number" });
    const cables = make("input", { type: "text", inputmode: "numeric", className: "number" });
    const crossed = make("select", {}, make("option", { value: "", text: "as usual" }), make("option", { value: "true", text: "crossed" }), make("option", { value: "false", text: "straight" }));
    const planar = make("input", { type: "checkbox" });
    const file = make("input", { type: "text", autocomplete: "off", placeholder: "robot.yaml or scenario.yaml" });
    const robot = make("input", { type: "text", list: "examples", autocomplete: "off", placeholder: "a new one" });
    const group = (text, inputs) => make("p", { className: "row", role: "group", "aria-label": text }, make("span", { text }), make("span", { className: "vector of3" }, ...inputs));
    const make_ = () => {
      const given = { do: "new", kind: kind.value };
      const put = (key, value) => { if (value !== "" && value !== null) given[key] = value; };
      for (const [key, inputs] of [["frame", frame], ["platform", platform]]) {
        const values = inputs.map((input) => reading(input.value));
        if (values.some((value) => value !== "")) given[key] = values;
      }
      put("file", file.value.trim());
      put("mass", reading(mass.value));
      put("cables", reading(cables.value));
      put("crossed", crossed.value && crossed.value === "true");
      if (planar.checked) given.planar = true;
      if (kind.value === "scenario") put("robot", robot.value.trim());
      this.live.send(given);
    };
    return this.dialog("New from a template", "Make", make_, this.row("Kind", kind), this.row("File", file), group("Frame (m)", frame), group("Platform (m)", platform),
      this.row("Mass (kg)", mass), this.row("Cables", cables), this.row("Cables at the platform", crossed), this.row("Planar (x and z)", planar),
      this.row("Robot of a scenario", robot));
  }

  // What comes with the program and can be opened.
  list(examples) {
    this.examples.replaceChildren(...examples.map(({ name, shows }) => make("option", { value: name, text: shows })));
    const open = ({ label, name, shows }) => button(label, () => { this.live.send({ do: "open", name }); this.open.close(); }, { title: shows });
    this.listed.replaceChildren(...["scenario", "robot"].flatMap((kind) => [make("h3", { text: `${kind}s that come with cdpr` }),
      ...examples.filter((each) => each.kind === kind).map(open)]));
  }

  // Where the files cannot be written to where they come from, another place is asked for.
  save() {
    const { unsaved } = this.live.form.message || {};
    if (!unsaved) { this.live.send({ do: "save" }); return; }
    say(this.why, unsaved);
    this.saveAs.showModal();
  }

  show({ files }) {
    if (!this.asked) return; // another window has asked
    this.asked = false;
    this.texts.replaceChildren(...files.flatMap(({ name, text }) => [make("h3", { text: name }), make("pre", { tabindex: 0, text })]));
    this.yaml.showModal();
  }
}
