// Layout check of any page: nothing covered, cut or overflowing, texts of figures apart, and one colour for one thing.
//
// Two parts: `watchTexts` runs before the page's own scripts and records what they write on canvases; `checkPage` scrolls
// through the page and returns a list of faults, each a sentence. Lengths in px.

const NEAR = 2; // rounding of boxes to whole pixels
const NARROW = 700; // below this width tables and the navigation may scroll sideways, in a box that does so
const SCROLLS = ".scroll, nav ul", SIDEWAYS = ".sideways"; // the latter at any width: tables that are edited in a pane
const LARGEST_BAR = 0.62; // of the height of the screen, which a bar may take that stays in view
const TIGHT = 0.2; // of the height of a text: the part of its box in which no letter stands

function watchTexts() {
  const own = CanvasRenderingContext2D.prototype, { fillText, clearRect } = own;
  own.fillText = function (text, x, y, ...rest) {
    const { width, actualBoundingBoxAscent: up, actualBoundingBoxDescent: down } = this.measureText(text);
    const left = { center: 0.5, right: 1, end: 1 }[this.textAlign] || 0;
    const matrix = this.getTransform(), at = (px, py) => matrix.transformPoint(new DOMPoint(px, py));
    const corners = [[-left * width, -up], [(1 - left) * width, -up], [(1 - left) * width, down], [-left * width, down]];
    (this.canvas.written ||= []).push({ text: String(text), corners: corners.map(([a, b]) => at(x + a, y + b)) });
    return fillText.call(this, text, x, y, ...rest);
  };
  own.clearRect = function (...box) {
    this.canvas.written = [];
    return clearRect.apply(this, box);
  };
}

async function checkPage(width) {
  const faults = new Set(), seen = new Map();
  const shown = (el) => el.checkVisibility({ opacityProperty: true, visibilityProperty: true, contentVisibilityAuto: true });
  const name = (el) => {
    const told = el.id ? `#${el.id}` : el.className?.baseVal ?? el.className ? `.${String(el.className?.baseVal ?? el.className).split(" ")[0]}` : "";
    return el.tagName.toLowerCase() + told;
  };
  const short = (text) => `"${text.trim().replace(/\s+/g, " ").slice(0, 40)}"`;
  const style = (el) => getComputedStyle(el);
  const ancestors = function* (el) { for (let up = el.parentElement; up; up = up.parentElement) yield up; };
  const pause = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));

  // Text nodes outside of SVG, with the element that they are in.
  function* texts() {
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
      const node = walk.currentNode, el = node.parentElement;
      if (!node.data.trim() || el.closest("script, style, svg, option, canvas, noscript") || !shown(el)) continue;
      const folded = el.closest("details:not([open])");
      if (folded && !el.closest("summary")) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      yield { node, el, rects: [...range.getClientRects()].filter((r) => r.width > 1 && r.height > 1) };
    }
  }

  // The part of the screen in which an element is not clipped by what it is in.
  function clip(el) {
    const box = { left: 0, top: 0, right: innerWidth, bottom: innerHeight };
    for (const up of ancestors(el)) {
      if (up === document.body || up === document.documentElement || style(up).overflow === "visible") continue;
      const r = up.getBoundingClientRect();
      box.left = Math.max(box.left, r.left); box.right = Math.min(box.right, r.right);
      box.top = Math.max(box.top, r.top); box.bottom = Math.min(box.bottom, r.bottom);
    }
    return box;
  }

  // A bar as wide as the page that stays at an edge of the screen may hide what scrolls below it.
  function isBar(hit, el) {
    for (let up = hit; up; up = up.parentElement) {
      if (!["sticky", "fixed"].includes(style(up).position) || up.contains(el)) continue;
      const r = up.getBoundingClientRect();
      const edge = r.top <= 60 || r.bottom >= innerHeight - 4;
      if (edge && r.width >= 0.85 * innerWidth && r.height <= LARGEST_BAR * innerHeight) return true;
      const parent = up.parentElement.getBoundingClientRect(); // the head of a table or list in its own box
      if (up.matches("th, thead, .stays") && up.parentElement.closest("table, .list")?.contains(el) && parent) return true;
    }
    return false;
  }

  function look() {
    for (const { node, el, rects } of texts()) {
      const inside = clip(el);
      for (const r of rects) {
        const points = [[r.left + 3, r.top + r.height / 2], [r.right - 3, r.top + r.height / 2], [(r.left + r.right) / 2, r.top + r.height / 2],
          [r.left + 3, r.top + 4], [r.right - 3, r.bottom - 4]];
        for (const [x, y] of points) {
          // An edge between two pixels is hit as if it were at the nearest one.
          if (x <= inside.left + 1 || x >= inside.right - 1 || y <= inside.top + 1 || y >= inside.bottom - 1) continue;
          const hit = document.elementFromPoint(x, y);
          if (!hit) continue;
          if (hit === el || hit.contains(el) || el.contains(hit)) { seen.set(el, true); continue; }
          if (isBar(hit, el)) continue;
          faults.add(`${name(hit)} covers ${short(node.data)} of ${name(el)}`);
        }
      }
    }
    for (const canvas of document.querySelectorAll("canvas")) if (shown(canvas) && canvas.written?.length) written(canvas);
  }

  const apart = (a, b) => { // separating axes of two convex quadrangles
    for (const shape of [a, b]) {
      for (let i = 0; i < 4; i++) {
        const p = shape[i], q = shape[(i + 1) % 4], nx = q.y - p.y, ny = p.x - q.x;
        const span = (s) => { const at = s.map((v) => v.x * nx + v.y * ny); return [Math.min(...at), Math.max(...at)]; };
        const [a0, a1] = span(a), [b0, b1] = span(b);
        if (a1 <= b0 || b1 <= a0) return true;
      }
    }
    return false;
  };
  const shrunk = (quad, part) => { // towards its middle, by a share of its height
    const mid = { x: quad.reduce((s, v) => s + v.x, 0) / 4, y: quad.reduce((s, v) => s + v.y, 0) / 4 };
    const h = Math.hypot(quad[3].x - quad[0].x, quad[3].y - quad[0].y), w = Math.hypot(quad[1].x - quad[0].x, quad[1].y - quad[0].y);
    const ux = [(quad[1].x - quad[0].x) / w, (quad[1].y - quad[0].y) / w], uy = [(quad[3].x - quad[0].x) / h, (quad[3].y - quad[0].y) / h];
    const a = Math.max(0.5 * w - part * h, 0.1), b = Math.max(0.5 * h - part * h, 0.1);
    return [[-a, -b], [a, -b], [a, b], [-a, b]].map(([s, t]) => ({ x: mid.x + s * ux[0] + t * uy[0], y: mid.y + s * ux[1] + t * uy[1] }));
  };
  function collide(found, where) {
    const quads = found.map(({ text, corners }) => ({ text, quad: shrunk(corners, TIGHT) }));
    for (let i = 0; i < quads.length; i++) {
      for (let k = i + 1; k < quads.length; k++) {
        if (!apart(quads[i].quad, quads[k].quad)) faults.add(`${where}: ${short(quads[i].text)} lies over ${short(quads[k].text)}`);
      }
    }
  }

  function written(canvas) {
    const where = `canvas of ${name(canvas.closest("figure, section, [id]") || canvas.parentElement)}`;
    const quads = canvas.written.filter(({ text }) => text.trim());
    for (const { text, corners } of quads) {
      const off = corners.some((v) => v.x < -NEAR || v.y < -NEAR || v.x > canvas.width + NEAR || v.y > canvas.height + NEAR);
      if (off) faults.add(`${where}: ${short(text)} is cut`);
    }
    if (canvas.closest(".area")) collide(quads, where); // in space what is behind one another is near to it
  }

  // All boxes that scroll up and down, and the page.
  async function scrollThrough(act) {
    const boxes = [...document.querySelectorAll("body *")].filter((el) => shown(el) && el.clientHeight > 80
      && ["auto", "scroll"].includes(style(el).overflowY) && el.scrollHeight > el.clientHeight + 4);
    for (const box of [document.scrollingElement, ...boxes]) {
      for (let y = 0; ; y += Math.max((innerWidth < NARROW ? 0.3 : 0.45) * Math.min(box.clientHeight, innerHeight), 40)) {
        box.scrollTop = y;
        await pause();
        act();
        if (box.scrollTop + Math.min(box.clientHeight, innerHeight) >= box.scrollHeight - 2 || y > box.scrollHeight) break;
      }
      box.scrollTop = 0;
    }
    await pause();
  }

  function cut() {
    const page = document.documentElement;
    if (page.scrollWidth > width + NEAR) {
      const far = [...document.querySelectorAll("body *")].filter((el) => shown(el) && el.getBoundingClientRect().right > width + NEAR);
      faults.add(`the page is ${page.scrollWidth} px wide on ${width} px: ${name(far.at(-1) || page)}`);
    }
    
    for (const { node, el, rects } of texts()) {
      if (rects.length && !seen.get(el) && !el.closest("nav") && !sideways(el)) faults.add(`${short(node.data)} of ${name(el)} is never seen`);
      for (const up of [el, ...ancestors(el)]) {
        const { overflowX, overflowY } = style(up);
        if (up === document.body || up === page || (overflowX === "visible" && overflowY === "visible")) continue;
        const box = up.getBoundingClientRect();
        if (may(up)) break;
        if (rects.some((r) => r.left < box.left - NEAR || r.right > box.right + NEAR)) { faults.add(`${short(node.data)} is cut by ${name(up)}`); break; }
        if (overflowY === "hidden" && rects.some((r) => r.bottom > box.bottom + NEAR + 2 || r.top < box.top - NEAR - 2)) {
          faults.add(`${short(node.data)} is cut by ${name(up)}`);
          break;
        }
        if (["auto", "scroll"].includes(overflowY)) break;
      }
    }
    for (const el of document.querySelectorAll("table, figure, svg, canvas, pre, img, input, select, button, textarea, section, fieldset, iframe")) {
      if (!shown(el) || el.ownerSVGElement) continue;
      const card = el.parentElement.closest("figure, section, fieldset, dialog, .card, main, header, body");
      const r = el.getBoundingClientRect();
      if (!card || r.width === 0 || sideways(el)) continue;
      const box = card.getBoundingClientRect();
      if (r.left < box.left - NEAR || r.right > box.right + NEAR) faults.add(`${name(el)} overflows ${name(card)} by ${Math.round(Math.max(r.right - box.right, box.left - r.left))} px`);
    }
    for (const el of document.querySelectorAll("input:not([type=range]):not([type=checkbox]):not([type=radio]), select, button, summary, th, td")) {
      if (shown(el) && el.scrollWidth > el.clientWidth + NEAR && el.clientWidth > 0 && style(el).display !== "inline") faults.add(`${name(el)} cuts ${short(el.value || el.textContent)}`);
    }
    for (const el of document.querySelectorAll("select")) {
      if (!shown(el) || !el.selectedOptions[0]) continue;
      const c = new OffscreenCanvas(1, 1).getContext("2d");
      c.font = style(el).font;
      if (c.measureText(el.selectedOptions[0].text).width > el.clientWidth - 4) faults.add(`${name(el)} cuts ${short(el.selectedOptions[0].text)}`);
    }
  }
  function may(up) { return up.matches(SIDEWAYS) || (innerWidth < NARROW && up.matches(SCROLLS)); }

  // Whether something is in a box that may scroll sideways at this width, and does.
  function sideways(el) {
    for (const up of ancestors(el)) if (may(up) && up.scrollWidth > up.clientWidth + 1) return true;
    return false;
  }

  function figures() {
    for (const svg of document.querySelectorAll("svg")) {
      if (svg.ownerSVGElement || !shown(svg)) continue;
      const box = svg.getBoundingClientRect(), where = `svg "${svg.getAttribute("aria-label") || name(svg)}"`, quads = [];
      for (const text of svg.querySelectorAll("text")) {
        if (!text.textContent.trim()) continue;
        const { x, y, width: w, height: h } = text.getBBox(), matrix = text.getScreenCTM();
        const corners = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]].map(([a, b]) => new DOMPoint(a, b).matrixTransform(matrix));
        quads.push({ text: text.textContent, corners });
        if (shrunk(corners, TIGHT).some((v) => v.x < box.left - NEAR || v.x > box.right + NEAR || v.y < box.top - NEAR || v.y > box.bottom + NEAR)) {
          faults.add(`${where}: ${short(text.textContent)} is cut`);
        }
      }
      collide(quads, where);
    }
  }

  function colours() {
    const known = new Map(), plain = (colour) => { const c = new OffscreenCanvas(1, 1).getContext("2d"); c.fillStyle = colour; return c.fillStyle; };
    const note = (thing, colour, where) => {
      if (!known.has(thing)) known.set(thing, new Map());
      known.get(thing).set(plain(colour), where);
    };
    for (const el of document.querySelectorAll("[data-thing]")) {
      if (shown(el)) note(el.dataset.thing, el instanceof SVGElement ? style(el).stroke : style(el).color, name(el.closest("[id]") || el));
    }
    const { cdpr } = window, dark = cdpr?.dark ? 1 : 0;
    for (const [key, panels] of Object.entries(cdpr?.data?.figures || {})) {
      for (const panel of panels) {
        const looks = new Map();
        for (const series of panel.series) {
          if (!series.thing) continue;
          note(series.thing, series.colour[dark], key);
          const look = [series.colour[dark], series.dash.join(), series.width].join(";");
          if (looks.has(look) && looks.get(look) !== series.thing) faults.add(`${key}: ${series.thing} looks like ${looks.get(look)}`);
          looks.set(look, series.thing);
        }
      }
    }
    (cdpr?.data?.scenes || []).forEach((scene) => { if (scene.thing) note(scene.thing, scene.colour[dark], "scene"); });
    for (const [thing, found] of known) {
      if (found.size > 1) faults.add(`${thing} has ${found.size} colours: ${[...found].map((pair) => pair.join(" in ")).join(", ")}`);
    }
  }

  // What a link of the navigation leads to is seen where it leads.
  async function links() {
    for (const link of document.querySelectorAll('nav a[href^="#"]')) {
      const target = document.getElementById(decodeURIComponent(link.hash.slice(1)));
      if (!target) { faults.add(`${short(link.textContent)} leads nowhere`); continue; }
      if (!shown(target)) { faults.add(`${short(link.textContent)} leads to what is not shown`); continue; }
      target.scrollIntoView({ behavior: "instant" });
      await pause();
      const title = target.querySelector("h2, h3, .label") || target, r = title.getBoundingClientRect();
      const high = title.clientHeight ? r : target.getBoundingClientRect();
      const hit = document.elementFromPoint(high.left + 12, Math.min(high.top + Math.min(high.height / 2, 20), innerHeight - 2));
      if (!hit || !(target.contains(hit) || hit.contains(target))) faults.add(`${short(link.textContent)}: ${hit ? name(hit) : "nothing"} is where it leads`);
    }
    document.scrollingElement.scrollTop = 0;
  }

  await pause();
  await scrollThrough(look);
  cut();
  figures();
  colours();
  await links();
  return [...faults];
}
