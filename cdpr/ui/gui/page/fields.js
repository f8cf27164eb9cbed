// Fields of the form: lines, groups and lists of groups; elements persist while values change.

function nameOf({ path, label }) { return words(path || label); }

// Line of the form: label, unit, widget, reset button and problems.
class Line {
  constructor(field, editor) {
    this.kind = field.kind;
    this.editor = editor;
    this.widget = widgetOf(field, editor);
    const wrong = fresh("wrong"), help = fresh("help");
    this.problem = make("p", { className: "problem", id: wrong });
    this.help = make("span", { id: help, hidden: true });
    this.label = make("span", { className: "name", "aria-hidden": "true" });
    this.unit = make("span", { className: "unit" });
    this.clear = button("↺", () => editor.clear(this.field), { className: "clear", title: "Reset to the default" });
    this.clear.setAttribute("aria-label", `Default for ${nameOf(field)}`);
    this.root = make("div", { className: `line has-${field.kind}`, "data-path": field.path }, this.label,
      make("span", { className: "hold" }, this.widget.root, this.unit, this.clear), this.problem, this.help);
    for (const input of this.inputs()) input.setAttribute("aria-describedby", `${help} ${wrong}`);
    for (const kind of ["focusin", "pointerenter"]) this.root.addEventListener(kind, () => editor.explain(this.field));
    this.show(field);
  }

  inputs() { return this.root.querySelectorAll("input, select, textarea"); }

  show(field) {
    this.field = field;
    setText(this.label, field.label);
    const unit = unitShown(field);
    setText(this.unit, unit !== "1" ? unit : "");
    setText(this.help, [unit, field.help].filter(Boolean).join(": "));
    this.root.classList.toggle("default", !field.given);
    this.clear.hidden = !(field.given && (field.optional || field.clearable));
    this.widget.show(field);
    this.fault();
  }

  fault() {
    const texts = this.editor.faults(this.field.path);
    setText(this.problem, texts.join("\n"));
    this.problem.hidden = !texts.length;
    for (const input of this.inputs()) input.setAttribute("aria-invalid", String(texts.length > 0));
  }
}

// Group of fields; may be optional, or have one of several forms.
class Group {
  constructor(field, editor) {
    this.kind = field.kind;
    this.editor = editor;
    this.title = make("span", { className: "title" });
    this.problem = make("p", { className: "problem" });
    this.lines = new Lineup(editor);
    this.chosen = field.choices ? choiceWidget(field, editor, `Form of ${nameOf(field)}`) : null;
    this.fold = button("", () => this.open(this.lines.root.hidden), { className: "fold" });
    this.fold.setAttribute("aria-label", `Fold ${nameOf(field)}`);
    this.fold.append(this.title);
    this.gone = button("×", () => editor.clear(this.field), { className: "clear", title: "Remove the whole section" });
    this.gone.setAttribute("aria-label", `Remove ${nameOf(field)}`);
    this.root = make("fieldset", { className: "group", "data-path": field.path },
      make("legend", {}, this.fold, this.chosen && this.chosen.root, this.gone), this.problem, this.lines.root);
    for (const kind of ["focusin", "pointerenter"]) this.root.firstChild.addEventListener(kind, () => editor.explain(this.field));
    this.show(field);
    this.open(field.given || !field.optional); // fold optional groups that are not in the file
  }

  open(on) {
    this.lines.root.hidden = !on;
    this.fold.setAttribute("aria-expanded", String(on));
  }

  show(field) {
    const chosen = field.given && this.field && !this.field.given;
    this.field = field;
    if (chosen) this.open(true); // show a newly added group
    setText(this.title, field.label);
    this.gone.hidden = !(field.given && field.optional);
    this.root.classList.toggle("default", !field.given);
    if (this.chosen) this.chosen.show(field);
    this.lines.show(field.fields || []);
    this.fold.disabled = !(field.fields || []).length;
    this.fault();
  }

  fault() {
    const texts = this.editor.faults(this.field.path);
    setText(this.problem, texts.join("\n"));
    this.problem.hidden = !texts.length;
    this.lines.fault();
    if (this.root.querySelector(".problem:not([hidden])")) this.open(true);
  }
}

// List of sections with remove buttons; new ones get a selected type.
class List {
  constructor(field, editor) {
    this.kind = field.kind;
    this.lines = new Lineup(editor);
    this.title = make("span", { className: "title" });
    const types = choicesOf(field), options = types.map(({ value, label, help }) => option(value, label, help));
    const type = types.length ? make("select", { "aria-label": `Type to add to ${nameOf(field)}` }, ...options) : null;
    const add = button("Add", () => editor.insert(field.path, type?.value), { "aria-label": `Add to ${nameOf(field)}` });
    this.root = make("div", { className: "list", "data-path": field.path }, bar(this.title, grow(), type, add), this.lines.root);
    this.show(field);
  }

  show(field) {
    setText(this.title, `${field.label} (${(field.fields || []).length})`);
    this.lines.show((field.fields || []).map((item) => ({ ...item, given: true, optional: true })));
  }

  fault() { this.lines.fault(); }
}

// Column of fields: persistent ones keep their elements with focus and selection.
class Lineup {
  constructor(editor) {
    this.editor = editor;
    this.root = make("div", { className: "lines" });
    this.all = new Map();
  }

  show(fields) {
    const kept = new Map();
    for (const field of fields) {
      const key = [field.kind, field.path, field.label, field.size, Boolean(field.choices)].join(), old = this.all.get(key);
      const Kind = { section: Group, table: Table, list: List }[field.kind] || Line;
      if (old) old.show(field);
      kept.set(key, old || new Kind(field, this.editor));
    }
    for (const [key, old] of this.all) if (!kept.has(key)) old.root.remove();
    [...kept.values()].forEach((line, i) => {
      if (this.root.children[i] !== line.root) this.root.insertBefore(line.root, this.root.children[i] || null);
    });
    this.all = kept;
  }

  fault() { for (const line of this.all.values()) line.fault(); }
}
