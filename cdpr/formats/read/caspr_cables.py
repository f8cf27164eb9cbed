"""Reader of CASPR cable sets."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_DISTANCE
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path as Key
from cdpr.base.problems import shown
from cdpr.cables.pulley import Pulley
from cdpr.formats.read.imported import slug, unique
from cdpr.formats.read.xml import Element

SPRING = "cable_linear_spring"
TAUT = ("cable_ideal", SPRING)
REFUSED = {
    "cable_passive_linear_spring": "a passive spring, which is not supported",
    "cable_vsd_torsion_spring": "a stiffness that depends on the tension, which is not supported",
    "cable_vsd_flexure_linear": "a stiffness that depends on the tension, which is not supported",
    "cable_vsd_polynomial": "a stiffness that depends on the tension, which is not supported",
}
SCREWED = "screw_base_rotating_pulley"
PULLEY = "base_rotating_pulley"
PULLEYS = {"pulley_radius": "radius", "cable_entry_vector": "axis", "fixed_location": "frame"}


def cables(
    root: Element, chosen: str | None, centre: list[float]
) -> tuple[str, list[dict[str, Any]], dict[Key, str], list[str]]:
    """Return the name of the set, its cables in the format of robot files with `tension`, comments, and omitted items.

    Args:
        root: root element of the cables file.
        chosen: name of the cable set; None for the default.
        centre: (3,), centre of mass relative to the joint, m, the origin of some attachments.

    Raises:
        FormatError: if the set does not exist or is not representable.
    """
    sets = {each.attributes.get("id", ""): each for each in root.all("cable_set")}
    wanted = chosen if chosen is not None else root.attributes.get("default_cable_set", "")
    if wanted not in sets:
        which = f"cable set {shown(wanted)}" + ("" if chosen is not None else ", the default,")
        raise root.wrong(f"{which} does not exist; {did_you_mean(wanted, sets)}allowed: {', '.join(sets)}")
    try:
        rows, comments, left_out = _set(sets[wanted], centre)
    except FormatError as error:
        others = [name for name, each in sets.items() if name != wanted and _sound(each, centre)]
        if not others:
            raise
        which = f"its cable sets {', '.join(others)} can" if len(others) > 1 else f"its cable set '{others[0]}' can"
        raise FormatError(f"{error}; {which} be imported: choose cable set '{others[0]}' (--cable-set)") from None
    for name, other in sets.items():
        if name != wanted:
            left_out.append(f"{other.at}: cable set '{name}': '{wanted}' is imported (--cable-set chooses)")
            other.done()
    return wanted, rows, comments, left_out


def _sound(element: Element, centre: list[float]) -> bool:
    """Return True if all cables of a set are representable."""
    try:
        _set(element, centre)
    except FormatError:
        return False
    return True


def _set(element: Element, centre: list[float]) -> tuple[list[dict[str, Any]], dict[Key, str], list[str]]:
    rows: list[dict[str, Any]] = []
    comments: dict[Key, str] = {}
    left_out: list[str] = []
    found = element.children
    if not found:
        raise element.wrong(f"cable set '{element.attributes.get('id', '')}' contains no cable")
    names = unique([slug(each.attributes.get("name", ""), "cable") for each in found])
    for k, (cable, name) in enumerate(zip(found, names, strict=True)):
        cable.touch("name")
        rows.append(_cable(cable, name, centre))
        comments["cables", k] = f"{Path(cable.file).name}:{cable.line}"
        force_error = cable.child("properties").find("force_error")
        if force_error is not None:
            left_out.append(f"{force_error.at}: force_error of cable '{name}'")
            force_error.done()
    return rows, comments, left_out


def _cable(element: Element, name: str, centre: list[float]) -> dict[str, Any]:
    called = f"cable '{element.attributes.get('name', '')}'"
    if element.name in REFUSED:
        raise element.wrong(f"{called} is a {element.name}: {REFUSED[element.name]}")
    if element.name not in TAUT:
        raise element.wrong(f"{called} is a <{element.name}>, which is unknown; allowed: {', '.join(TAUT)}")
    reference = element.attribute("attachment_reference")
    if reference not in ("com", "joint"):
        raise element.wrong(f"attachment_reference of {called}: expected com or joint, got '{reference}'")
    ends = element.child("attachments").children
    if len(ends) != 2:
        raise element.wrong(
            f"{called} has {len(ends)} attachments; cables here have two, on the frame and the platform"
        )
    properties = element.child("properties")
    row: dict[str, Any] = {"name": name}
    shift = centre if reference == "com" else [0.0, 0.0, 0.0]
    for end in ends:
        row |= _end(end, called, shift)
    if not {"frame", "platform"} <= set(row):
        raise element.wrong(f"{called}: expected one attachment on the world, link 0, got both on one body")
    low, high = properties.child("force_min").number(), properties.child("force_max").number()
    row["tension"] = (low, high)
    if element.name == SPRING:
        row["axial_stiffness"] = properties.child("K").number()  # CASPR divides it by the length: it is E A, N
    diameter = properties.find("diameter") or element.find("diameter")
    if diameter is not None and diameter.number() > 0.0:
        row["diameter"] = diameter.number()
    return row


def _end(end: Element, called: str, shift: list[float]) -> dict[str, Any]:
    """Return an end of a cable: `frame` or `platform`, and the `exit` of a pulley."""
    if end.name == SCREWED:
        raise end.wrong(f"{called} winds on a {SCREWED}, which moves its exit along the drum, which is not supported")
    if end.name == PULLEY:
        given = {key: end.child(word) for word, key in PULLEYS.items()}
        exit_ = {"type": Pulley.kind(), "radius": given["radius"].number(), "axis": given["axis"].vector(3)}
        return {"frame": _place(given["frame"], called), "exit": exit_}
    if end.name != "attachment":
        raise end.wrong(f"{called} ends in a <{end.name}>, which is unknown; allowed: attachment, {PULLEY}")
    link = end.child("link").number()
    if link == 0.0:
        return {"frame": _place(end.child("location"), called)}
    if link != 1.0:
        raise end.wrong(f"{called} ends on link {link:g}, and there is one moving body, 1")
    place = _place(end.child("location"), called)
    return {"platform": [a + b for a, b in zip(place, shift, strict=True)]}


def _place(element: Element, called: str) -> list[float]:
    place = element.vector(3)
    if max(map(abs, place)) > MAX_DISTANCE:
        raise element.wrong(f"{called} ends {max(map(abs, place)):g} m away, beyond {MAX_DISTANCE:g} m")
    return place
