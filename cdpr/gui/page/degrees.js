// Angles: the window shows and takes degrees, files and the program have radians. Speeds of drums stay in rad/s, as
// their data sheets and models have them.

const DEGREE = Math.PI / 180;
const ANGULAR = /^rad(?=$|\/s)/; // units that are converted: rad, rad/s, rad/s^2, rad/s^3

const MACHINE = /(^|\.)winch(\.|$)/;

function isAngular({ unit, path, key }) { return ANGULAR.test(unit || "") && !MACHINE.test(path || key || ""); }
function unitShown(field) { return isAngular(field) ? field.unit.replace(ANGULAR, "deg") : field.unit || ""; }

// Digits beyond those that converting leaves right are dropped.
function toDegrees(value) { return Number((value / DEGREE).toPrecision(10)); }
function toRadians(value) { return Number((value * DEGREE).toPrecision(12)); }

// A widget for a field in radians that shows degrees. A number that was not changed goes back as it came.
function degreesWidget(widget, field, desk, label) {
  const came = new Map(); // radians by the degrees that are shown
  const each = (value, turn) => (Array.isArray(value) ? value.map((one) => each(one, turn)) : typeof value === "number" ? turn(value) : value);
  const back = (value) => each(value, (x) => came.get(x) ?? toRadians(x));
  const show = (value) => each(value, (x) => { const shown = toDegrees(x); came.set(shown, x); return shown; });
  const inner = widget(field, { ...wrapped(desk), edit: (which, value) => desk.edit(which, back(value)) }, label);
  return { ...inner, show: (now) => inner.show({ ...now, value: show(now.value) }) };
}

function wrapped(desk) { return { clear: (field) => desk.clear(field), usual: (field) => desk.usual?.(field) }; }

// The widget of a field, whatever its unit.
function widgetOf(field, desk, label) {
  const widget = WIDGETS[field.kind] || yamlWidget;
  return isAngular(field) && ["number", "vector"].includes(field.kind) ? degreesWidget(widget, field, desk, label) : widget(field, desk, label);
}
