"""Tendons and motors of an MJCF model as cables."""

from __future__ import annotations

import math
from typing import Any

from cdpr.base.errors import FormatError
from cdpr.base.problems import Path as Key
from cdpr.formats.read.imported import apart, slug, unique
from cdpr.formats.read.mjcf_body import SITE, Body, tidy
from cdpr.formats.read.mjcf_servos import Driven, Servo, driven, servo_of
from cdpr.formats.read.mjcf_text import Lines
from cdpr.formats.read.xml import Element
from cdpr.model.robot import COMMANDED

REMEDY = '<motor tendon="..." gear="-1" ctrllimited="true" ctrlrange="MIN MAX"/> makes its control the tension, N'
SAME = 1e-12  # relative difference of round-off
UNSAID = 0.003  # m, MuJoCo's default width of a drawn tendon


class Cables:
    """Cables in the order of their motors, which is the order of MuJoCo's controls.

    Attributes:
        rows: cables in the format of a robot file.
        tension: tension limits in the format of a robot file.
        pull: False if a cable may push.
        sections: sections `cable` and `winch` of a robot file, if some tendon has a servo.
        tools: named sites of the platform without cables, (3,), m, platform axes.
        comments: as in `Imported`.
        warnings: as in `Imported`.
    """

    def __init__(
        self,
        mujoco: Any,
        model: Any,
        lines: Lines,
        body: Body,
        dropped: set[int],
        given: tuple[float, float] | None = None,
    ) -> None:
        self._mujoco, self._model, self._lines, self._body = mujoco, model, lines, body
        self._given = given
        self.comments, self.warnings = dict[Key, str](), list[str]()
        if not model.ntendon:
            raise lines.root.wrong("it has no <spatial> tendon, so no cable")
        tendons = [each for group in lines.root.all("tendon") for each in group.children]
        self._tendons = [each for each in tendons if id(each) not in dropped]
        motors = [int(tendon) for tendon, _ in model.actuator_trnid]
        for tendon in range(model.ntendon):
            if tendon not in motors:
                raise self._wrong(tendon, f"it has no motor and no tension limits: {REMEDY}")
        if (twice := next((k for k, tendon in enumerate(motors) if tendon in motors[:k]), None)) is not None:
            raise self._wrong(motors[twice], "expected one motor, got two")
        self._servos, self._unlimited = dict[int, Servo](), list[int]()
        names = unique([slug(self._tendon(tendon), f"cable_{k + 1}") for k, tendon in enumerate(motors)])
        limits = [self._tension(motor, tendon) for motor, tendon in enumerate(motors)]
        self._warn_of_assumed()
        self.rows = [self._row(tendon, name) for tendon, name in zip(motors, names, strict=True)]
        self.tools = apart(self._tools([site for tendon in motors for site in self._sites(tendon)]), names)
        self.comments = {("cables", k): f"line {self._element(tendon).line}" for k, tendon in enumerate(motors)}
        lows, highs = [low for low, _ in limits], [high for _, high in limits]
        self.pull = min(lows) >= 0.0
        if not self.pull:
            least = motors[lows.index(min(lows))]
            text = (
                f"a control may push with {-min(lows):g} N: unilateral is set to false; with unilateral: true, "
                "cables only pull"
            )
            self.warnings.append(f"{self._element(least).at}: tendon '{self._tendon(least)}': {text}")
        self.tension = {
            key: values[0] if len(set(values)) == 1 else values for key, values in (("min", lows), ("max", highs))
        }
        for key in self.tension:
            self.comments["tension", key] = "N, of the ranges of motors and forces, times gear and gain"
        self.sections: dict[str, Any] = {}
        if self._servos:
            self._drive(motors, driven(model, motors, self._servos, highs, body.mass))

    def _drive(self, motors: list[int], found: Driven) -> None:
        """Add the winches of servos; the cables of motors stay ideal."""
        servos = {tendon: servo for tendon, servo in self._servos.items() if tendon in motors}
        at = self._element(next(iter(servos))).at
        kinds = " and ".join(sorted({servo.kind for servo in servos.values()}))
        names = ", ".join(f"'{self._tendon(each)}'" for each in servos)
        text = f"{len(servos)} tendons have servos ({names}), imported as winches of the type {kinds}; "
        self.warnings += [f"{at}: {text}{more}" for more in found.warnings]
        self.sections["cable"] = found.cable
        if all(winch == found.winches[0] for winch in found.winches):
            self.sections["winch"] = found.winches[0]
        else:
            for row, winch in zip(self.rows, found.winches, strict=True):
                row |= {"model": COMMANDED} if winch is None else {"winch": winch}
        self.comments["cable", "axial_stiffness"] = self.comments["cable", "damping"] = "assumed"
        self.comments["winch",] = "gains of the servos, kp and kv times gear^2, about a drum of 1 m"
        for why, these in (
            (
                "ctrlrange of servos of length: commands here have no limits",
                [k for k, each in servos.items() if each.kind == "position" and math.isfinite(each.controls[1])],
            ),
            ("timeconst of servos: commands here act at once", [k for k, each in servos.items() if each.lags]),
        ):
            if these:
                named = ", ".join(f"'{self._tendon(each)}'" for each in these)
                self._lines.left_out.append(f"{self._element(these[0]).at}: {why} ({named})")
        for tendon, servo in servos.items():
            if abs(servo.scale - 1.0) > SAME or servo.offset != 0.0:
                unit = "length" if servo.kind == "position" else "rate"
                text = f"a control of c is a {unit} of {servo.scale:g} c {servo.offset:+g} there; commands here are"
                self.warnings.append(f"{self._element(tendon).at}: tendon '{self._tendon(tendon)}': {text} {unit}s")

    def _warn_of_assumed(self) -> None:
        if self._unlimited and self._given is not None:
            low, high = self._given
            names = [f"'{self._tendon(each)}'" for each in self._unlimited]
            self.warnings.append(
                f"{self._element(self._unlimited[0]).at}: tensions of {', '.join(names)} are not limited in the file: "
                f"{low:g} to {high:g} N are those given to the import"
            )

    def _tools(self, ends: list[int]) -> dict[str, list[float]]:
        model, body = self._model, self._body
        names = {site: model.site(site).name for site in range(model.nsite) if body.moves(site) and site not in ends}
        named = {site: slug(name, "tool") for site, name in names.items() if name not in ("", SITE)}
        places = {site: tidy(body.place(site), body.size) for site in named}
        return {name: places[site] for site, name in zip(named, unique(list(named.values())), strict=True)}

    def _row(self, tendon: int, name: str) -> dict[str, Any]:
        model, body = self._model, self._body
        self._report_omitted(tendon)
        sites = self._sites(tendon)
        on = [body.moves(site) for site in sites]
        if on[0] == on[1]:
            where = f"on body '{body.name}'" if on[0] else "on the frame"
            raise self._wrong(tendon, f"expected one site on each, got both {where}")
        frame, platform = sites if on[1] else sites[::-1]
        ends = {"frame": frame, "platform": platform}
        row: dict[str, Any] = {"name": name} | {end: tidy(body.place(site), body.size) for end, site in ends.items()}
        drawn, width = self._element(tendon), float(model.tendon_width[tendon])
        if width > 0.0 and (width != UNSAID or "width" in drawn.attributes):
            row["diameter"] = 2.0 * width
        low, high = model.tendon_range[tendon].tolist()
        if high > max(low, 0.0):
            row["length"] = {**({"min": low} if low > 0.0 else {}), "max": high}
        return row

    def _sites(self, tendon: int) -> tuple[int, int]:
        """Return the two sites of a tendon.

        Raises:
            FormatError: if it has another path.
        """
        model, kinds = self._model, self._mujoco.mjtWrap
        first = int(model.tendon_adr[tendon])
        path = range(first, first + int(model.tendon_num[tendon]))
        found = []
        for k in path:
            kind = kinds(model.wrap_type[k])
            if kind in (kinds.mjWRAP_SPHERE, kinds.mjWRAP_CYLINDER):
                geom = model.geom(model.wrap_objid[k]).name
                text = f"it is wound around the geom '{geom}': pulleys of ours swivel, and geoms do not; "
                raise self._wrong(tendon, text + "use a site where it leaves, or write exit: {type: pulley} yourself")
            if kind == kinds.mjWRAP_PULLEY:
                raise self._wrong(
                    tendon, "it has a <pulley>, which divides its force; expected a cable with a single line"
                )
            if kind == kinds.mjWRAP_JOINT:
                raise self._wrong(tendon, "expected a <spatial> tendon between sites, got a <fixed> tendon of joints")
            found.append(int(model.wrap_objid[k]))
        if len(found) != 2:
            more = f", and '{model.site(found[2]).name}' is a third" if len(found) > 2 else ""
            raise self._wrong(tendon, f"it has {len(found)} sites{more}: one on the frame and one on the body")
        return found[0], found[1]

    def _tension(self, motor: int, tendon: int) -> tuple[float, float]:
        """Return the lowest and highest tension, N.

        Raises:
            FormatError: if the motor's force is not proportional to its control, or not limited.
        """
        model, mujoco = self._model, self._mujoco
        plain = (
            model.actuator_gaintype[motor] == mujoco.mjtGain.mjGAIN_FIXED
            and model.actuator_biastype[motor] == mujoco.mjtBias.mjBIAS_NONE
            and model.actuator_dyntype[motor] == mujoco.mjtDyn.mjDYN_NONE
        )
        servo = None if plain else servo_of(mujoco, model, motor)
        if servo is not None:
            self._servos[tendon] = servo
        elif not plain:
            text = "its actuator has its own gain, bias or dynamics: expected a motor, or a servo with kp and kv of at "
            raise self._wrong(tendon, text + "least 0")
        gear, gain = float(model.actuator_gear[motor, 0]), float(model.actuator_gainprm[motor, 0])
        low, high = -math.inf, math.inf
        ranges = (
            # The control of a servo is a length or its rate and does not limit the force.
            (plain and model.actuator_ctrllimited[motor], model.actuator_ctrlrange[motor], -gear * gain),
            (model.actuator_forcelimited[motor], model.actuator_forcerange[motor], -gear),
            # MuJoCo sums and limits the forces of a tendon's actuators before their gears.
            (model.tendon_actfrclimited[tendon], model.tendon_actfrcrange[tendon], -gear),
        )
        for limited, given, factor in ranges:
            if limited:
                ends = sorted(factor * float(end) for end in given)
                ends = ends if factor == 1.0 else tidy(ends)
                low, high = max(low, ends[0]), min(high, ends[1])
        if not (math.isfinite(low) and math.isfinite(high) and low <= high):
            if self._given is not None:
                self._unlimited.append(tendon)
                return self._given
            also = "; or give both limits to the import (--tension MIN,MAX)"
            if servo is not None:
                remedy = 'add forcerange="-MAX -MIN" to it, N, where its gear is 1'
                raise self._wrong(tendon, f"its servo has no limited force, so no limited tension: {remedy}{also}")
            raise self._wrong(tendon, f"no limit of its control or force: {REMEDY}{also}")
        if high <= 0.0:
            text = f"with gear {gear:g} and these ranges its tension is {low:g} to {high:g} N: it only pushes; "
            raise self._wrong(tendon, text + REMEDY)
        if plain and -gear * gain != 1.0:
            at = self._element(tendon).at
            text = f"a control of 1 is a tension of {-gear * gain:g} N there; commands here are tensions"
            self.warnings.append(f"{at}: tendon '{self._tendon(tendon)}': {text}")
        return low + 0.0, high + 0.0

    def _report_omitted(self, tendon: int) -> None:
        model = self._model
        if model.tendon_stiffness[tendon].any():
            text = "it is a spring: describe it as an elastic cable, by cable.model=elastic and axial_stiffness"
            raise self._wrong(tendon, text)
        effects = (
            {}
            if tendon in self._servos
            else {
                "damping": model.tendon_damping[tendon],
                "frictionloss": model.tendon_frictionloss[tendon],
                "armature": model.tendon_armature[tendon],
            }
        )
        for word, value in effects.items():
            if value.any():
                at = self._element(tendon).at
                self._lines.left_out.append(f"{at}: {word} of tendon '{self._tendon(tendon)}': ideal cables have none")
        if model.tendon_limited[tendon]:
            at = self._element(tendon).at
            text = "range of a tendon holds the body there; here it is the cable's `length`, without effect"
            self._lines.left_out.append(f"{at}: {text}")

    def _tendon(self, tendon: int) -> str:
        return str(self._model.tendon(tendon).name)

    def _element(self, tendon: int) -> Element:
        return self._tendons[tendon] if tendon < len(self._tendons) else self._lines.root

    def _wrong(self, tendon: int, text: str) -> FormatError:
        return self._element(tendon).wrong(f"tendon '{self._tendon(tendon)}': {text}")
