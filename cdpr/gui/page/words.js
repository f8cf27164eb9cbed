// Elements, numbers and attitudes, as the rest of the window needs them.

const SVG_SIGNS = { run: "M4 2l10 6-10 6z", pause: "M4 2h3v12H4zM9 2h3v12H9z", step: "M3 2l7 6-7 6zM11 2h2v12h-2z",
  reset: "M13 2L6 8l7 6zM3 2h2v12H3z" };
let counted = 0;

// A name that no other element has.
function fresh(word) { counted += 1; return `${word}-${counted}`; }

// Makes an element. Texts of others get in as texts alone: there is no way to give HTML.
function make(tag, given = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(given)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key === "text") node.textContent = value;
    else if (key in node && ["value", "checked", "disabled", "hidden", "type", "title", "className"].includes(key)) node[key] = value;
    else node.setAttribute(key, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

function button(text, onclick, given = {}) { return make("button", { type: "button", text, onclick, ...given }); }

// A button's sign, drawn by us.
function sign(name) {
  const space = "http://www.w3.org/2000/svg", svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", SVG_SIGNS[name]);
  svg.append(path);
  return svg;
}

// Sets a text, only if it is another: selections and screen readers stay undisturbed.
function say(node, text) { if (node.textContent !== text) node.textContent = text; }

// What stands in a field, as JSON: a number or list where it reads as one, else the text, for the program to judge.
function reading(text) {
  const trimmed = text.trim();
  if (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(trimmed)) return Number(trimmed);
  if (/^[[{]/.test(trimmed)) { try { return JSON.parse(trimmed); } catch { return trimmed; } }
  return trimmed;
}

// A value as it is written into a field.
function writing(value) {
  if (value === null || value === undefined) return "";
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

// "robot.cables[2].frame" as words: "robot, cable 3, frame".
function words(path) {
  return path.replace(/s\[(\d+)\]/g, (_, i) => ` ${Number(i) + 1}`).replace(/\[(\d+)\]/g, (_, i) => ` ${Number(i) + 1}`)
    .replace(/_/g, " ").split(".").join(", ");
}

// Attitudes: quaternion (w, x, y, z) and roll, pitch, yaw about fixed axes, R = Rz(yaw) Ry(pitch) Rx(roll), rad.
function anglesOf([w, x, y, z]) {
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), Math.asin(clamp(2 * (w * y - z * x), -1, 1)),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))];
}

function quaternionOf([roll, pitch, yaw]) {
  const [a, b, c] = [roll, pitch, yaw].map((x) => Math.cos(x / 2)), [d, e, f] = [roll, pitch, yaw].map((x) => Math.sin(x / 2));
  return [a * b * c + d * e * f, d * b * c - a * e * f, a * e * c + d * b * f, a * b * f - d * e * c];
}

// To a thousandth of a unit: nobody drags finer than this.
function rounded(values, step = 0.001) { return values.map((x) => Number((Math.round(x / step) * step).toFixed(6))); }

// Tabs of which one's panel is shown; arrows go from one to the next. Labels may change, keys stay.
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

  // The panel of this key, made when it is first asked for.
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

  // How many of something a tab holds, "" for none.
  count(key, number) { say(this.all.get(key).tab.querySelector(".count"), number ? String(number) : ""); }

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
