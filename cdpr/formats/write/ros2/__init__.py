"""Export of a scenario as ROS 2 packages: a node that runs it, and a service that distributes a wrench.

The packages are NAME (ament_python: node, launch file, parameters, scenario), NAME_interfaces (ament_cmake: service;
ROS 2 requires a separate package for messages) and, if the controller can be exported, NAME_control (ament_cmake: the
controller as a C++ node). ROS is not needed for the export; files/ contains the templates.
"""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from cdpr.base.errors import CdprError, FormatError, OutputError
from cdpr.base.problems import dotted
from cdpr.cables import LENGTH, RATE, TENSION, commands_of
from cdpr.formats.write.native import HEADER, NUMBERS, native_files
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, create, replace
from cdpr.scenario import Scenario
from cdpr.scenario.named_files import files_of_scenario
from cdpr.simulation.needs import omitted, require

FILES = Path(__file__).parent / "files"

# Output path of each template; {name} is the package name.
LAYOUT = {
    "README.md": "README.md",
    "package.xml": "{name}/package.xml",
    "setup.py": "{name}/setup.py",
    "setup.cfg": "{name}/setup.cfg",
    "node.py": "{name}/{name}/node.py",
    "launch.py": "{name}/launch/{name}.launch.py",
    "parameters.yaml": "{name}/config/parameters.yaml",
    "interfaces_package.xml": "{name}_interfaces/package.xml",
    "CMakeLists.txt": "{name}_interfaces/CMakeLists.txt",
    "DistributeWrench.srv": "{name}_interfaces/srv/DistributeWrench.srv",
}
FIELD = {LENGTH: "POSITION", RATE: "VELOCITY", TENSION: "EFFORT"}  # of JointState, for commands of winches
FIRST = LAYOUT["README.md"]  # file that is written first
CONTROL = {
    "control_package.xml": "{name}_control/package.xml",
    "control_CMakeLists.txt": "{name}_control/CMakeLists.txt",
    "control.hpp": "{name}_control/src/control.hpp",
    "controller.cpp": "{name}_control/src/controller.cpp",
    "node.cpp": "{name}_control/src/node.cpp",
}


def write_ros2(
    scenario: Scenario, folder: Path, force: bool = False, remedy: str = NAME_OR_FORCE_IN_PYTHON
) -> tuple[list[Path], list[str]]:
    """Write the packages into `folder`, which must be empty or missing unless `force` is set.

    Equal scenarios give equal bytes. With `force`, files of the same names are replaced, and others are kept. `remedy`
    is that of the error if the folder is not empty.

    Returns:
        The files, sorted by name; omitted items, each with the reason.

    Raises:
        FormatError: if the scenario references other files.
        OutputError: if the folder is not empty (without `force`) or cannot be written.
    """
    content, left_out = packages(scenario)
    try:
        if folder.exists() and (not folder.is_dir() or (not force and any(folder.iterdir()))):
            raise FileExistsError
        folder.mkdir(parents=True, exist_ok=True)
        if not force:
            create(folder / FIRST, content[FIRST])  # exclusively: another process may write there, too
        for path in content:
            above = (folder / part for part in Path(path).parents[:-1])
            if (link := next((place for place in above if place.is_symlink()), None)) is not None:
                raise OutputError(f"{link}: is a symbolic link, and nothing is written through links: remove it")
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        what = "is not empty" if folder.is_dir() else "is no folder"
        raise OutputError(
            f"{folder}: exists already and {what}: {remedy if folder.is_dir() else 'choose another'}"
        ) from None
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    for path, data in content.items():
        replace(folder / path, data)
    return [folder / path for path in content], left_out


def packages(scenario: Scenario) -> tuple[dict[str, bytes], list[str]]:
    """Return the contents of all files by path, and omitted items, each with the reason.

    Raises:
        ScenarioError: if packages do not support a section of the scenario.
        FormatError: if the scenario references other files.
    """
    require(scenario, "ros2")
    text = scenario.resolved_yaml()
    for key, file in files_of_scenario(yaml.safe_load(text), scenario.plugins):
        raise FormatError(
            f"scenario '{scenario.name}': {dotted(key)} is the file '{file}', which a package for ROS 2 cannot "
            "contain: remove it (--set), or include its content in the scenario"
        )
    name = package_name(scenario.robot.name)
    # Names consist of letters, digits and -_. only and need no escapes in Python, XML or YAML.
    description = f"scenario '{scenario.name}' of the cable-driven parallel robot '{scenario.robot.name}'"
    found = {
        f"{name}/config/scenario.yaml": text.encode(),
        f"{name}/resource/{name}": b"",
        f"{name}/{name}/__init__.py": b"",
    }
    layout, left_out = LAYOUT, []
    try:
        native = native_files(scenario)
    except CdprError as error:
        left_out.append(f"the controller as a C++ node: {error}")
    else:
        found[f"{name}_control/src/{HEADER}"] = native[HEADER]
        found[f"{name}_control/config/{NUMBERS}"] = native[NUMBERS]
        layout = LAYOUT | CONTROL
        left_out += [f"of the controller as a C++ node: {each}" for each in omitted(scenario, "native")]
    left_out += omitted(scenario, "ros2")
    words = {
        "@PACKAGE@": name,
        "@DESCRIPTION@": description,
        "@FIELDS@": ", ".join(f"Field::{FIELD[takes]}" for takes in commands_of(scenario.robot)),
        "@NAMES@": ", ".join(f'"{cable.name}"' for cable in scenario.robot.cables),
    }
    for source, path in layout.items():
        filled = (FILES / f"{source}.in").read_text(encoding="utf-8")
        for word, value in words.items():
            filled = filled.replace(word, value)
        found[path.format(name=name)] = filled.encode()
    return dict(sorted(found.items())), left_out


def package_name(robot: str) -> str:
    """Return a valid ROS 2 package name: lower-case letters, digits and single underscores, starting with a letter."""
    word = re.sub(r"[^a-z0-9]+", "_", robot.lower()).strip("_")
    return f"cdpr_{word}" if word else "cdpr_robot"
