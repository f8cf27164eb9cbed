// Input widgets for each kind of field.
//
// A widget is {root, show(field)}. Incoming values do not overwrite pending input.

// Choices as {value, label, help, missing}, also from plain values.
function choicesOf({ choices = [] }) {
  return choices.map((choice) => (typeof choice === "object" ? choice : { value: choice, label: String(choice) }));
}

// Text field, sent on blur or Enter.
function entry(label, commit, given = {}) {
  const input = make("input", { type: "text", autocomplete: "off", spellcheck: "false", "aria-label": label, ...given });
  let typing = false;
  input.addEventListener("input", () => { typing = true; });
  input.addEventListener("change", () => { typing = false; commit(input.value); });
  input.addEventListener("blur", () => { typing = false; });
  return { input, put: (text) => { if (!typing && input.value !== text) input.value = text; } };
}

function textWidget(field, editor, label = words(field.path || field.label)) {
  const { input, put } = entry(label, (text) => editor.edit(field, field.kind === "text" ? text : reading(text)),
    { inputmode: field.kind === "text" ? null : "decimal", className: field.kind === "text" ? "wide" : "number" });
  return { root: input, show: (now) => put(writing(now.value)) };
}

// Selection; unavailable choices show what is missing, but can be selected.
function choiceWidget(field, editor, label = words(field.path || field.label)) {
  const select = make("select", { "aria-label": label, onchange: () => editor.edit(field, offered[select.selectedIndex].value) });
  let offered = [], shape = "";
  return {
    root: select,
    show(now) {
      offered = choicesOf(now);
      let at = offered.findIndex(({ value }) => value === now.value);
      if (at < 0) { // show the file's value even if it is not a choice
        offered = [{ value: now.value ?? null, label: now.value == null ? "–" : writing(now.value) }, ...offered];
        at = 0;
      }
      const wanted = JSON.stringify(offered);
      if (wanted !== shape) {
        select.replaceChildren(...offered.map(({ label: text, help, missing }, i) => option(i, missing ? `${text} (${missing})` : text, help)));
      }
      shape = wanted;
      select.selectedIndex = at;
    },
  };
}

// Multiple selection.
function setWidget(field, editor, label = words(field.path || field.label)) {
  const root = make("span", { className: "set", role: "group", "aria-label": label });
  let boxes = [];
  return {
    root,
    show(now) {
      const choices = choicesOf(now);
      if (boxes.length !== choices.length) {
        const change = () => editor.edit(field, choices.filter((_, i) => boxes[i].checked).map(({ value }) => value));
        const box = (choice) => make("input", { type: "checkbox", "aria-label": `${label}, ${choice.label}`, onchange: change });
        boxes = choices.map(box);
        root.replaceChildren(...choices.map((choice, i) => make("label", {}, boxes[i], choice.label)));
      }
      const value = Array.isArray(now.value) ? now.value : [];
      choices.forEach((choice, i) => { boxes[i].checked = value.includes(choice.value); });
    },
  };
}

function flagWidget(field, editor, label = words(field.path || field.label)) {
  const input = make("input", { type: "checkbox", "aria-label": label, onchange: () => editor.edit(field, input.checked) });
  return { root: input, show: (now) => { input.checked = now.value === true; } };
}

const AXES_OF = { 3: ["x", "y", "z"], 4: ["w", "x", "y", "z"], 6: ["x", "y", "z", "rx", "ry", "rz"] };

// Row of numbers. If a single number is allowed, the others may be empty.
function vectorWidget(field, editor, label = words(field.path || field.label)) {
  if (!field.size && field.single) return textWidget(field, editor, label); // a single number, or a list of any length
  const size = field.size || (Array.isArray(field.value) ? field.value.length : 3);
  const names = field.labels || AXES_OF[size] || Array.from({ length: size }, (_, i) => String(i + 1));
  const part = (name) => entry(`${label}, ${name}`, commit, { inputmode: "decimal", className: "number", title: name });
  const parts = names.slice(0, size).map(part), inputs = parts.map(({ input }) => input);
  const root = make("span", { className: `vector of${size}`, role: "group", "aria-label": label }, ...inputs);
  let waiting = false, known = []; // incomplete vector; values that the server has or will confirm
  function commit() {
    const values = inputs.map((input) => reading(input.value)), empty = values.map((value) => value === "");
    const whole = !empty.includes(true), alone = field.single && empty.indexOf(false) === 0 && !empty.slice(1).includes(false);
    waiting = !whole && !alone && empty.includes(false); // do not send an incomplete vector
    inputs.forEach((input, i) => input.setAttribute("aria-invalid", String(waiting && empty[i])));
    if (whole || alone) {
      known.push(JSON.stringify(whole ? values : values[0]));
      editor.edit(field, whole ? values : values[0]);
    } else if (!waiting && field.optional) editor.clear(field);
  }
  return {
    root,
    show(now) {
      const place = known.lastIndexOf(JSON.stringify(now.value));
      if (place >= 0 && (waiting || place < known.length - 1)) return; // confirms an earlier value
      waiting = false;
      known = [JSON.stringify(now.value)];
      const values = Array.isArray(now.value) ? now.value : [now.value];
      parts.forEach(({ put }, i) => put(writing(values[i])));
    },
  };
}

// Colour name as "#rrggbb", as canvases write it.
function sixDigits(colour) {
  const c = document.createElement("canvas").getContext("2d");
  c.fillStyle = colour;
  return c.fillStyle;
}

function colourWidget(field, editor, label = words(field.path || field.label)) {
  const picker = make("input", { type: "color", "aria-label": `${label}, picked` });
  picker.addEventListener("change", () => editor.edit(field, picker.value));
  const { input, put } = entry(label, (text) => editor.edit(field, text.trim()), { className: "number" });
  return {
    root: make("span", { className: "colour" }, picker, input),
    show(now) {
      const value = typeof now.value === "string" ? now.value : "";
      picker.value = sixDigits(value || editor.usual?.(field) || "#808080"); // not given: show the colour that is drawn
      input.placeholder = value ? "" : "as drawn";
      put(value);
    },
  };
}

// Text field for values without a widget of their own, in YAML.
function yamlWidget(field, editor, label = words(field.path || field.label)) {
  const area = make("textarea", { rows: 3, spellcheck: "false", "aria-label": label });
  let typing = false;
  area.addEventListener("input", () => { typing = true; });
  area.addEventListener("change", () => { typing = false; editor.edit(field, area.value); });
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

const WIDGETS = {
  number: textWidget, integer: textWidget, text: textWidget, choice: choiceWidget, flag: flagWidget, set: setWidget,
  vector: vectorWidget, colour: colourWidget, yaml: yamlWidget,
};
