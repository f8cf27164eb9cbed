"""`cdpr workspace KIND`: one command per kind."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from cdpr.base.errors import ExitCode, OutputError
from cdpr.model import Robot
from cdpr.scenario.examples import resolve
from cdpr.ui.cli import chunked
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files
from cdpr.ui.cli.numbers import AnyReal, Real, Whole, number
from cdpr.ui.cli.workspace_compare import ORACLES

if TYPE_CHECKING:
    from cdpr.analysis.workspace.kinds import WorkspaceKind
    from cdpr.analysis.workspace.required import Required
    from cdpr.analysis.workspace.result import Workspace
    from cdpr.model.robot import Array
    from cdpr.scenario import Scenario

SIX = "FX,FY,FZ,MX,MY,MZ"


# Progress units of methods, and methods of specific options.
UNITS = {"certify": "percent", "hull": "rounds", "rays": "rays"}
OWNERS = {"undecided": ("certify", "--undecided"), "n_rays": ("hull", "--rays"), "about": ("turns", "--about")}

# Options of some kinds by part of the question.
SOME = {
    "diameter": click.option(
        "--cable-diameter",
        "diameter",
        type=Real(0.0),
        metavar="M",
        help="Diameter of all cables, m. [the robot's, else 0.01]",
    ),
    "axial_stiffness": click.option(
        "--axial-stiffness",
        type=Real(0.0, min_open=True),
        metavar="N",
        help="E A of all cables. [the robot's]",
    ),
    "direction": click.option(
        "--direction", metavar="DOF", help="Direction: x, y, z, rx, ry or rz, all others free. [the softest]"
    ),
}


def command_of(name: str, text: str) -> click.Command:
    """Return the command of a kind."""
    from cdpr.analysis.workspace.kinds import KINDS

    kind = KINDS[name]
    forms = {"box": "Half widths of a box", "ellipsoid": "Half axes of an ellipsoid"}
    what = {
        "wrenches": ("wrench", "N, N m", SIX),
        "accelerations": ("acceleration", "m/s^2, rad/s^2", "AX,AY,AZ,RX,RY,RZ"),
    }
    options: list[Any] = [SOME[part] for part in kind.takes if part in SOME]
    if kind.needs or "required" in kind.takes:
        wanted = kind.needs or "wrenches"
        prefix, units, letters = what[wanted]
        for form, title in forms.items():
            options.append(
                click.option(
                    f"--{prefix}-{form}",
                    form,
                    metavar=letters,
                    help=f"{title} of required {wanted} ({units}).",
                )
            )
    if kind.programs:
        options.append(
            click.option(
                "--oracle",
                type=click.Choice(ORACLES),
                help="Verify some poses by linear programs, as 'cdpr workspace compare' does.",
            )
        )

    def run(
        file: str,
        changes: tuple[str, ...],
        orientation: tuple[str, ...],
        over: str,
        lower: str | None,
        upper: str | None,
        cells: str | None,
        method: str,
        undecided: float | None,
        about: str | None,
        rays: int | None,
        jobs: int | None,
        chunks: str | None,
        resume: bool,
        scheduler: str | None,
        out: str | None,
        force: bool,
        as_json: bool,
        box: str | None = None,
        ellipsoid: str | None = None,
        oracle: str | None = None,
        **options: Any,
    ) -> None:
        required = _required(kind, box, ellipsoid)
        place = Place(
            orientation, lower, upper, cells, method, {"undecided": undecided, "n_rays": rays, "about": about}
        )
        to = chunked.chunked_of(chunks, resume, scheduler, method, jobs, out)
        if oracle is not None and to is not None:
            raise click.UsageError("--oracle does not support --chunks: use 'cdpr workspace compare' on the folder")
        target = target_of(out, force)
        options["required"] = required
        _run(name, file, changes, place, over, options, jobs, to, target, force, as_json, oracle)

    unit = f" ({kind.unit})" if kind.unit else ""
    run.__doc__ = f"{text}\n\n    The value is the {kind.value}{unit}. {_more(kind.needs)}"
    command: Any = run
    for option in reversed([*_OPTIONS[:-3], *options, *chunked.OPTIONS, *_OPTIONS[-3:]]):
        command = option(command)
    return click.command(name)(command)


_OPTIONS = (
    click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path()),
    change_keys("Change any key of the file."),
    plugin_files,
    click.option(
        "--orientation",
        multiple=True,
        metavar="R,P,Y",
        help="Attitude: roll, pitch, yaw (rad, or as 30deg); repeatable. [the home's]",
    ),
    click.option(
        "--over",
        type=click.Choice(["all", "any"]),
        default="all",
        help="With several attitudes: all or any must be inside. [all]",
    ),
    click.option("--lower", metavar="X,Y,Z", help="Lowest corner of the evaluated box, m. [the frame's]"),
    click.option("--upper", metavar="X,Y,Z", help="Highest corner, m."),
    click.option("--cells", metavar="N|NX,NY,NZ", help="Cells along the longest side, or along each. [40]"),
    click.option(
        "--method",
        type=click.Choice(["grid", "octree", "hull", "rays", "turns", "certify"]),
        default="grid",
        help="All cells; only necessary cells; boundary from a point; lines; rotations; proved boxes. [grid]",
    ),
    click.option(
        "--undecided",
        type=Real(0.0, 1.0),
        metavar="SHARE",
        help="Share of the box that certify may leave undecided. [0.02]",
    ),
    click.option("--about", type=click.Choice(["rx", "ry", "rz"]), help="World axis of the rotations of turns. [rz]"),
    click.option("--rays", type=Whole(4, 10**6), metavar="N", help="Number of directions of hull. [2562]"),
    click.option(
        "--length",
        type=Real(0.0, min_open=True),
        metavar="M",
        help="Length that divides moments in margins, m. [the robot's characteristic length]",
    ),
    click.option("--at-least", type=AnyReal(), metavar="VALUE", help="Required value for a pose to be inside."),
    click.option("--jobs", type=Whole(1, 1024), metavar="N", help="Number of threads (default: one per core)."),
    click.option("--out", type=OutPath(), help="File, .npz."),
    force_option,
    click.option("--json", "as_json", is_flag=True, help="Print JSON."),
)


def _more(needs: str) -> str:
    start = "The command evaluates the centres of the cells of a box."
    if not needs:
        return start
    return f"{start} Required {needs} are in addition to carrying the weight at rest; world axes."


class Place(NamedTuple):
    """Region and method, as given by the options."""

    orientation: tuple[str, ...]
    lower: str | None
    upper: str | None
    cells: str | None
    method: Any
    finer: dict[str, Any]  # options of one method


def _run(
    kind: str,
    file: str,
    changes: tuple[str, ...],
    place: Place,
    over: Any,
    options: dict[str, Any],
    jobs: int | None,
    to: chunked.Chunked | None,
    target: Path | None,
    force: bool,
    as_json: bool,
    oracle: str | None,
) -> None:
    from cdpr.ui.cli.load import load_with_warnings

    loaded = load_with_warnings(file, changes)
    from cdpr.analysis.workspace.kinds import kind_of
    from cdpr.analysis.workspace.regions import region
    from cdpr.analysis.workspace.required import NOTHING
    from cdpr.analysis.workspace.result import workspace
    from cdpr.ui.cli.pose_option import parse_attitude, pose_and_gravity
    from cdpr.ui.cli.progress import Progress

    robot, gravity, _, _ = pose_and_gravity(loaded, None)
    turned = [parse_attitude(text, robot) for text in place.orientation]
    source = source_of(loaded, file, changes)  # recorded as loaded
    lower, upper = (_three(text, name) for text, name in ((place.lower, "--lower"), (place.upper, "--upper")))
    where = region(robot, lower=lower, upper=upper, cells=cells_of(place.cells), orientations=turned or None)
    if "obstacles" in kind_of(kind).takes and not isinstance(loaded, Robot):
        options["obstacles"] = loaded.obstacles
    options["required"] = options["required"] or NOTHING
    how: dict[str, Any] = {"over": over, "method": place.method, "jobs": jobs}
    for name, value in place.finer.items():
        if value is not None and OWNERS[name][0] != place.method:
            raise click.UsageError(f"{OWNERS[name][1]} is for --method {OWNERS[name][0]}")
    how |= {name: value for name, value in place.finer.items() if value is not None}
    if to is not None:
        figures = chunked.compute(to, robot, kind, where, jobs, source, options | {"gravity": gravity, "over": over})
        print_figures(figures | {"file": str(to.folder)}, as_json)
        return
    with Progress(UNITS.get(place.method, "cells")) as progress:
        found = workspace(robot, kind, where, gravity=gravity, progress=progress, **how, **options)
    found.about["source"] = source
    if oracle is not None:
        from cdpr.analysis.workspace.oracle import compare

        with Progress("poses") as progress:
            agreement = compare(found, robot, progress=progress)
        found.about["oracle"] = {"by": oracle, **dataclasses.asdict(agreement)}
    finish(found, target, force, as_json)
    if oracle is not None and agreement.different:
        raise click.exceptions.Exit(ExitCode.DISAGREES)


def target_of(out: str | None, force: bool) -> Path | None:
    """Return the file of --out.

    Raises:
        OutputError: if its name is no such file, or if it exists without `force`.
    """
    target = None if out is None else Path(out)
    if target is not None and (target.suffix != ".npz" or target.is_dir()):
        raise OutputError(f"{target}: --out: expected the name of a file that ends in .npz")
    if target is not None:
        from cdpr.log.files import require_new

        require_new(target, force)
    return target


def finish(found: Workspace, target: Path | None, force: bool, as_json: bool) -> None:
    """Write a workspace and print its figures."""
    if target is not None:
        from cdpr.log.files import make_folder
        from cdpr.ui.cli.progress import terminating

        make_folder(target.parent)
        with terminating():  # large files take seconds, and an incomplete one is removed
            found.save(target, force)
    print_figures(found.summary() | ({} if target is None else {"file": str(target)}), as_json)


def print_figures(figures: dict[str, Any], as_json: bool) -> None:
    """Print the figures of a workspace."""
    if as_json:
        click.echo(json.dumps(figures, indent=1, allow_nan=False))
        return
    from cdpr.ui.report.text.workspace import lines

    for line in lines(figures):
        click.echo(line)


def source_of(loaded: Scenario | Robot, file: str, changes: tuple[str, ...]) -> dict[str, Any]:
    """Return the data with which a file can restore the robot."""
    if isinstance(loaded, Robot):
        with open(resolve(file, None), encoding="utf-8") as read:
            return {"robot": read.read(), "changes": list(changes), "file": file}
    return {"scenario": loaded.resolved_yaml(), "file": file}


def _required(kind: WorkspaceKind, box: str | None, ellipsoid: str | None) -> Required | None:
    from cdpr.analysis.workspace import required

    if box is not None and ellipsoid is not None:
        raise click.UsageError("expected one required set: a box or an ellipsoid")
    text = box if box is not None else ellipsoid
    if text is None:
        if kind.needs:
            prefix = kind.needs.removesuffix("es" if kind.needs == "wrenches" else "s")
            units = "N, N m" if prefix == "wrench" else "m/s^2, rad/s^2"
            raise click.UsageError(
                f"missing required set, in addition to the weight: --{prefix}-box, six half widths ({units}), or "
                f"--{prefix}-ellipsoid"
            )
        return None
    make = required.box if box is not None else required.ellipsoid
    moved = kind.needs == "accelerations"
    name = f"--{'acceleration' if moved else 'wrench'}-{'box' if box is not None else 'ellipsoid'}"
    return make(numbers_of(text, (6,), name), accelerations=moved)


def _three(text: str | None, name: str) -> Array | None:
    return None if text is None else numbers_of(text, (3,), name)


def cells_of(text: str | None) -> Any:
    """Return the numbers of --cells."""
    if text is None:
        return None
    try:
        found = [int(part) for part in text.split(",")]
    except ValueError:
        found = []
    if len(found) not in (1, 3):
        raise click.BadParameter(f"expected a whole number, or three, got {text[:80]!r}", param_hint="--cells")
    return found


def numbers_of(text: str, counts: tuple[int, ...], name: str) -> Array:
    """Return finite numbers, as many as one of `counts`."""
    import numpy as np

    try:
        found = np.array([number(part) for part in text.split(",")])
    except ValueError:
        found = np.empty(0)
    if len(found) not in counts or not np.isfinite(found).all():
        raise click.BadParameter(f"expected {counts[0]} numbers with commas, got {text[:80]!r}", param_hint=name)
    return found
