// The fields of the form: for each kind what a hand edits, and how it shows what the program says.
//
// A widget is {root, show(field)}. What one is typing is not overwritten by what arrives meanwhile.

// A text that is sent when it is left or Enter is pressed.
function entry(label, commit, given = {}) {
  const input = make("input", { type: "text", autocomplete: "off", spellcheck: "false", "aria-label": label, ...given });
  let typing = false;
  input.addEventListener("input", () => { typing = true; });
  input.addEventListener("change", () => { typing = false; commit(input.value); });
  input.addEventListener("blur", () => { typing = false; });
  return { input, put: (text) => { if (!typing && input.value !== text) input.value = text; } };
}

function textWidget(field, desk, label = words(field.path || field.label)) {
  const { input, put } = entry(label, (text) => desk.edit(field, field.kind === "text" ? text : reading(text)),
    { inputmode: field.kind === "text" ? null : "decimal", className: field.kind === "text" ? "wide" : "number" });
  return { root: input, show: (now) => put(writing(now.value)) };
}

// One of several; what cannot be used yet says what is missing, and can be chosen all the same.
function choiceWidget(field, desk, label = words(field.path || field.label)) {
  const select = make("select", { "aria-label": label, onchange: () => desk.edit(field, offered[select.selectedIndex].value) });
  let offered = [], shape = "";
  return {
    root: select,
    show(now) {
      offered = (now.choices || []).map((choice) => (typeof choice === "object" ? choice : { value: choice, label: String(choice) }));
      let at = offered.findIndex(({ value }) => value === now.value);
      if (at < 0) { // what the file says is seen, even where it is none of them
        offered = [{ value: now.value ?? null, label: now.value == null ? "–" : writing(now.value) }, ...offered];
        at = 0;
      }
      const wanted = JSON.stringify(offered);
      if (wanted !== shape) {
        select.replaceChildren(...offered.map(({ label: text, help, missing }) => make("option", {
          text: missing ? `${text} (${missing})` : text, title: help,
        })));
      }
      shape = wanted;
      select.selectedIndex = at;
    },
  };
}

// Several of a few.
function setWidget(field, desk, label = words(field.path || field.label)) {
  const root = make("span", { className: "set", role: "group", "aria-label": label });
  let boxes = [];
  return {
    root,
    show(now) {
      const choices = (now.choices || []).map((choice) => (typeof choice === "object" ? choice : { value: choice, label: String(choice) }));
      if (boxes.length !== choices.length) {
        const change = () => desk.edit(field, choices.filter((_, i) => boxes[i].checked).map(({ value }) => value));
        boxes = choices.map((choice) => make("input", { type: "checkbox", "aria-label": `${label}, ${choice.label}`, onchange: change }));
        root.replaceChildren(...choices.map((choice, i) => make("label", {}, boxes[i], choice.label)));
      }
      const value = Array.isArray(now.value) ? now.value : [];
      choices.forEach((choice, i) => { boxes[i].checked = value.includes(choice.value); });
    },
  };
}

function flagWidget(field, desk, label = words(field.path || field.label)) {
  const input = make("input", { type: "checkbox", "aria-label": label, onchange: () => desk.edit(field, input.checked) });
  return { root: input, show: (now) => { input.checked = now.value === true; } };
}

const AXES_OF = { 3: ["x", "y", "z"], 4: ["w", "x", "y", "z"], 6: ["x", "y", "z", "rx", "ry", "rz"] };

// A few numbers side by side. Where one may stand for all, the others may be left empty.
function vectorWidget(field, desk, label = words(field.path || field.label)) {
  if (!field.size && field.single) return textWidget(field, desk, label); // one for all, or a list of as many as there are
  const size = field.size || (Array.isArray(field.value) ? field.value.length : 3);
  const names = field.labels || AXES_OF[size] || Array.from({ length: size }, (_, i) => String(i + 1));
  const parts = names.slice(0, size).map((name) => entry(`${label}, ${name}`, commit, { inputmode: "decimal", className: "number", title: name }));
  const root = make("span", { className: `vector of${size}`, role: "group", "aria-label": label }, ...parts.map(({ input }) => input));
  let waiting = false, known = []; // for the rest of a vector; values that the program has or will answer
  function commit() {
    const values = parts.map(({ input }) => reading(input.value)), empty = values.map((value) => value === "");
    const whole = !empty.includes(true), alone = field.single && empty.indexOf(false) === 0 && !empty.slice(1).includes(false);
    // Half a vector says nothing: it waits for the rest.
    parts.forEach(({ input }, i) => input.setAttribute("aria-invalid", String(!whole && !alone && empty[i] && empty.includes(false))));
    waiting = !whole && !alone && empty.includes(false);
    if (whole || alone) {
      known.push(JSON.stringify(whole ? values : values[0]));
      desk.edit(field, whole ? values : values[0]);
    } else if (!waiting && field.optional) desk.clear(field);
  }
  return {
    root,
    show(now) {
      if (waiting && known.includes(JSON.stringify(now.value))) return; // it answers what went before
      waiting = false;
      known = [JSON.stringify(now.value)];
      const values = Array.isArray(now.value) ? now.value : [now.value];
      parts.forEach(({ put }, i) => put(writing(values[i])));
    },
  };
}

// A colour's name as "#rrggbb", as canvases write it.
function sixDigits(colour) {
  const c = document.createElement("canvas").getContext("2d");
  c.fillStyle = colour;
  return c.fillStyle;
}

function colourWidget(field, desk, label = words(field.path || field.label)) {
  const picker = make("input", { type: "color", "aria-label": `${label}, picked`, onchange: () => desk.edit(field, picker.value) });
  const { input, put } = entry(label, (text) => desk.edit(field, text.trim()), { className: "number" });
  return {
    root: make("span", { className: "colour" }, picker, input),
    show(now) {
      const value = typeof now.value === "string" ? now.value : "";
      if (value) picker.value = sixDigits(value);
      put(value);
    },
  };
}

// What has no field of its own is edited as it is written.
function yamlWidget(field, desk, label = words(field.path || field.label)) {
  const area = make("textarea", { rows: 3, spellcheck: "false", "aria-label": label });
  let typing = false;
  area.addEventListener("input", () => { typing = true; });
  area.addEventListener("change", () => { typing = false; desk.edit(field, area.value); });
  area.addEventListener("blur", () => { typing = false; });
  return {
    root: area,
    show(now) {
      const text = typeof now.value === "string" ? now.value : writing(now.value);
      area.rows = clamp(text.split("\n").length, 2, 12);
      if (!typing && area.value !== text) area.value = text;
    },
  };
}

const WIDGETS = { number: textWidget, integer: textWidget, text: textWidget, choice: choiceWidget, flag: flagWidget, set: setWidget,
  vector: vectorWidget, colour: colourWidget, yaml: yamlWidget };

// One line of the form: label, unit, what is edited, a way back to the default, and what is wrong.
class Line {
  constructor(field, desk) {
    this.kind = field.kind;
    this.desk = desk;
    this.widget = (WIDGETS[field.kind] || yamlWidget)(field, desk);
    const wrong = fresh("wrong"), help = fresh("help");
    this.problem = make("p", { className: "problem", id: wrong });
    this.help = make("span", { id: help, hidden: true });
    this.label = make("span", { className: "name", "aria-hidden": "true" });
    this.unit = make("span", { className: "unit" });
    this.clear = button("↺", () => desk.clear(this.field), { className: "clear", "aria-label": `Default for ${words(field.path || field.label)}`, title: "Back to the default" });
    this.root = make("div", { className: `line has-${field.kind}`, "data-path": field.path }, this.label,
      make("span", { className: "hold" }, this.widget.root, this.unit, this.clear), this.problem, this.help);
    for (const input of this.inputs()) input.setAttribute("aria-describedby", `${help} ${wrong}`);
    for (const kind of ["focusin", "pointerenter"]) this.root.addEventListener(kind, () => desk.explain(this.field));
    this.show(field);
  }

  inputs() { return this.root.querySelectorAll("input, select, textarea"); }

  show(field) {
    this.field = field;
    say(this.label, field.label);
    say(this.unit, field.unit && field.unit !== "1" ? field.unit : "");
    say(this.help, [field.unit, field.help].filter(Boolean).join(": "));
    this.root.classList.toggle("default", !field.given);
    this.clear.hidden = !(field.given && (field.optional || field.clearable));
    this.widget.show(field);
    this.fault();
  }

  fault() {
    const texts = this.desk.faults(this.field.path);
    say(this.problem, texts.join("\n"));
    this.problem.hidden = !texts.length;
    for (const input of this.inputs()) input.setAttribute("aria-invalid", String(texts.length > 0));
  }
}

// Fields that belong together; may be left out as a whole, or be of one of several forms.
class Group {
  constructor(field, desk) {
    this.kind = field.kind;
    this.desk = desk;
    this.title = make("span", { className: "title" });
    this.problem = make("p", { className: "problem" });
    this.lines = new Lineup(desk);
    this.chosen = field.choices ? choiceWidget(field, desk, `Form of ${words(field.path || field.label)}`) : null;
    this.fold = button("", () => this.open(this.lines.root.hidden), { className: "fold", "aria-label": `Fold ${words(field.path || field.label)}` });
    this.fold.append(this.title);
    this.gone = button("×", () => desk.clear(this.field), { className: "clear", "aria-label": `Leave out ${words(field.path || field.label)}`, title: "Leaves all of it out" });
    this.root = make("fieldset", { className: "group", "data-path": field.path },
      make("legend", {}, this.fold, this.chosen && this.chosen.root, this.gone), this.problem, this.lines.root);
    for (const kind of ["focusin", "pointerenter"]) this.root.querySelector("legend").addEventListener(kind, () => desk.explain(this.field));
    this.show(field);
    this.open(field.given || !field.optional); // what the file does not say is folded away
  }

  open(on) {
    this.lines.root.hidden = !on;
    this.fold.setAttribute("aria-expanded", String(on));
  }

  show(field) {
    this.field = field;
    say(this.title, field.label);
    this.gone.hidden = !(field.given && field.optional);
    this.root.classList.toggle("default", !field.given);
    if (this.chosen) this.chosen.show(field);
    this.lines.show(field.fields || []);
    this.fold.disabled = !(field.fields || []).length;
    this.fault();
  }

  fault() {
    const texts = this.desk.faults(this.field.path);
    say(this.problem, texts.join("\n"));
    this.problem.hidden = !texts.length;
    this.lines.fault();
    if (this.root.querySelector(".problem:not([hidden])")) this.open(true);
  }
}

// Sections of which there may be any number, each with a way out; new ones are of a type that one chooses.
class List {
  constructor(field, desk) {
    this.kind = field.kind;
    this.lines = new Lineup(desk);
    this.title = make("span", { className: "title" });
    const types = (field.choices || []).map((choice) => (typeof choice === "object" ? choice : { value: choice, label: choice }));
    const type = make("select", { "aria-label": `Type to add to ${words(field.path || field.label)}` }, ...types.map(({ value, label, help }) => make("option", { value, text: label, title: help })));
    const add = button("Add", () => desk.insert(field.path, types.length ? type.value : undefined), { "aria-label": `Add to ${words(field.path || field.label)}` });
    this.root = make("div", { className: "list", "data-path": field.path },
      make("div", { className: "bar" }, this.title, make("span", { className: "grow" }), types.length ? type : null, add), this.lines.root);
    this.show(field);
  }

  show(field) {
    say(this.title, `${field.label} (${(field.fields || []).length})`);
    this.lines.show((field.fields || []).map((item) => ({ ...item, given: true, optional: true })));
  }

  fault() { this.lines.fault(); }
}

// Fields one under the other: those that stay keep their elements, and with them focus and selection.
class Lineup {
  constructor(desk) {
    this.desk = desk;
    this.root = make("div", { className: "lines" });
    this.all = new Map();
  }

  show(fields) {
    const kept = new Map();
    for (const field of fields) {
      const key = [field.kind, field.path, field.label, field.size, Boolean(field.choices)].join(), old = this.all.get(key);
      const Kind = { section: Group, table: Table, list: List }[field.kind] || Line;
      if (old) old.show(field);
      kept.set(key, old || new Kind(field, this.desk));
    }
    for (const [key, old] of this.all) if (!kept.has(key)) old.root.remove();
    [...kept.values()].forEach((line, i) => {
      if (this.root.children[i] !== line.root) this.root.insertBefore(line.root, this.root.children[i] || null);
    });
    this.all = kept;
  }

  fault() { for (const line of this.all.values()) line.fault(); }
}
