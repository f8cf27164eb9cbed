"""Plain data of a scenario, from which its YAML is written."""

from __future__ import annotations

import os
from typing import Any

from pydantic import BaseModel

from cdpr.base.files import seen_from
from cdpr.plugins import FileName
from cdpr.scenario.check import Checked
from cdpr.scenario.initial_from_home import forget
from cdpr.scenario.schema import ScenarioSection


def to_dict(sections: ScenarioSection, checked: Checked) -> dict[str, Any]:
    """Return completed sections and the plugins' options as plain data, in the order of the schema."""
    data = sections.model_dump(mode="json", by_alias=True, exclude_none=True, exclude={"backend_options"})
    given_options = {
        "controller": checked.controller_options,
        "solver": checked.solver_options,
        "estimator": checked.estimator_options,
    }
    for section, options in given_options.items():
        if options is None:
            continue
        core = data[section]  # core keys come first and take precedence over plugin keys of the same name
        data[section] = {**core, **options.model_dump(mode="json", by_alias=True), **core}
    given = {
        name: options.model_dump(mode="json", by_alias=True)
        for name, options in sorted(checked.backend_options.items())
    }
    data["backend_options"] = {name: options for name, options in given.items() if options}
    return data


def plain_in(folder: str, sections: ScenarioSection, checked: Checked) -> dict[str, Any]:
    """Return plain data with file names relative to a folder."""
    data = to_dict(sections, checked)

    def move(section: dict[str, Any], *keys: str) -> None:
        for key in keys:
            section[key] = seen_from(folder, os.path.join(checked.document.folder, section[key]))

    move(data["trajectory"], *sections.trajectory.files)
    for written, event in zip(data["events"], sections.events, strict=True):
        move(written, *event.files)
    for shape in (data["robot"]["platform"].get("shape", {}), *data["world"]["obstacles"]):
        move(shape, *({"mesh"} & shape.keys()))
    given = {
        "controller": checked.controller_options,
        "solver": checked.solver_options,
        "estimator": checked.estimator_options,
        "actuators": sections.actuators,
    }
    for name, options in given.items():
        if options is not None:
            data[name] |= _located(options, folder)
    for name, options in checked.backend_options.items():
        if name in data["backend_options"]:
            data["backend_options"][name] |= _located(options, folder)
    return data


def as_given(folder: str, sections: ScenarioSection, checked: Checked) -> dict[str, Any]:
    """Return the given values as plain data, without defaults, with file names relative to a folder."""
    document = checked.document.copy()
    forget(document)
    data: dict[str, Any] = _relocated(document.data, to_dict(sections, checked), plain_in(folder, sections, checked))
    return data


def _relocated(given: Any, here: Any, there: Any) -> Any:
    """Return given data with the values that differ between two complete versions of them."""
    if isinstance(given, dict) and isinstance(here, dict) and isinstance(there, dict):
        return {key: _relocated(value, here.get(key), there.get(key)) for key, value in given.items()}
    if isinstance(given, list) and isinstance(here, list) and isinstance(there, list) and len(given) == len(here):
        return [_relocated(*each) for each in zip(given, here, there, strict=True)]
    return there if isinstance(given, str) and here != there else given


def dumped(section: BaseModel) -> dict[str, Any]:
    """Return a section as plain data, without keys that are not given."""
    return section.model_dump(mode="json", by_alias=True, exclude_none=True)


def _located(options: BaseModel, folder: str) -> dict[str, str]:
    """Return the file names in options, relative to a folder."""
    names = {field.alias or key: getattr(options, key) for key, field in type(options).model_fields.items()}
    return {key: seen_from(folder, name.path) for key, name in names.items() if isinstance(name, FileName)}
