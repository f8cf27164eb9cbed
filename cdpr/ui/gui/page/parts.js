// Page elements and tabs. Foreign texts are inserted as text only: HTML is not supported.

const SVG_SIGNS = { run: "M4 2l10 6-10 6z", pause: "M4 2h3v12H4zM9 2h3v12H9z", step: "M3 2l7 6-7 6zM11 2h2v12h-2z",
  reset: "M13 2L6 8l7 6zM3 2h2v12H3z" };
const PROPERTIES = ["value", "checked", "disabled", "hidden", "type", "title", "className"];
let counted = 0;

// Unique id.
function fresh(word) { counted += 1; return `${word}-${counted}`; }

// Create an element with attributes, properties and listeners.
function make(tag, given = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(given)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key === "text") node.textContent = value;
    else if (PROPERTIES.includes(key)) node[key] = value;
    else node.setAttribute(key, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

function button(text, onclick, given = {}) { return make("button", { type: "button", text, onclick, ...given }); }

function span(className, text) { return make("span", { className, text }); }
function option(value, text, title) { return make("option", { value, text, title }); }
function grow() { return make("span", { className: "grow" }); }

// Row of buttons.
function bar(...children) { return make("div", { className: "bar" }, ...children); }

// Small input field for a number.
function numberBox(label, given = {}) {
  return make("input", { type: "text", inputmode: "decimal", autocomplete: "off", className: "number", "aria-label": label, ...given });
}

// Icon of a button.
function sign(name) {
  const space = "http://www.w3.org/2000/svg", svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", SVG_SIGNS[name]);
  svg.append(path);
  return svg;
}

// Set a text only if it changes, to preserve selections and not disturb screen readers.
function setText(node, text) { if (node.textContent !== text) node.textContent = text; }

// Tabs with one visible panel; arrow keys switch. Labels may change, keys stay.
class Tabs {
  constructor(list, home, name) {
    Object.assign(this, { list, home, name, all: new Map(), chosen: null });
    list.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key], keys = [...this.all.keys()];
      if (!by) return;
      event.preventDefault();
      this.choose(keys[(keys.indexOf(this.chosen) + by + keys.length) % keys.length], true);
    });
  }

  // Panel of this key, created on first use.
  panel(key, label) {
    if (!this.all.has(key)) {
      const id = fresh(this.name);
      const tab = button("", () => this.choose(key), { role: "tab", id: `${id}-tab`, "aria-controls": id });
      const panel = make("div", { role: "tabpanel", id, "aria-labelledby": `${id}-tab`, className: "panel" });
      tab.append(make("span", { text: label }), make("span", { className: "count" }));
      this.list.append(tab);
      this.home.append(panel);
      this.all.set(key, { tab, panel });
      this.choose(this.chosen ?? key);
    }
    return this.all.get(key).panel;
  }

  choose(key, focus = false) {
    if (!this.all.has(key)) return;
    this.chosen = key;
    for (const [other, { tab, panel }] of this.all) {
      tab.setAttribute("aria-selected", String(other === key));
      tab.tabIndex = other === key ? 0 : -1;
      panel.hidden = other !== key;
    }
    if (focus) this.all.get(key).tab.focus();
  }

  // Count shown on a tab, "" for none.
  count(key, number) { setText(this.all.get(key).tab.querySelector(".count"), number ? String(number) : ""); }

  keep(keys) {
    for (const [key, { tab, panel }] of this.all) {
      if (keys.includes(key)) continue;
      tab.remove();
      panel.remove();
      this.all.delete(key);
    }
    if (!this.all.has(this.chosen)) this.choose([...this.all.keys()][0]);
  }
}
