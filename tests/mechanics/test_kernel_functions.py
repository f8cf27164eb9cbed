"""Public functions of kernels with degenerate arguments: a result or one clear error, never another exception."""

from __future__ import annotations

import ast
import contextlib
import doctest
import importlib
import io
import re
import warnings
from functools import cache

import numpy as np
import pytest
from conftest import ROOT

from cdpr.base.errors import CdprError
from cdpr.cables.tables import chain_table, line_table
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.solids import row
from cdpr.model.shapes import Sphere
from cdpr.scenario import load_scenario

CLEAR = ValueError, TypeError, CdprError
ENDS = 0.0, -1.0, np.nan, np.inf, 1e308, 5e-324
KERNELS = re.compile(r"\b(bind|distribute_once|compute)\(")


@cache
def names():
    """Names that examples use: a robot with elastic cables, and states of its parts."""
    scenario = load_scenario(ROOT / "scenarios" / "winch.yaml")
    robot, state = scenario.robot, scenario.initial.state()
    cables, frame = np.linspace(1.0, 2.0, robot.m), BodyFrame(robot)
    bodies = {"state": state, "before": state, "after": state, "body": state, "frame": frame, "robot": robot}
    winches = ("command", "length", "rate", "unwound", "speed", "tension")
    tables = {each.__name__: each for each in (line_table, chain_table, BodyFrame, row, Sphere)}
    return {**bodies, **tables, "np": np, "tips": np.ones((robot.m, 3)), **dict.fromkeys(winches, cables)}


def functions():
    """Functions of modules that call kernels, whose docstrings have an example; the example runs them once."""
    for package in ("cdpr", "cdpr_solvers", "cdpr_controllers", "cdpr_backends"):
        for path in sorted((ROOT / package).rglob("*.py")):
            text, place = path.read_text(), path.relative_to(ROOT)
            if (
                ">>> " not in text or not KERNELS.search(text) or place.parts[-1] in ("bind.py", "compute.py")
            ):  # take any operation
                continue
            for each in ast.parse(text).body:
                if not isinstance(each, ast.FunctionDef) or each.name.startswith("_"):
                    continue
                called = rf"^\s*>>> .*(?<![\w.]){each.name}\("  # by its own name, not as one of `cdpr`
                if re.search(called, ast.get_docstring(each) or "", re.MULTILINE):
                    yield ".".join((*place.with_suffix("").parts, each.name))


def example(name):
    """Return the function, and the positional and named arguments of the first call of it in its example."""
    module, _, short = name.rpartition(".")
    known = names() | vars(importlib.import_module(module))
    function, caught = known[short], []

    def catch(*given, **named):
        caught.append((given, named))
        return function(*given, **named)

    known[short] = catch
    for each in doctest.DocTestParser().get_examples(function.__doc__):
        if not caught:
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(each.source, name, "single"), known)
    return function, *caught[0]


def degenerate(value):
    """Yield values in place of an argument: empty, of other shapes, and with numbers at the ends of their range."""
    if isinstance(value, bool | str) or value is None:
        return
    try:
        array = np.array(value)
    except ValueError:
        return
    if array.dtype == object or array.dtype.kind not in "fiub":
        return
    yield from ([], 0, -1, 7, np.nan, [[]], array[None])
    if array.ndim:
        yield from (array[:0], array[:-1], np.concatenate([array, array]), array.T, array[..., :0], array[..., None])
    for number in ENDS:
        if array.dtype.kind == "f" or number in (0.0, -1.0):
            yield np.full_like(array, number)
            if array.size > 1:
                one = array.copy()
                one.flat[-1] = number
                yield one
    if array.dtype.kind in "iu":
        yield from (np.full_like(array, 1 << 40), np.full_like(array, -(1 << 62)))


def unreal(value):
    """Yield arrays that are not made of real numbers, in place of an argument with numbers."""
    if isinstance(value, bool | str) or value is None:
        return
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        return
    if array.ndim and array.size:
        yield from (None, array + 1j, array.astype(object), array.astype(str), array.astype("M8[s]"), array.tobytes())
        masked = np.ma.array(array)
        masked[..., -1] = np.ma.masked
        yield masked
        yield [None, *array.tolist()]


def outcome(function, given, named):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            function(*given, **named)
        except CLEAR as error:
            return str(error)
    return "result"


@pytest.mark.parametrize("name", sorted(functions()))
def test_arrays_without_real_numbers_are_one_clear_error(name):
    """Numpy would drop imaginary parts and masks, and read None as NaN and text as numbers."""
    function, given, named = example(name)
    for place, value in [*enumerate(given), *named.items()]:
        for other in unreal(value):
            changed = list(given), dict(named)
            changed[isinstance(place, str)][place] = other
            with pytest.raises(CdprError, match=r"^[\w ]+: "):
                function(*changed[0], **changed[1])


@pytest.mark.parametrize("name", sorted(functions()))
def test_degenerate_arguments(name):
    function, given, named = example(name)
    told = []
    for place, value in [*enumerate(given), *named.items()]:
        for other in degenerate(value):
            changed = list(given), dict(named)
            changed[isinstance(place, str)][place] = other
            try:
                assert outcome(function, *changed)
            except Exception as error:
                told.append(f"{place}: {other!r}: {type(error).__name__}: {error}")
    nothing = [[] if isinstance(value, list | np.ndarray) else value for value in given]
    try:
        outcome(function, nothing, {})
    except Exception as error:
        told.append(f"all empty: {type(error).__name__}: {error}")
    assert told == []
