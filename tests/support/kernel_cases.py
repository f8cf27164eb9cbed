"""Random and adversarial inputs of kernels, and runs of compiled operations on many of them, one by one or in lanes."""

from __future__ import annotations

import os
from unittest.mock import patch

import numpy as np

from cdpr.native.bind import LANES, bind
from cdpr.native.operations import VARIABLE, targets
from cdpr.tension.status import Status

COUNT = 10_000  # inputs of each kernel, a multiple of LANES
HOSTILE = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, 1e-160, 1e160, -1e308, np.inf, -np.inf, np.nan])
RUBBISH = np.array([np.nan, 1e300, -np.inf, -7.0, 5e-324])


def bits(values):
    """All bits; of NaN, whose sign and payload compilers may choose, one pattern."""
    values = np.ascontiguousarray(values, dtype=np.float64)
    return np.where(np.isnan(values), np.uint64(0x7FF8000000000000), values.view(np.uint64))


def assert_same_bits(found, expected):
    differ = np.argwhere(bits(found) != bits(expected))
    assert not len(differ), (len(differ), differ[0], found[tuple(differ[0])], expected[tuple(differ[0])])


def numbers(rng, *shape):
    """A third of usual sizes, a third over the whole range of numbers, and a third with hostile ones among them."""
    first = np.arange(shape[0]).reshape(-1, *[1] * (len(shape) - 1)) % 3
    usual = rng.uniform(-5.0, 5.0, shape)
    wide = rng.normal(size=shape) * 10.0 ** rng.uniform(-150.0, 150.0, shape)
    poisoned = np.where(rng.random(shape) < 1.5 / shape[-1], rng.choice(HOSTILE, shape), usual)
    return np.choose(first, [usual, wide, poisoned])


def rubbish(array):
    array.reshape(-1)[:] = np.resize(RUBBISH, array.size)


def run(name, inputs, outputs, before=None, **values):
    """Return the outputs and status codes of an operation for each of the inputs, arrays by name, (count, ...).

    `before` is what outputs hold that are also read; others hold rubbish.
    """
    return _run(name, inputs, outputs, values, before or {})


def run_lanes(name, inputs, outputs, before=None, **values):
    """Do that eight at a time; status codes are bits then."""

    def group(arrays):
        return {
            key: np.ascontiguousarray(np.moveaxis(value.reshape(-1, LANES, *value.shape[1:]), 1, -1))
            for key, value in arrays.items()
        }

    answers, codes = _run(f"{name}_lanes", group(inputs), outputs, values, group(before or {}), (LANES,))
    single = {key: np.moveaxis(value, -1, 1).reshape(-1, *value.shape[1:-1]) for key, value in answers.items()}
    return single, codes


def _run(name, inputs, outputs, values, before, lanes=()):
    """Run it for each instruction set of this processor: all give the same bits."""
    answers, codes = zip(
        *(_run_on(target, name, inputs, outputs, values, before, lanes) for target in targets_of(name)), strict=True
    )
    first, *others = (meaningful(each) for each in answers)
    for further in others:
        for key, value in further.items():
            assert_same_bits(value, first[key])
    assert all((each == codes[0]).all() for each in codes)
    return answers[-1], codes[-1]


def targets_of(name):
    """Instruction sets with an operation: in a library for several, the first has none in lanes."""
    several = len(targets()) > 1 and name.endswith("_lanes")
    return targets()[1:] if several else targets()


def meaningful(answers):
    """Answers with 0 for the tensions of problems whose status is not OK: they have no meaning."""
    if not {"tension", "status"} <= answers.keys():
        return answers
    return {**answers, "tension": np.where(answers["status"] == Status.OK, answers["tension"], 0.0)}


def _run_on(target, name, inputs, outputs, values, before, lanes):
    count = len(next(iter((inputs or before).values())))
    given = {key: np.empty(value.shape[1:]) for key, value in inputs.items()}
    kinds = {key: value.dtype for key, value in before.items()}
    written = {key: np.empty((*shape, *lanes), kinds.get(key, float)) for key, shape in outputs.items()}
    with patch.dict(os.environ, {VARIABLE: target}):
        call = bind(name, **given, **written, **values)
    scratch = [array for array in call.arrays if not any(array is each for each in given.values())]
    scratch = [array for array in scratch if array.dtype == np.float64]
    answers = {key: np.empty((count, *array.shape)) for key, array in written.items()}
    codes = np.empty(count, dtype=np.int64)
    for k in range(count):
        for key, array in given.items():
            array[...] = inputs[key][k]
        if k % 16 == 0:  # what one call leaves is rubbish to the next
            for array in scratch:
                rubbish(array)
        for key, value in before.items():
            written[key][...] = value[k]
        codes[k] = call()
        for key, array in written.items():
            answers[key][k] = array
    return answers, codes
