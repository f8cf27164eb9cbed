"""Docstrings of public names: an example that runs, and all arguments."""

from __future__ import annotations

import doctest
import inspect
import os
import subprocess
import sys
from importlib import import_module

import pytest
from conftest import ROOT

import cdpr
from cdpr import plugins, testing
from cdpr.plugins.info import Hooks

PUBLIC = {
    f"{room.__name__}.{name}": getattr(room, name)
    for room in (cdpr, plugins, testing)
    for name in room.__all__
    if inspect.ismodule(found := getattr(room, name)) or inspect.isroutine(found) or inspect.isclass(found)
}
PUBLIC["cdpr"], PUBLIC["cdpr.plugins.info.Hooks"] = cdpr, Hooks
# A plugin's own hook marker and constants: documented where they are used.
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
# These start processes or run a whole conformance kit.
SLOW = {"cdpr.analysis.compare.job", "cdpr.analysis.study.run", "cdpr.testing.kit"}

MODULES = sorted(
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
    for file in (ROOT / package).rglob("*.py")
    if ">>> " in file.read_text()
)


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_an_example(name):
    assert ">>> " in (PUBLIC[name].__doc__ or ""), f"{name}: add an Example to its docstring"


@pytest.mark.parametrize("name", [name for name, found in PUBLIC.items() if inspect.isfunction(found)])
def test_every_argument_and_result_is_documented(name):
    function = PUBLIC[name]
    doc, signature = inspect.getdoc(function), inspect.signature(function)
    assert [each for each in signature.parameters if f"    {each}: " not in doc] == []
    assert "Returns:" in doc or signature.return_annotation == "None"


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in MODULES])
def test_examples_give_what_they_show(name):
    """As `pytest --doctest-modules` does."""
    done = doctest.testmod(import_module(name), optionflags=FLAGS, report=False)
    assert done.attempted
    assert done.failed == 0


# Packages of extras that the extra `test` does not have.
EXTRAS = (
    "mujoco pybullet dartpy fmpy matplotlib osqp piqp clarabel highspy pyarrow distributed websockets zenoh cma numba"
)
WITHOUT = """
from functools import partial
from importlib.machinery import PathFinder
def unless_hidden(find, name, *more):
    return None if name.partition(".")[0] in {names} else find(name, *more)
PathFinder.find_spec = partial(unless_hidden, PathFinder.find_spec)
"""


@pytest.mark.slow
def test_examples_need_no_extra(tmp_path):
    """The packages of extras are hidden from this Python, and from all that it starts."""
    (tmp_path / "sitecustomize.py").write_text(WITHOUT.format(names=set(EXTRAS.split())))
    command = [sys.executable, "-m", "pytest", "-n", "0", "-p", "no:cacheprovider", "--doctest-modules"]
    packages = ["cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers"]
    done = subprocess.run(
        [*command, *packages], cwd=ROOT, env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-3000:]


INTERFACES = (
    plugins.Backend,
    plugins.RigidBodyBackend,
    plugins.Controller,
    plugins.TensionSolver,
    plugins.CompiledSolver,
)
METHODS = [
    (kind, name, method)
    for kind in INTERFACES
    for name, method in vars(kind).items()
    if inspect.isfunction(method)
    and (not name.startswith("_") or name == "__init__")
    and (name == "__init__" or not any(hasattr(base, name) for base in kind.__mro__[1:]))
]


@pytest.mark.parametrize(
    ("kind", "name", "method"), METHODS, ids=[f"{kind.__name__}.{name}" for kind, name, _ in METHODS]
)
def test_arguments_of_interfaces_are_documented(kind, name, method):
    """Those of a constructor by the class, or by a base with the same ones; overriding methods need not repeat them."""
    bases = [base for base in kind.__mro__ if base is kind or base in INTERFACES]
    docs = [inspect.getdoc(each) or "" for each in bases] if name == "__init__" else [inspect.getdoc(method)]
    for argument in list(inspect.signature(method).parameters)[1:]:
        assert any(f"    {argument}: " in doc for doc in docs), argument
