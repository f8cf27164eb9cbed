"""Needs of the sections of a scenario, as their classes declare them (see `cdpr.base.needs`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, get_args

from pydantic.fields import FieldInfo

from cdpr.base.fields import Kind, Section
from cdpr.base.kinds import Kinds
from cdpr.base.needs import MEANINGS, UNCONCERNED, UNDECLARED, Needs, of_brake, of_brakes, of_exit_friction
from cdpr.base.problems import Path
from cdpr.cables import MODELS, WINCH_TYPES, named
from cdpr.cables.brake import brake_of
from cdpr.scenario.content import Content


def lacking(scenario: Content, role: str, properties: Mapping[str, object]) -> Iterator[tuple[Path, str]]:
    """Yield the path of each section that needs a feature which a "backend" or "controller" does not declare.

    Args:
        scenario: scenario.
        role: "backend" or "controller".
        properties: declared properties of the plugin.

    Yields:
        Path of the section, and the missing feature, such as "features: contact".
    """
    for path, needs, _ in in_use(scenario):
        for feature in missing(needs, role, properties):
            yield path, feature


def missing(needs: Needs, role: str, properties: Mapping[str, object]) -> Iterator[str]:
    """Yield the features that `needs` require of a "backend" or "controller" and that its properties do not declare."""
    required: Mapping[str, str | bool] = getattr(needs, role)
    for name, entry in required.items():
        declared = properties.get(name, ())
        if isinstance(entry, bool):
            if declared is not entry:
                yield MEANINGS.get(name, name)
        elif not isinstance(declared, tuple | list) or entry not in declared:
            yield f"{name}: {entry}"


def in_use(scenario: Content) -> Iterator[tuple[Path, Needs, Any]]:
    """Yield path, needs and value of each section and key that is not at its default."""
    yield from _walk(scenario.sections, ())
    robot = scenario.sections.robot
    for i, cable in enumerate(robot.cables):
        path: Path = ("robot", "cable", "model") if cable.model is None else ("robot", "cables", i, "model")
        model, chain = cable.model or robot.cable.model, robot.chain_of(cable)
        for part in (chain.winch, chain.span):
            of_type = part is not MODELS[named(model, bool(chain.winch.numbers))].winch and part is chain.winch
            owner: Path = ("robot", "winch") if cable.winch is None else ("robot", "cables", i, "winch")
            where = (*owner, "type") if of_type else path
            yield where, part.needs or UNDECLARED, model
        leaves = cable.exit or robot.cable.exit
        if leaves is not None and leaves.rubs:
            place: Path = ("robot", "cable") if cable.exit is None else ("robot", "cables", i)
            yield (*place, "exit"), of_exit_friction(), leaves
    if any(brake_of(cable) is not None for cable in scenario.robot.cables):
        yield ("robot", "winch", "brake_torque"), of_brake(), robot
        for i, event in enumerate(scenario.sections.events):
            if event.cuts_power:
                yield ("events", i, "category"), of_brakes(), event


def _walk(section: Section, path: Path) -> Iterator[tuple[Path, Needs, Any]]:
    for name, info in type(section).model_fields.items():
        value = getattr(section, name)
        if value is None or value == _default(section, name):
            continue
        here = (*path, info.alias or name)
        declared = declared_needs(type(section), name)
        items = [(i, part) for i, part in enumerate(value) if isinstance(part, Section)] if _is_list(value) else []
        if declared is not None:
            yield here, declared, value
        elif isinstance(value, Section):
            yield from _of_section(value, here)
        elif items:
            for i, part in items:
                yield from _of_section(part, (*here, i))
        else:
            yield here, UNDECLARED, value


def _of_section(section: Section, path: Path) -> Iterator[tuple[Path, Needs, Any]]:
    """Yield the needs of a section as a whole, or of its keys."""
    whole = needs_of(type(section))
    if isinstance(whole, Needs):
        yield path, whole, section
    else:
        yield from _walk(section, path)


def needs_of(model: type[Section]) -> Needs | Mapping[str, Needs] | None:
    """Return the declaration of a section: for the whole, or by key; None without one.

    A kind of section must declare its own, because its base class does not know what it needs.
    """
    if issubclass(model, Kind):
        own = vars(model).get("needs")
        return own if isinstance(own, Needs) else UNDECLARED
    return model.needs


def declared_needs(model: type[Section], name: str) -> Needs | None:
    """Return the needs of a field of a section that declares them by key; None if it declares none."""
    declared = needs_of(model)
    return declared if isinstance(declared, Needs) else (declared or {}).get(name)


def declarations(model: type[Section], path: str = "") -> Iterator[tuple[str, Needs | None]]:
    """Yield the dotted key and the needs of each key of a section; None if neither it nor its sections declare any."""
    whole = needs_of(model)
    if isinstance(whole, Needs):
        yield path, None if whole is UNDECLARED else whole
        return
    for name, info in model.model_fields.items():
        here, parts = f"{path}.{info.alias or name}".lstrip("."), list(parts_of(info))
        needs = declared_needs(model, name)
        if needs is not None or not parts:
            yield here, needs
            continue
        for part in parts:
            yield from declarations(part, f"{here}: {part.kind()}" if issubclass(part, Kind) else here)


def part_declarations() -> Iterator[tuple[str, Needs | None]]:
    """Yield key and needs of each cable model, once for its winch and once for its span, and of types of winches."""
    for name, chain in MODELS.items():
        for title, part in (("winch", chain.winch), ("span", chain.span)):
            yield f"robot.cable.model: {name} {title}", part.needs
    for name, (simple, driven) in WINCH_TYPES.items():
        yield f"robot.winch.type: {name}", simple.needs
        yield f"robot.winch.type: {name} with inertia", driven.needs
    yield "robot.cable.exit: with friction", of_exit_friction()
    yield "robot.winch.brake_torque", of_brake()
    yield "robot.winch.brake_torque: with a power cut", of_brakes()


def parts_of(info: FieldInfo) -> Iterator[type[Section]]:
    """Yield the classes of sections of which the value of a field can consist."""
    for each in (info.annotation, *info.metadata):
        yield from _sections_in(each)


def _sections_in(annotation: Any) -> Iterator[type[Section]]:
    if isinstance(annotation, Kinds):
        yield from annotation.values()
    elif isinstance(annotation, type) and issubclass(annotation, Section):
        if not issubclass(annotation, Kind) or "type" in vars(annotation).get("__annotations__", {}):
            yield annotation
    else:
        for each in (*get_args(annotation), *getattr(annotation, "__metadata__", ())):
            yield from _sections_in(each)


def _default(section: Section, name: str) -> Any:
    """Return the default of a field of a section; `UNCONCERNED`, which differs from every value, if it has none."""
    info = type(section).model_fields[name]
    if info.is_required():
        return UNCONCERNED
    if info.default_factory is not None and info.default_factory_takes_validated_data:
        return info.get_default(call_default_factory=True, validated_data=dict(section))
    return _constant_default(type(section), name)


@cache
def _constant_default(model: type[Section], name: str) -> Any:
    return model.model_fields[name].get_default(call_default_factory=True)


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple)
