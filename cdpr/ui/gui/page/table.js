// Table of cables, one per row: anchors, limits and own values. The focused row is marked in the scene.

class Table {
  constructor(field, editor) {
    this.kind = field.kind;
    this.editor = editor;
    this.rows = [];
    this.shape = "";
    this.table = make("table", { "aria-label": words(field.path) });
    this.problem = make("p", { className: "problem" });
    const add = button("Add", () => editor.insert(field.path), { "aria-label": `Add to ${words(field.path)}`, title: "Add a cable" });
    const wide = button("Wide", () => {
      const on = document.body.classList.toggle("wideform");
      wide.setAttribute("aria-pressed", String(on));
    }, { "aria-pressed": "false", "aria-label": `Wide ${words(field.path)}`, title: "Widen the form" });
    const all = button("All columns", () => {
      this.all = !this.all;
      all.setAttribute("aria-pressed", String(this.all));
      this.show(this.field);
    }, { "aria-pressed": "false", "aria-label": `All columns of ${words(field.path)}`, title: "Include columns without values" });
    this.all = false;
    this.title = make("span", { className: "title" });
    this.root = make("div", { className: "group", "data-path": field.path },
      bar(this.title, grow(), all, wide, add),
      this.problem, make("div", { className: "scroll sideways" }, this.table));
    this.show(field);
  }

  show(field) {
    this.field = field;
    setText(this.title, `${field.label} (${field.rows.length})`);
    this.columns = field.columns.filter((column) => column.shown !== false || this.all);
    const rows = field.rows.map((row) => [row.path, Object.keys(row.cells), (row.fields || []).length > 0]);
    const shape = JSON.stringify([this.columns, rows]);
    if (shape !== this.shape) this.build(field);
    this.shape = shape;
    this.rows.forEach(({ cells, more, root }, i) => {
      const row = field.rows[i];
      for (const [key, widget] of Object.entries(cells)) {
        widget.show({ ...this.columns.find((column) => column.key === key), ...row.cells[key] });
        widget.cell.classList.toggle("default", row.cells[key].given === false);
      }
      if (more) more.show(row.fields);
      root.dataset.cable = String(i);
    });
    this.fault();
  }

  build(field) {
    const heads = this.columns.map((column) => make("th", { scope: "col", title: column.help || "" },
      make("span", { text: column.label }), make("span", { className: "unit", text: unitShown(column) })));
    const body = make("tbody");
    this.rows = field.rows.map((row, i) => this.row(field, row, i, body));
    this.table.replaceChildren(make("thead", {}, make("tr", {}, make("th", { scope: "col", text: "#" }), ...heads, make("td"))), body);
  }

  row(field, row, i, body) {
    const cells = {}, nodes = this.columns.map((column) => {
      const cell = make("td"), given = row.cells[column.key];
      if (!given) return cell;
      const one = { ...column, ...given, path: `${row.path}.${column.key}` };
      const widget = widgetOf(one, this.editor, `${words(row.path)}, ${column.label}`);
      cell.dataset.path = one.path;
      cell.append(widget.root);
      cell.addEventListener("focusin", () => this.editor.explain(one));
      cells[column.key] = Object.assign(widget, { cell });
      return cell;
    });
    const gone = button("×", () => this.editor.remove(row.path), { className: "clear", title: "Remove this cable" });
    gone.setAttribute("aria-label", `Remove ${words(row.path)}`);
    const root = make("tr", {}, make("th", { scope: "row", text: i + 1 }), ...nodes, make("td", {}, gone));
    root.addEventListener("focusin", () => this.editor.mark(i));
    root.addEventListener("focusout", () => this.editor.mark(null));
    body.append(root);
    let more = null;
    if (row.fields?.length) {
      more = new Lineup(this.editor);
      const fold = make("details", {}, make("summary", { text: `More of ${words(row.path)}` }), more.root);
      body.append(make("tr", { className: "more" }, make("td"), make("td", { colspan: this.columns.length + 1 }, fold)));
    }
    return { root, cells, more };
  }

  fault() {
    const own = [...this.editor.faults(this.field.path)];
    this.rows.forEach(({ cells, more }, i) => {
      own.push(...this.editor.faults(this.field.rows[i].path).map((text) => `cable ${i + 1}: ${text}`));
      for (const { cell } of Object.values(cells)) {
        const texts = this.editor.faults(cell.dataset.path);
        own.push(...texts.map((text) => `cable ${i + 1}: ${text}`));
        cell.querySelectorAll("input, select, textarea").forEach((input) => input.setAttribute("aria-invalid", String(texts.length > 0)));
        cell.title = texts.join("\n");
      }
      if (more) more.fault();
    });
    setText(this.problem, own.join("\n"));
    this.problem.hidden = !own.length;
  }
}
