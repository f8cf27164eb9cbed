"""Support that a section of a scenario needs from exports, backends and other users of scenarios.

Each section declares its needs in the class attribute `needs`: one `Needs` for the section as a whole, or one for each
of its keys. Kinds of sections (events, motions, exits), parts of cables and parts of the loop declare one each.
`cdpr.scenario.needs` and `cdpr.simulation.needs` read the declarations. Every use rejects sections that declare
nothing; exports reject such parts of the loop.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal

Level = Literal["yes", "left out", "no", "depends", "-"]


@dataclass(frozen=True)
class Support:
    """Support of a section by one use.

    Attributes:
        level: "yes"; "left out", which the use reports; "no", so that it rejects the section; "depends" on
            options of the use, which itself rejects or reports it; "-" if the section does not concern the use.
        why: reason or limitation, a clause for messages; "" without one.
    """

    level: Level
    why: str = ""


YES = Support("yes")
UNCONCERNED = Support("-")


def left_out(why: str) -> Support:
    """Return the support of a use that omits a section and reports that."""
    return Support("left out", why)


def no(why: str) -> Support:
    """Return the support of a use that rejects a section."""
    return Support("no", why)


def depends(why: str) -> Support:
    """Return the support of a use that depends on its options; the use itself rejects or reports the section."""
    return Support("depends", why)


# Uses of scenarios, with their names in messages. Each is a field of `Needs`.
USES: Mapping[str, str] = MappingProxyType(
    {
        "plant_fmu": "an exported FMU without controller",
        "controller_fmu": "an exported FMU with controller",
        "bare_controller_fmu": "an exported FMU of the controller alone",
        "native": "the export for real-time programs",
        "ros2": "the export as ROS 2 packages",
        "mjcf": "MJCF",
        "sdf": "SDF",
        "urdf": "URDF",
        "rollout": "a rollout",
        "threads": "a rollout on several threads",
        "live": "a live run",
        "compare": "a comparison of engines",
    }
)


# Exports that do not contain the scenario.
MODELS_AND_CONTROLLERS = "plant_fmu", "controller_fmu", "bare_controller_fmu", "native", "mjcf", "sdf", "urdf"
EXPORTS = (*MODELS_AND_CONTROLLERS, "ros2")

# Meaning of properties that are True or False, for messages.
MEANINGS: Mapping[str, str] = MappingProxyType({"load": "changes of the platform's mass during a run (load)"})


@dataclass(frozen=True)
class Needs:
    """Needs of a section or part: its support by each use, and the required features of plugins.

    Attributes:
        plant_fmu, controller_fmu, bare_controller_fmu, native, ros2, mjcf, sdf, urdf, rollout, threads, live, compare:
            support by each of `USES`.
        works: sources of work on the platform that it adds, each with the column of its work, J; "" if it is unknown.
        backend: required properties of the backend: an entry of a list, such as {"exits": "pulley"}, or True.
        controller: the same for the controller.

    Example:
        >>> from cdpr.base.needs import Needs, no
        >>> Needs(native=no("it has no clock")).support("native").why
        'it has no clock'
    """

    plant_fmu: Support = YES
    controller_fmu: Support = YES
    bare_controller_fmu: Support = YES
    native: Support = YES
    ros2: Support = YES
    mjcf: Support = YES
    sdf: Support = YES
    urdf: Support = YES
    rollout: Support = YES
    threads: Support = YES
    live: Support = YES
    compare: Support = YES
    works: Mapping[str, str] = field(default_factory=dict, hash=False)
    backend: Mapping[str, str | bool] = field(default_factory=dict, hash=False)
    controller: Mapping[str, str | bool] = field(default_factory=dict, hash=False)

    def support(self, use: str) -> Support:
        """Return the support by one of `USES`."""
        found: Support = getattr(self, use)
        return found


def of_run(**others: Support) -> Needs:
    """Return the needs of what concerns runs only, not exported plants and models; `others` override them."""
    return _but({**dict.fromkeys(MODELS_AND_CONTROLLERS, UNCONCERNED), **others})


def of_control(**others: Support) -> Needs:
    """Return the needs of what concerns runs and exported controllers, not plants and models."""
    plants = ("plant_fmu", "mjcf", "sdf", "urdf")
    return _but({**dict.fromkeys(plants, UNCONCERNED), **others})


def of_motion(**others: Support) -> Needs:
    """Return the needs of a desired motion: an input of exported FMUs, and part of exported real-time controllers."""
    resting = left_out("the desired motion is an input of the FMU; by default it is rest at the initial pose")
    return of_control(**{"controller_fmu": resting, "bare_controller_fmu": UNCONCERNED, **others})


def of_event(*, backend: Mapping[str, str | bool] | None = None, **others: Support) -> Needs:
    """Return the needs of an event: exports omit it, except packages that contain the scenario."""
    apart = left_out("not exported")
    native = left_out("only changes of the desired motion by events are exported")
    return _but({**dict.fromkeys(MODELS_AND_CONTROLLERS, apart), "native": native, "backend": backend or {}, **others})


def of_winch() -> Needs:
    """Return the needs of a winch, or of a cable that is not ideal."""
    with_winch = depends("winches and elasticity are left out without --with-winch")
    ideal_only = depends("winches and elastic cables are an error")
    as_ideal = depends("winches and elasticity are left out")
    by_style = depends(
        "with --style legs, winches and elastic cables are an error; with --style platform, they are left out"
    )
    return Needs(plant_fmu=with_winch, controller_fmu=with_winch, mjcf=ideal_only, sdf=by_style, urdf=as_ideal)


def of_exit_friction() -> Needs:
    """Return the needs of exits on which cables lose tension."""
    with_winch = depends("friction on exits is left out without --with-winch")
    apart = left_out("friction on exits is left out")
    feature = {"features": "exit_friction"}
    plants = {"plant_fmu": with_winch, "controller_fmu": with_winch}
    return _but({**plants, "mjcf": apart, "sdf": apart, "urdf": apart, "backend": feature})


def of_brakes() -> Needs:
    """Return the needs of a power cut of winches with brakes."""
    return replace(of_run(), backend={"features": "brakes"})


def of_brake() -> Needs:
    """Return the needs of brakes, which act at a power cut only: exported plants contain none."""
    apart = left_out("exported winches always have power, so their brakes never close")
    return of_run(plant_fmu=apart, controller_fmu=apart)


def of_length_winch() -> Needs:
    """Return the needs of a winch that takes a length or its rate as its command."""
    models = {key: getattr(of_winch(), key) for key in ("mjcf", "sdf", "urdf")}
    return _but({**models, "backend": {"features": "winch_commands"}})


def of_stepper() -> Needs:
    """Return the needs of a stepper: exported controllers command lengths, and leave their steps to the drives."""
    return replace(of_length_winch(), backend={"features": "steppers"})


def of_drives() -> Needs:
    """Return the needs of imperfect drives: they are in all runs, and neither in exported plants nor controllers."""
    at_once = no("exported winches apply their commands exactly and at once")
    apart = left_out("imperfections of drives are not exported")
    return of_run(plant_fmu=at_once, controller_fmu=at_once, mjcf=apart, sdf=apart, urdf=apart)


def of_sensor(**others: Support) -> Needs:
    """Return the needs of a sensor: it is in all runs; the state that an exported controller sees is its input.

    An exported plant with controller contains the sensors that its controller or its estimator uses.
    """
    apart = left_out("sensors are not exported")
    used = depends("only the sensors that the controller or the estimator uses are exported")
    given = left_out("the state of the platform is an input of the exported controller")
    exports = dict.fromkeys(("plant_fmu", "mjcf", "sdf", "urdf"), apart)
    return of_run(**{**exports, "controller_fmu": used, "bare_controller_fmu": given, "native": given, **others})


def of_estimator() -> Needs:
    """Return the needs of an estimator: as those of a sensor; an exported plant with controller contains it."""
    return of_sensor(controller_fmu=YES)


def of_loop_part() -> Needs:
    """Return the needs of a part of the loop that declares none: it is in all runs, and in no export."""
    apart = no("exports contain no added parts of the loop")
    return _but(dict.fromkeys(EXPORTS, apart))


def of_moving_anchors() -> Needs:
    """Return the needs of what moves the anchors on the frame: all exports have anchors at rest."""
    resting = no("its cables leave from anchors at rest")
    feature = {"features": "moving_anchors"}
    return _but({**dict.fromkeys(MODELS_AND_CONTROLLERS, resting), "backend": feature, "controller": feature})


EVERYWHERE = Needs()


def declared(*names: str) -> dict[str, Needs]:
    """Return the needs of fields that are supported everywhere."""
    return dict.fromkeys(names, EVERYWHERE)


def _but(levels: Mapping[str, Any]) -> Needs:
    return replace(EVERYWHERE, **levels)


UNDECLARED = _but(dict.fromkeys(USES, no("its class declares no `needs`")))
