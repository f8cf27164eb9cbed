// Formatting and parsing of numbers, names and attitudes.

// Content of a field as JSON: a number or list if possible, else the text, to be checked by the server.
function reading(text) {
  const trimmed = text.trim();
  if (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(trimmed)) return Number(trimmed);
  if (/^[[{]/.test(trimmed)) { try { return JSON.parse(trimmed); } catch { return trimmed; } }
  return trimmed;
}

// Value as written into a field.
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

// Round to a thousandth of a unit, finer than dragging.
function rounded(values, step = 0.001) { return values.map((x) => Number((Math.round(x / step) * step).toFixed(6))); }
