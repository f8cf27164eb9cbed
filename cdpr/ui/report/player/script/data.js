// Arrays of the page, and time look-up in them.

function readData(text) {
  const data = JSON.parse(text), buffer = bufferOf(data.bytes);
  data.bytes = "";
  return replaceArrays(data, buffer);
}

// Decode base64.
function bufferOf(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes.buffer;
}

// Replace every entry {at, n, kind} by a typed array.
function replaceArrays(node, buffer) {
  if (node === null || typeof node !== "object") return node;
  if (node.kind !== undefined && node.at !== undefined) return unpack(node, buffer);
  for (const key of Object.keys(node)) node[key] = replaceArrays(node[key], buffer);
  return node;
}

function unpack(entry, buffer) {
  if (entry.kind === "u1") return new Uint8Array(buffer, entry.at, entry.n);
  if (entry.kind === "f4") return new Float32Array(buffer, entry.at, entry.n);
  const steps = new Uint16Array(buffer, entry.at, entry.n);
  const values = new Float64Array(entry.n);
  for (let i = 0; i < entry.n; i++) values[i] = steps[i] === 65535 ? NaN : entry.low + entry.scale * steps[i];
  return values;
}

// Index of the last of ascending times that is not after t; 0 if all are.
function indexAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

// Index of the time nearest to t.
function nearest(times, t) {
  const k = indexAt(times, t);
  return k + 1 < times.length && times[k + 1] - t < t - times[k] ? k + 1 : k;
}

function clamp(value, low, high) { return Math.min(Math.max(value, low), high); }

// Readable number: four digits, typographic minus.
function shortNumber(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  let text;
  if (size !== 0 && (size < 1e-3 || size >= 1e7)) text = value.toExponential(2);
  else if (size >= 1e4) text = value.toFixed(0);
  else text = String(Number(value.toPrecision(4)));
  return text.replace(/-/g, "−");
}

// Step of 1, 2, 2.5 or 5 times a power of ten, with at most this many steps in a range.
function niceStep(range, count) {
  if (!(range > 0)) return 1; // empty range
  const rough = range / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  for (const step of [1, 2, 2.5, 5, 10]) if (step * power >= rough * 0.999) return step * power;
  return 10 * power;
}
