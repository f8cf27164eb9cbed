"""Validation of the sensors of a scenario across sections."""

from __future__ import annotations

import json
from collections.abc import Callable

from pydantic import ValidationError

from cdpr.base.columns import known_columns
from cdpr.base.defaults import ESTIMATOR
from cdpr.base.problems import Path
from cdpr.config.messages import explain
from cdpr.scenario.checks import Checks
from cdpr.sensing import SENSORS, Sensor

MOST_WAITING = 1e6  # values, 8 MB, which each snapshot copies
BELIEVED = "believed"
# Keys that a nominal sensor shares with the true one. Measurements have the times at which they were taken, so their
# delays are known.
FIXED = "type", "name", BELIEVED, "period", "delay", "jitter"
DROPOUT = "has no effect: estimators know which measurements have arrived; remove this key"
Multiple = Callable[[Path, float, float], None]  # reports a time that is no multiple of the control step, s


class SensorChecks(Checks):
    """Checks of `sensors`."""

    def check(self, control_step: float, multiple: Multiple) -> None:
        """Report repeated names, times between control steps, biases of a wrong length, and a pose without a twist.

        Args:
            control_step: control period, s.
            multiple: function that reports a time of a path which is no multiple of the control step.
        """
        given = self.document.get(("sensors",))
        cables = len(list(self.cables(("robot",))))
        titles: dict[str, int] = {}
        columns: dict[str, str] = dict.fromkeys(known_columns(), "")  # with the sensor
        used: dict[str, int] = {}
        for i, data in enumerate(given if isinstance(given, list) else ()):
            kind = data.get("type") if isinstance(data, dict) else None
            if not isinstance(kind, str) or kind not in SENSORS:
                continue
            used.setdefault(SENSORS[kind].used, i)
            sensor = self.section(SENSORS[kind], ("sensors", i))
            if sensor is None:
                continue
            if (first := titles.setdefault(sensor.title, i)) != i:
                text = f"sensors {first + 1} and {i + 1} are both named '{sensor.title}': give one of them another name"
                self.add_problem(("sensors", i), text)
            places: list[tuple[Path, Sensor | None]] = [(("sensors", i), sensor)]
            if sensor.believed:
                places.append((("sensors", i, BELIEVED), self._nominal(("sensors", i, BELIEVED), sensor, cables)))
            for path, each in places:
                if each is not None:
                    self._biases(path, each, cables)
            for key in ("period", "delay", "jitter"):
                if value := getattr(sensor, key):
                    multiple(("sensors", i, key), value, control_step)
            self._name(i, sensor, columns)
            self._size(i, sensor, cables, control_step)
        estimator = self.document.get(("estimator", "type"))
        if estimator in (None, ESTIMATOR) and self.document.get(("estimator", "start")) is not None:
            text = f"the estimator `{ESTIMATOR}` has no start: remove this key, or choose another estimator"
            self.add_problem(("estimator", "start"), text)
        for one, other in (("pose", "twist"), ("twist", "pose")) if estimator in (None, ESTIMATOR) else ():
            if one in used and other not in used:
                text = f"the controller uses this {one}, and needs a {other}, too: add a sensor of the type {other}"
                self.add_problem(("sensors", used[one]), text)

    def _nominal(self, path: Path, sensor: Sensor, cables: int) -> Sensor | None:
        """Report problems of the values in `believed`; return the nominal sensor if there is none."""
        for key in FIXED:
            if key in (sensor.believed or {}):
                self.add_problem((*path, key), "must be that of the sensor: remove this key")
                return None
        if "dropout" in (sensor.believed or {}):
            self.add_problem((*path, "dropout"), DROPOUT)
            return None
        data = sensor.nominal_data()
        try:
            nominal = type(sensor).model_validate_json(json.dumps(data))
        except ValidationError as error:
            for each in explain(error, type(sensor), data):
                self.add_problem((*path, *each.path), each.text)
            return None
        widths, others = ([each.values(cables) for each in one.quantities] for one in (sensor, nominal))
        if widths != others:
            self.add_problem(path, f"expected a sensor with {sum(widths)} values, as measured, got {sum(others)}")
            return None
        return nominal

    def _biases(self, path: Path, sensor: Sensor, cables: int) -> None:
        for quantity in sensor.with_errors:
            errors = sensor.errors_of(quantity)
            count = quantity.components(cables)
            if isinstance(errors.bias, tuple) and len(errors.bias) != count:
                text = f"expected one number, or {count} numbers, got {len(errors.bias)}"
                self.add_problem((*path, quantity.key, "bias"), text)

    def _name(self, i: int, sensor: Sensor, columns: dict[str, str]) -> None:
        """Report a name with which a column would have that of another quantity; add its columns to the known ones."""
        for column in sensor.columns:
            other = columns.setdefault(column.name, sensor.title)
            if other != sensor.title:
                of = f"sensor '{other}'" if other else "another quantity"
                text = f"its column '{column.name}' would have the same name as that of {of}: choose another name"
                self.add_problem(("sensors", i, "name"), text)

    def _size(self, i: int, sensor: Sensor, cables: int, control_step: float) -> None:
        """Report delays and periods with which too many values would be on their way."""
        values = sum(quantity.values(cables) for quantity in sensor.quantities)
        waiting = (sensor.delay + sensor.jitter) / (sensor.period or control_step)
        if waiting * values > MOST_WAITING:
            text = (
                f"{waiting * values:.3g} values would be on their way; expected at most {MOST_WAITING:g}: set a longer "
                "period, or shorter delay and jitter"
            )
            self.add_problem(("sensors", i, "delay"), text)
