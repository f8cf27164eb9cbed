// Angles: the GUI uses degrees, files and server use radians. Speeds of drums remain in rad/s, as in
// their data sheets and models.

const DEGREE = Math.PI / 180;
const ANGULAR = /^rad(?=$|\/s)/; // converted units: rad, rad/s, rad/s^2, rad/s^3

const MACHINE = /(^|\.)winch(\.|$)/;

function isAngular({ unit, path, key }) { return ANGULAR.test(unit || "") && !MACHINE.test(path || key || ""); }
function unitShown(field) { return isAngular(field) ? field.unit.replace(ANGULAR, "deg") : field.unit || ""; }

// Drop digits that are round-off of the conversion.
function toDegrees(value) { return Number((value / DEGREE).toPrecision(10)); }
function toRadians(value) { return Number((value * DEGREE).toPrecision(12)); }

// Widget for a field in radians that shows degrees. Unchanged numbers are returned exactly.
function degreesWidget(widget, field, editor, label) {
  const came = new Map(); // radians by displayed degrees
  const each = (value, turn) => (Array.isArray(value) ? value.map((one) => each(one, turn)) : typeof value === "number" ? turn(value) : value);
  const back = (value) => each(value, (x) => came.get(x) ?? toRadians(x));
  const show = (value) => each(value, (x) => { const shown = toDegrees(x); came.set(shown, x); return shown; });
  const inner = widget(field, { ...wrapped(editor), edit: (which, value) => editor.edit(which, back(value)) }, label);
  return { ...inner, show: (now) => inner.show({ ...now, value: show(now.value) }) };
}

function wrapped(editor) { return { clear: (field) => editor.clear(field), usual: (field) => editor.usual?.(field) }; }

// Widget of a field with any unit.
function widgetOf(field, editor, label) {
  const widget = WIDGETS[field.kind] || yamlWidget;
  return isAngular(field) && ["number", "vector"].includes(field.kind) ? degreesWidget(widget, field, editor, label) : widget(field, editor, label);
}
