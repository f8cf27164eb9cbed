// Form on the left: tabs of fields, their problems, and commands for the whole form.

const ACTS = [["apply", "Apply", "Apply the form to the simulation (Ctrl+Enter)"], ["revert", "Revert", "Discard all changes of the form"],
  ["undo", "Undo", "Ctrl+Z"], ["redo", "Redo", "Ctrl+Y"]];

class Form {
  constructor(root, live) {
    Object.assign(this, { root, live, message: null, lines: new Map() });
    this.tabs = new Tabs(root.querySelector("[role=tablist]"), root.querySelector(".sheets"), "sheet");
    this.top = root.querySelector(".problems");
    this.helped = root.querySelector("#help");
    this.acts = {};
    const foot = root.querySelector(".foot");
    for (const [key, text, title] of ACTS) {
      this.acts[key] = button(text, () => this.act(key), { title, disabled: true });
      foot.append(this.acts[key]);
    }
    document.addEventListener("keydown", (event) => this.key(event));
  }

  // Send pending input first.
  act(key) {
    const active = document.activeElement;
    if (active?.matches("#form input, #form textarea")) active.blur();
    if (key === "save") this.live.files.save(); else this.live.send({ do: key });
  }

  key(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const typing = event.target.matches?.("input[type=text], textarea"), key = event.key.toLowerCase();
    const does = { s: "save", enter: "apply", z: event.shiftKey ? "redo" : "undo", y: "redo" }[key];
    if (!does || (typing && "zy".includes(key)) || event.target.closest?.("dialog")) return; // texts have their own undo
    event.preventDefault();
    this.act(does);
  }

  // Requests of widgets.
  edit(field, value) {
    if (value === "" && field.optional) this.clear(field);
    else this.live.send({ do: "edit", path: field.path, value });
  }

  clear(field) { this.live.send({ do: "remove", path: field.path }); }
  remove(path) { this.live.send({ do: "remove", path }); }
  insert(path, value) { this.live.send({ do: "insert", path, value }); }

  // Default colour of a part.
  usual({ path }) {
    const { data, dark } = this.live;
    return data?.colours[path.includes("platform") ? "body" : "soft"]?.[dark ? 1 : 0];
  }

  // Focus after another file was opened: one step after the form's start.
  arrive() { this.tabs.choose(this.tabs.chosen, true); }

  mark(cable) { this.live.select(cable); }
  faults(path) { return this.wrong?.get(path) || []; }

  explain({ path, label, unit, help, least, most }) {
    this.helped.replaceChildren(make("b", { text: unit && unit !== "1" ? `${label} (${unit})` : label }), ` ${help || ""} `,
      make("span", { className: "bounds", text: this.bounds(least, most) }), make("code", { text: path || "" }));
  }

  bounds(least, most) {
    const has = (x) => x !== null && x !== undefined;
    if (has(least) && has(most)) return `${least} to ${most}. `;
    return has(least) ? `From ${least}. ` : has(most) ? `Up to ${most}. ` : "";
  }

  show(message) {
    this.message = message;
    this.wrong = new Map();
    const paths = new Map(); // by tab, to count problems
    for (const { path, text } of message.problems) this.wrong.set(path, [...(this.wrong.get(path) || []), text]);
    const keys = message.tabs.map(({ key }) => key);
    for (const { key, label, fields } of message.tabs) {
      const panel = this.tabs.panel(key, label || key);
      if (!this.lines.has(key)) {
        this.lines.set(key, new Lineup(this));
        panel.append(this.lines.get(key).root);
      }
      this.lines.get(key).show(fields);
      for (const path of pathsIn(fields)) if (!paths.has(path)) paths.set(path, key);
    }
    this.tabs.keep(keys);
    for (const key of [...this.lines.keys()]) if (!keys.includes(key)) this.lines.delete(key);
    for (const key of keys) this.tabs.count(key, message.problems.filter(({ path }) => paths.get(path) === key).length);
    this.list(message, paths);
    this.head(message);
    this.points(message);
  }

  // All problems and warnings, above the fields; each leads to its field.
  list({ problems, warnings }, paths) {
    const item = (kind) => ({ path, key, place, text }) => {
      const known = paths.has(path), where = known ? words(path) : [key || path, place].filter(Boolean).join(", ");
      const line = where ? `${where}: ${text}` : text;
      const lead = () => this.lead(path, paths.get(path));
      return make("li", { className: kind }, known ? button(line, lead, { className: "lead" }) : line);
    };
    const items = [...problems.map(item("bad")), ...(warnings || []).map(item("warn"))];
    this.top.replaceChildren(...(items.length ? [make("ul", {}, ...items)] : []));
  }

  lead(path, tab) {
    this.live.unfold();
    this.tabs.choose(tab);
    const home = [...this.root.querySelectorAll("[data-path]")].find((node) => node.dataset.path === path);
    for (let node = home; node; node = node.parentElement) {
      if (node.matches(".lines")) node.hidden = false;
      if (node.matches("details")) node.open = true;
    }
    home?.scrollIntoView({ block: "center" });
    home?.querySelector("input, select, textarea")?.focus();
  }

  head(message) {
    const { file, title, modified, applied, undo, redo, problems } = message;
    const name = file ? file.split("/").pop() : title || "new scenario";
    setText(document.getElementById("file"), name);
    document.getElementById("file").title = [file, ...(message.files || [])].join("\n");
    const states = [modified && "modified", message.unsaved && "not saved yet", !applied && "not applied"];
    setText(document.getElementById("state"), states.filter(Boolean).join(", "));
    document.title = `${modified ? "* " : ""}${name} – cdpr gui`;
    this.acts.apply.disabled = applied || problems.length > 0;
    this.acts.apply.classList.toggle("main", !applied && !problems.length);
    this.acts.revert.disabled = !modified;
    this.acts.undo.disabled = !undo;
    this.acts.redo.disabled = !redo;
    this.acts.undo.title = undo ? `Undo: ${undo} (Ctrl+Z)` : "Ctrl+Z";
    this.acts.redo.title = redo ? `Redo: ${redo} (Ctrl+Y)` : "Ctrl+Y";
  }

  // Cable anchors, for the handles in the scene.
  points({ tabs, applied }) {
    const table = tabs.flatMap(({ fields }) => tablesIn(fields)).find(({ path }) => path === "robot.cables");
    if (!table) return;
    const rows = table.rows.map(({ cells }) => ({ frame: cells.frame?.value, platform: cells.platform?.value }));
    this.live.handles?.setCables(rows, applied);
    this.rows = { rows, applied };
  }
}

function tablesIn(fields) {
  return fields.flatMap((field) => [...(field.kind === "table" ? [field] : []), ...tablesIn(field.fields || [])]);
}

// Paths of all fields and cells.
function pathsIn(fields) {
  return fields.flatMap((field) => [field.path, ...pathsIn(field.fields || []), ...(field.rows || []).flatMap((row) => [row.path,
    ...Object.keys(row.cells).map((key) => `${row.path}.${key}`), ...pathsIn(row.fields || [])])]);
}
