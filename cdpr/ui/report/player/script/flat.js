// Painter for browsers without WebGL: draws the same lines and solids on a 2D canvas, back to front.

class FlatPainter {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  draw(camera, ratio, lines, solids) {
    const c = this.context, view = camera.matrix();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    const pieces = [];
    for (const { data, count } of lines) {
      for (let i = 0; i < count; i++) this.line(pieces, camera, view, data, i * LINE);
    }
    for (const solid of solids) this.solid(pieces, camera, view, solid);
    pieces.sort((p, q) => q.depth - p.depth);
    for (const piece of pieces) piece.paint(c);
    c.setLineDash([]);
  }

  line(pieces, camera, view, data, at) {
    const a = camera.project(view, data.subarray(at, at + 3)), b = camera.project(view, data.subarray(at + 3, at + 6));
    if (!a || !b) return;
    const colour = rgba(data.subarray(at + 6, at + 10)), width = data[at + 10], dash = data[at + 11];
    const least = a[0] === b[0] && a[1] === b[1] ? 0.01 : 0; // px: points are lines of zero length, which are not drawn
    const paint = (c) => {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.lineCap = dash ? "butt" : "round";
      c.setLineDash(dash ? [dash, dash] : []);
      c.beginPath();
      c.moveTo(a[0], a[1]);
      c.lineTo(b[0] + least, b[1]);
      c.stroke();
    };
    pieces.push({ depth: 0.5 * (a[2] + b[2]) * 0.999, paint });
  }

  solid(pieces, camera, view, { body, model, colour }) {
    const { right, above, back } = camera.axes();
    const light = unit([0, 1, 2].map((i) => 0.35 * right[i] + 0.55 * above[i] + 0.75 * back[i]));
    const turn = (v, w) => [0, 1, 2].map((i) => model[i] * v[0] + model[4 + i] * v[1] + model[8 + i] * v[2] + w * model[12 + i]);
    for (let k = 0; k < body.corners.length; k += 18) {
      const points = [0, 6, 12].map((o) => camera.project(view, turn(body.corners.subarray(k + o, k + o + 3), 1)));
      if (points.some((p) => !p)) continue;
      const [p, q, r] = points;
      if ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) >= 0) continue; // back face
      const shade = 0.62 + 0.38 * dot(turn(body.corners.subarray(k + 3, k + 6), 0), light);
      const fill = rgba([...colour.slice(0, 3).map((x) => x * shade), colour[3]]);
      const paint = (c) => {
        c.fillStyle = c.strokeStyle = fill;
        c.lineWidth = colour[3] === 1 ? 0.7 : 0.01;
        c.setLineDash([]);
        c.beginPath();
        points.forEach((s, i) => (i ? c.lineTo(s[0], s[1]) : c.moveTo(s[0], s[1])));
        c.closePath();
        c.fill();
        c.stroke();
      };
      pieces.push({ depth: (p[2] + q[2] + r[2]) / 3, paint });
    }
  }

  forget() {}
}

function rgba(c) {
  const [r, g, b] = [0, 1, 2].map((i) => Math.round(255 * clamp(c[i], 0, 1)));
  return `rgba(${r},${g},${b},${c[3]})`;
}

// Red, green, blue from 0 to 1 of "#rrggbb".
function rgb(text) { return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255); }
