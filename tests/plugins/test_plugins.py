"""Finding plugins: order, clashes, and broken ones that never stop the others."""

from __future__ import annotations

import itertools
import subprocess
import sys
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from pydantic import BaseModel

from cdpr.base.errors import PluginError
from cdpr.plugins import INTERFACE_VERSION, PluginInfo, hookimpl
from cdpr.plugins.registry import Registered, collect, registry


@dataclass
class Point:
    """Stand-in for an entry point, with the parts that the registry uses."""

    distribution: str
    plugin: Any
    name: str = "plugins"

    @property
    def dist(self) -> SimpleNamespace:
        return SimpleNamespace(name=self.distribution, version="1.0")

    def load(self) -> Any:
        if isinstance(self.plugin, BaseException):
            raise self.plugin
        return self.plugin


def package(*infos: Any, hook: str = "cdpr_solvers") -> ModuleType:
    module = ModuleType("stranger")

    def rows() -> list[Any]:
        return list(infos)

    rows.__name__ = hook
    setattr(module, hook, hookimpl(rows))
    return module


class Lax(BaseModel):
    """Ignores misspelt keys, as pydantic does by default."""


def info(name: str, **changes: Any) -> PluginInfo:
    return PluginInfo(**{"name": name, "factory": "json:dumps", "summary": "", **changes})


@pytest.mark.core
def test_our_own_plugins_come_through_the_entry_points():
    found = registry()
    assert not found.problems
    assert {"reference", "mujoco"} <= set(found.names("backend"))
    assert {"computed_torque", "static"} <= set(found.names("controller"))
    assert {"qp", "pseudo_inverse"} <= set(found.names("solver"))


@pytest.mark.core
@pytest.mark.parametrize(
    ("plugin", "reason"),
    [
        (ImportError("no libfoo.so"), "ImportError: no libfoo.so"),
        (SystemExit(3), "SystemExit: 3"),
        (ModuleType("empty"), "implements no hook"),
        (package(info("a"), hook="cdpr_solver"), "unknown hook 'cdpr_solver'"),
        (package("a"), "returned str, not PluginInfo"),
        (package(info("a", interface=INTERFACE_VERSION + 1)), "interface 2; this cdpr has 1"),
    ],
)
def test_a_broken_plugin_is_described_and_left_out(plugin, reason):
    found = collect([Point("bad", plugin), Point("good", package(info("fine")))])
    assert found.names("solver") == ["fine"]
    (problem,) = found.problems
    assert "bad" in problem
    assert reason in problem


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"options": Lax}, "must derive from cdpr.plugins.PluginOptions"),
        ({"options": dict}, "must derive from cdpr.plugins.PluginOptions"),
        ({"name": None}, "must be a text"),
        ({"name": ""}, "needs a name"),
        ({"factory": "json"}, "'module:Class'"),
        ({"summary": None}, "must be a text"),
        ({"requires": "mujoco"}, "tuple of module names"),
        ({"properties": None}, "must be a mapping"),
    ],
)
def test_a_malformed_row_is_refused_where_it_is_made(changes, reason):
    with pytest.raises((TypeError, ValueError), match=reason):
        info(**{"name": "a", **changes})


def test_a_submodule_of_a_missing_package_is_missing():
    assert Registered("backend", info("x", requires=("no_such.part",)), "cdpr", "1").missing == ["no_such.part"]


def test_an_interrupt_is_not_swallowed():
    with pytest.raises(KeyboardInterrupt):
        collect([Point("bad", KeyboardInterrupt())])


def test_clashes_do_not_depend_on_the_order_of_the_path():
    points = [
        Point("cdpr", package(info("qp"))),
        Point("zeta", package(info("qp"), info("own"))),
        Point("alpha", package(info("own"))),
    ]
    for order in itertools.permutations(points):
        found = collect(order)
        assert found.names("solver") == ["alpha:own", "qp", "zeta:own", "zeta:qp"]
        assert found.get("solver", "qp").distribution == "cdpr"
        assert len(found.problems) == 2


def test_third_parties_can_be_switched_off():
    found = collect([Point("cdpr", package(info("qp"))), Point("bad", SystemExit(1))], disabled=True)
    assert found.names("solver") == ["qp"]
    assert not found.problems


@pytest.mark.core
def test_unknown_name_lists_the_installed_and_the_nearest():
    with pytest.raises(PluginError, match=r"did you mean 'mujoco'\? installed are .*mujoco, reference"):
        registry().get("backend", "mujuco")


@pytest.mark.parametrize("name", ["drag", "cdpr_drag", "Drag"])
def test_a_plugin_that_does_not_import_is_reported_with_its_reason(name):
    found = collect([Point("cdpr", package(info("qp"))), Point("cdpr-drag", ModuleNotFoundError("no module aero"))])
    reason = r"cdpr-drag .*, entry point .*: ModuleNotFoundError: no module aero"
    with pytest.raises(PluginError, match=f"^solver '{name}' cannot be loaded: {reason}$"):
        found.get("solver", name)
    with pytest.raises(
        PluginError, match=rf"no solver is named 'qpx': did you mean 'qp'\? .*; not loaded, .*: {reason}"
    ):
        found.get("solver", "qpx")


@pytest.mark.core
def test_missing_requirement_names_the_remedy():
    entry = Registered("backend", info("x", requires=("no_such_module",), extra="cdpr[x]"), "cdpr", "1")
    assert entry.missing == ["no_such_module"]
    with pytest.raises(PluginError, match=r"needs no_such_module, .*pip install 'cdpr\[x\]'"):
        entry.load()


def test_installed_but_broken_is_distinguished():
    entry = Registered("backend", info("x", factory="json:no_such_class"), "stranger", "1")
    with pytest.raises(PluginError, match=r"installed but cannot be loaded .*no_such_class"):
        entry.load()


HEAVY = ("scipy", "matplotlib", "mujoco", "pybullet", "dartpy", "pyarrow")


# Modules that the validation of a simple scenario does not import.
UNUSED_BY_VALIDATE = (
    "mcap", "isal", "rich", "multiprocessing",
    "cdpr.gcode", "cdpr.scene", "cdpr.analysis", "cdpr.log.run", "cdpr.log.recorder", "cdpr.log.mcap_file",
    "cdpr.simulation.whole_run", "cdpr.simulation.runner", "cdpr.cables.pulley", "concurrent.futures",
)  # fmt: skip

# The kinds of events and motions that are imported.
KINDS = """
from cdpr.scenario.events import EVENTS; from cdpr.scenario.motions import MOTIONS
homes = [home.partition(":")[0] for kinds in (EVENTS, MOTIONS) for home in kinds.homes.values()]
print("LOADED", sorted({home for home in homes if home in sys.modules}))
"""


def modules(*steps):
    """Return what a process prints of modules, which runs code and then looks for these modules, in steps."""
    looks = (f"{code}\nprint('LOADED', sorted(set({heavy!r}) & set(sys.modules)))" for code, heavy in steps)
    code = "\n".join(["import sys", *looks, KINDS])
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    return [line.removeprefix("LOADED ") for line in output.splitlines() if line.startswith("LOADED ")]


def command(*words):
    return f"from cdpr.ui.cli import cli; cli.main({[*words]!r}, standalone_mode=False)"


def test_light_commands_import_no_heavy_modules():
    """One after the other in one process, as each imports what the one before does."""
    assert modules(
        ("import cdpr", (*HEAVY, "numpy", "pydantic")),
        (f"sys.argv = ['cdpr', '--help']; {command('--help')}", (*HEAVY, "numpy", "pydantic", "yaml", "rich")),
        (command("validate", "scenarios/caroca.yaml"), (*HEAVY, *UNUSED_BY_VALIDATE)),
        (command("solvers"), (*HEAVY, "osqp")),
        (f"import cdpr.scenario.json_schema; {command('plugins')}", HEAVY),
    ) == [*5 * ["[]"], "['cdpr.scenario.motions.hold', 'cdpr.scenario.motions.quintic']"]


# Packages that a run of ideal cables on our own backend does not import.
UNUSED_BY_A_RUN = (
    "numba", "rich", "multiprocessing",
    "cdpr.fmu.export", "cdpr.fmu.run", "cdpr.fmu.read.archive", "cdpr.simulation.simulation", "cdpr.ui.gui",
    "cdpr.ui.report.pages", "cdpr.ui.report.figures", "cdpr.analysis.compare", "cdpr.analysis.study",
)  # fmt: skip


@pytest.mark.slow
def test_a_run_of_compiled_parts_loads_only_what_it_needs(tmp_path):
    words = ["run", "scenarios/caroca.yaml", "--set", "simulation.duration=0.01", "--no-report", "--out"]
    found = modules((command(*words, str(tmp_path / "out")), (*HEAVY, *UNUSED_BY_A_RUN)))
    assert found[0] == "[]"
