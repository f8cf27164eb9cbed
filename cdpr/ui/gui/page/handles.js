// Draggable points in the scene: the platform's target and the cables' anchors on frame and platform.
//
// A handle moves in the view plane, with Shift only vertically; arrow keys move the focused one. The target
// is sent when it is released. Other handles edit the form and are dashed until the edits are applied.

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const KEY_STEP = 8; // pixels per arrow key

class Handles {
  constructor(layer, viewer, live) {
    Object.assign(this, { layer, viewer, live, handles: [], moving: null, target: null, applied: null, wanted: null });
  }

  // Reset for another robot.
  load(film) {
    this.film = film;
    this.target = null;
    this.handles = [{ kind: "target", i: 0, text: "Target of the platform: drag to move it there" }];
    film.anchors.forEach((_, i) => {
      this.handles.push({ kind: "frame", i, text: `Anchor of cable ${i + 1} on the frame` });
      this.handles.push({ kind: "platform", i, text: `Point of cable ${i + 1} on the platform` });
    });
    this.layer.replaceChildren(...this.handles.map((handle) => this.button(handle)));
  }

  button(handle) {
    const { kind, text } = handle, node = button("", () => {}, { className: `handle ${kind}`, "aria-label": text, title: text });
    handle.node = node;
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      node.focus();
      node.setPointerCapture(event.pointerId);
      this.take(handle, [event.clientX, event.clientY]);
    });
    node.addEventListener("pointermove", (event) => {
      if (this.moving?.handle === handle && this.moving.from) this.drag(event.clientX, event.clientY, event.shiftKey);
    });
    node.addEventListener("pointerup", () => this.drop(handle));
    node.addEventListener("pointercancel", () => { this.moving = null; this.live.wake(); });
    node.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.moving = null;
      const by = KEYS[event.key];
      if (!by) { this.live.wake(); return; }
      event.preventDefault();
      event.stopPropagation();
      if (this.moving?.handle !== handle) this.take(handle, null);
      this.shift(this.moving.at, KEY_STEP * by[0], KEY_STEP * by[1], event.shiftKey);
    });
    node.addEventListener("keyup", (event) => { if (event.key in KEYS) this.drop(handle); });
    return node;
  }

  // World position of a handle, unless it is being dragged.
  place({ kind, i }) {
    const picture = this.film.at(0);
    if (kind === "target") {
      const pose = this.target ? this.target.position : Array.from((picture.desired || picture.pose).subarray(12, 15));
      return pose;
    }
    const away = this.edited(kind, i), anchor = this.film.anchors[i];
    if (kind === "frame") return anchor.slice(0, 3).map((x, k) => x + (away ? this.turn(away)[k] : 0));
    return moved(picture.pose, anchor.slice(3).map((x, k) => x + (away ? away[k] : 0)));
  }

  // Offset of a point in the form from the running one, in its own axes; null if there is none.
  edited(kind, i) {
    const is = this.applied?.[i]?.[kind], wants = this.wanted?.[i]?.[kind];
    if (![is, wants].every((point) => Array.isArray(point) && point.length === 3 && point.every(Number.isFinite))) return null;
    const away = wants.map((x, k) => x - is[k]);
    return away.some((x) => x !== 0) ? away : null;
  }

  // Conversions between base and world axes.
  turn(v) { const R = this.film.base; return R ? [0, 1, 2].map((r) => dot(R.slice(3 * r, 3 * r + 3), v)) : v; }
  back(v) { const R = this.film.base; return R ? [0, 1, 2].map((c) => dot([R[c], R[3 + c], R[6 + c]], v)) : v; }

  // Cables of the form; those of the simulation if the form is applied.
  setCables(rows, applied) {
    this.wanted = rows;
    if (applied || !this.applied || this.applied.length !== rows.length) this.applied = rows;
    this.live.wake();
  }

  take(handle, from) {
    this.moving = { handle, from, start: this.place(handle), at: this.place(handle), moved: false };
  }

  drag(x, y, upright) {
    const [x0, y0] = this.moving.from;
    this.shift(this.moving.start, x - x0, y - y0, upright);
  }

  shift(start, dx, dy, upright) {
    const { camera } = this.viewer, { right, above } = camera.axes(), seen = camera.project(camera.matrix(), start);
    if (!seen) return;
    const scale = 2 * seen[2] * Math.tan(camera.field / 2) / camera.size[1];
    const by = upright ? [0, 0, -dy * scale] : [0, 1, 2].map((i) => scale * (dx * right[i] - dy * above[i]));
    if (camera.flat !== null) by[camera.flat] = 0;
    this.moving.at = start.map((x, i) => x + by[i]);
    this.moving.moved = true;
    this.live.wake();
  }

  drop(handle) {
    const { moving } = this;
    this.moving = null;
    this.live.wake();
    if (moving?.handle !== handle || !moving.moved) return;
    if (handle.kind === "target") this.aim(rounded(moving.at));
    else this.edit(handle, moving.at.map((x, k) => x - moving.start[k]));
  }

  aim(position) {
    const rpy = rounded(anglesOf(this.live.frame?.dq || this.live.frame?.q || [1, 0, 0, 0]), 1e-4);
    if (this.live.send({ do: "target", position, rpy })) this.target = { position, since: performance.now() };
  }

  edit({ kind, i }, away) {
    const row = this.wanted?.[i];
    if (!Array.isArray(row?.[kind])) {
      this.live.note("error", `The form has no ${kind} point of cable ${i + 1} to move.`);
      return;
    }
    const { pose } = this.film.at(0), own = kind === "frame" ? this.back(away) : [0, 4, 8].map((k) => dot(pose.subarray(k, k + 3), away));
    const value = rounded(row[kind].map((x, k) => x + own[k]));
    if (this.live.send({ do: "edit", path: `robot.cables[${i}].${kind}`, value })) {
      this.live.note("info", `Cable ${i + 1}, ${kind} point: ${value.join(", ")} m. Apply to use it.`);
    }
  }

  // Dragged points, and handles at their current positions.
  draw(lines, solids, labels, film, picture, look) {
    if (this.target && picture.desired) { // reached, or outdated
      const gap = Math.hypot(...this.target.position.map((x, k) => x - picture.desired[12 + k]));
      if (gap < 1e-3 || performance.now() - this.target.since > 3000) this.target = null;
    }
    const goal = this.moving?.handle.kind === "target" ? this.moving.at : this.target?.position;
    if (goal) {
      const pose = Float32Array.from(picture.desired || picture.pose);
      pose.set(goal, 12);
      drawBody(film, pose, look.desired, 0.3, look.desired, lines, solids);
    }
    const at = (kind, i) => {
      const { handle, at: there } = this.moving || {};
      return handle && handle.kind === kind && handle.i === i ? there : this.place({ kind, i });
    };
    film.anchors.forEach((_, i) => {
      const held = this.moving && this.moving.handle.kind !== "target" && this.moving.handle.i === i;
      if (held || this.edited("frame", i) || this.edited("platform", i)) {
        lines.add(at("frame", i), at("platform", i), look.desired, 2, 1, 4);
      }
    });
    this.put();
  }

  put() {
    const { camera, options } = this.viewer, view = camera.matrix();
    for (const handle of this.handles) {
      const shown = handle.kind === "target" || options.handles;
      const at = this.moving?.handle === handle ? this.moving.at : shown ? this.place(handle) : null;
      const seen = at && camera.project(view, at);
      const style = seen ? `translate(${seen[0].toFixed(1)}px,${seen[1].toFixed(1)}px)` : "";
      if (style === handle.style) continue;
      handle.style = style;
      handle.node.hidden = !seen;
      handle.node.style.transform = style;
    }
  }
}
