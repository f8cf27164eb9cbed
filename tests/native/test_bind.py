"""Binding of compiled operations: every argument error is reported, and the struct that the kernel gets is right."""

from __future__ import annotations

import gc
import re
import struct
import sys
import weakref

import numpy as np
import pytest
from conftest import ROOT

from cdpr.base.errors import CdprError
from cdpr.native import bind as module
from cdpr.native import library
from cdpr.native.bind import bind
from cdpr.native.operations import VARIABLE, Operation, operations, targets
from cdpr.native.random_numbers import Stream, normal_numbers

pytestmark = pytest.mark.core

FIELDS = (
    "left(n, 3), order(m), eight(m), both state(n), answer(n, m), work scratch(2*m + n + 0*k, n*n + 1), "
    "n, m, k, gain, rounds"
)
ARRAYS = ("const double*", "const int64*", "const lanes*", "double*", "double*", "double*")
TYPES = (*ARRAYS, "int64", "int64", "int64", "double", "int64")
ADDRESS = 8  # of no function
seen = []


class Recorder:
    """Stand-in for a bound operation: records the words of its struct and the time."""

    def __init__(self, words, arrays):
        self.words, self.arrays = words, arrays

    def __call__(self, time=0.0):
        seen.append((self.words, time))
        return 7


@pytest.fixture(autouse=True)
def recorder(monkeypatch):
    seen.clear()
    made = Operation("recorder", ADDRESS, FIELDS, TYPES)
    known = Operation("recorder", ADDRESS, FIELDS.replace(" + 0*k", "").replace(" k,", ""), TYPES[:8] + TYPES[9:])
    monkeypatch.setattr(module, "operations", lambda: {**operations(), "recorder": made, "known": known})
    real = library.Bound

    def bound(operation, words, given, arrays):
        return Recorder(words, arrays) if operation == ADDRESS else real(operation, words, given, arrays)

    monkeypatch.setattr(library, "Bound", bound)


def arguments(n=2, m=4, **more):
    return {
        "left": np.zeros((n, 3)),
        "order": np.zeros(m, dtype=np.int64),
        "eight": np.zeros((m, 8)),
        "state": np.zeros(n),
        "answer": np.zeros((n, m)),
        "gain": 0.5,
        "rounds": 3,
        "k": 9,
        **more,
    }


def products(n=2):
    return {name: np.zeros((n, 3)) for name in ("left", "right", "product")}


def read_only(array):
    array.flags.writeable = False
    return array


def misaligned(*shape):
    count = int(np.prod(shape))
    return np.zeros(8 * count + 1, dtype=np.uint8)[1:].view(np.float64).reshape(shape)


def test_the_kernel_gets_addresses_sizes_and_values_in_the_order_of_its_struct():
    given = arguments(scratch=np.zeros((10, 5)))
    call = bind("recorder", **given)
    assert call() == 7
    assert call(1.25) == 7
    arrays = [given[name] for name in ("left", "order", "eight", "state", "answer", "scratch")]
    expected = struct.pack("=9qdq", *(array.ctypes.data for array in arrays), 2, 4, 9, 0.5, 3)
    assert seen == [(expected, 0.0), (expected, 1.25)]


def test_work_that_is_left_out_is_made_and_kept():
    call = bind("recorder", **arguments())
    assert call.arrays[-1].shape == (10, 5)
    call()
    assert struct.unpack("=11q", seen[0][0])[5] == call.arrays[-1].ctypes.data


def test_arrays_live_as_long_as_what_is_bound():
    given = products()
    kept = weakref.ref(given["product"])
    call = bind("cross_products", **given)
    del given
    gc.collect()
    assert kept() is not None
    del call
    gc.collect()
    assert kept() is None


def test_bindings_free_their_memory():
    def counts():
        return sys.getrefcount(given["product"]), sys.getrefcount(type(bind("cross_products", **given)))

    given = products()
    before = counts()
    for _ in range(100):
        bind("cross_products", **given)()
    assert counts() == before


WRONG = [
    ({"lft": 1}, TypeError, "recorder: unknown arguments lft; expected answer, eight, "),
    ({"left": None}, TypeError, "recorder: left: expected a numpy array, got NoneType."),
    ({"left": [[0.0]]}, TypeError, "recorder: left: expected a numpy array, got list."),
    ({"left": np.zeros((2, 3), np.float32)}, TypeError, "left: expected dtype float64, got float32; convert"),
    ({"left": np.zeros((2, 3), ">f8")}, TypeError, "left: expected dtype float64, got >f8"),
    ({"order": np.zeros(4)}, TypeError, "recorder: order: expected dtype int64, got float64"),
    ({"order": np.zeros(4, np.int32)}, TypeError, "recorder: order: expected dtype int64, got int32"),
    ({"left": np.zeros((3, 2)).T}, ValueError, "left: expected a C-contiguous array; make one with"),
    ({"state": np.zeros(4)[::2]}, ValueError, "recorder: state: expected a C-contiguous array"),
    ({"left": misaligned(2, 3)}, ValueError, "left: expected an address that is a multiple of 8 bytes; copy"),
    ({"state": read_only(np.zeros(2))}, ValueError, "state: expected a writeable array, got a read-only one."),
    ({"answer": read_only(np.zeros((2, 4)))}, ValueError, "answer: expected a writeable array"),
    ({"scratch": read_only(np.zeros((10, 5)))}, ValueError, "scratch: expected a writeable array"),
    ({"left": np.zeros(6)}, ValueError, "recorder: left: expected shape (n, 3), got (6,)."),
    ({"left": np.zeros((2, 4))}, ValueError, "recorder: left: expected shape (n, 3), got (2, 4)."),
    ({"eight": np.zeros((4, 7))}, ValueError, "recorder: eight: expected shape (m, 8), got (4, 7)."),
    ({"state": np.zeros(3)}, ValueError, "state: expected shape (n,) with n = 2 from 'left', got (3,)."),
    ({"answer": np.zeros((2, 5))}, ValueError, "answer: expected shape (n, m) with m = 4 from 'order', got (2, 5)."),
    ({"n": 3}, ValueError, "recorder: left: expected shape (n, 3) with n = 3 from the argument 'n', got (2, 3)."),
    (
        {"scratch": np.zeros((10, 4))},
        ValueError,
        "n*n + 1) = (10, 5), got (10, 4).",
    ),
    ({"k": None}, TypeError, "recorder: missing sizes k, which follow from no array."),
    ({"k": 1.5}, TypeError, "recorder: k: expected an integer, got float."),
    ({"k": -1}, ValueError, "recorder: k: expected a size of at least 0, got -1."),
    ({"rounds": 2.0}, TypeError, "recorder: rounds: expected an integer, got float."),
    ({"rounds": 2**63}, ValueError, "recorder: rounds: expected an integer of 64 bits, got 9223372036854775808."),
    ({"gain": "fast"}, TypeError, "recorder: gain: expected a number, got str."),
    (
        {"gain": 10**400},
        ValueError,
        "recorder: gain: expected a number of at most 1.8e308 in size, got a larger one.",
    ),
    ({"gain": "1.0"}, TypeError, "recorder: gain: expected a number, got str."),
]


@pytest.mark.parametrize(("changes", "error", "message"), WRONG)
def test_a_wrong_argument_is_one_clear_error(changes, error, message):
    with pytest.raises(error) as raised:
        bind("recorder", **{**arguments(), **changes})
    assert message in str(raised.value)
    assert seen == []


@pytest.mark.parametrize(("changes", "error", "message"), [case for case in WRONG if "k" not in case[0]])
def test_nor_is_it_accepted_after_right_ones(changes, error, message):
    right = arguments()
    del right["k"]
    for _ in range(2):
        bind("known", **right)
    assert module.operations()["known"].plans
    with pytest.raises(error) as raised:
        bind("known", **{**right, **changes})
    assert message.removeprefix("recorder: ").split(";")[0] in str(raised.value)
    shared = np.zeros((2, 4))
    for changes in (
        {"answer": shared, "state": shared[0, :2]},
        {"answer": shared, "left": shared.reshape(-1)[2:].reshape(2, 3)},
    ):
        with pytest.raises(ValueError, match="shares memory"):
            bind("known", **{**right, **changes})


def test_rebinding_uses_new_addresses_and_values():
    right = arguments()
    del right["k"]
    for gain, rounds in ((0.5, 3), (np.float64(-2.0), -(2**62))):
        given = {name: np.array(value) if isinstance(value, np.ndarray) else value for name, value in right.items()}
        bound = bind("known", **{**given, "gain": gain, "rounds": rounds})
        addresses = [array.ctypes.data for array in bound.arrays]
        assert struct.unpack("=6q2qdq", bound.words) == (*addresses, 2, 4, gain, rounds)
        assert all(given[name] is array for name, array in zip(list(given)[:5], bound.arrays[:5], strict=True))
        assert bound.arrays[5].shape == (10, 5)


@pytest.mark.parametrize("name", ["left", "answer", "gain"])
def test_a_missing_argument_is_named(name):
    given = arguments()
    del given[name]
    with pytest.raises(TypeError, match=rf"^recorder: missing arguments {name}\.$"):
        bind("recorder", **given)


def test_an_unknown_operation_is_named_with_those_that_exist():
    with pytest.raises(ValueError, match=r"^Unknown operation 'nothing'; the library has .*recorder"):
        bind("nothing")


@pytest.mark.parametrize("words", [(1.0, 2.0), ("now",)])
def test_a_call_takes_at_most_the_time(words):
    with pytest.raises(TypeError):
        bind("cross_products", **products())(*words)


def test_a_call_takes_no_keywords():
    with pytest.raises(TypeError, match="at most the time"):
        bind("cross_products", **products())(time=1.0)


@pytest.mark.parametrize("start", [-3, -1, 0, 2, 3])
@pytest.mark.parametrize("name", ["left", "right"])
def test_outputs_must_not_share_memory_with_inputs(name, start):
    memory = np.zeros(12)
    given = products() | {name: memory[3:9].reshape(2, 3), "product": memory[3 + start : 9 + start].reshape(2, 3)}
    with pytest.raises(ValueError, match=rf"^cross_products: product: shares memory with {name}; write to"):
        bind("cross_products", **given)


def test_nor_with_what_is_written_or_scratch():
    memory = np.zeros(50)
    given = arguments(scratch=memory.reshape(10, 5), state=memory[48:])
    with pytest.raises(ValueError, match=r"^recorder: state: shares memory with scratch;"):
        bind("recorder", **given)


def test_arrays_may_touch_and_inputs_may_be_one_array():
    memory = np.arange(18.0)
    left, product = memory[:6].reshape(2, 3), memory[6:12].reshape(2, 3)
    assert bind("cross_products", left=left, right=left, product=product)() == 0
    assert (product == 0.0).all()


def test_empty_arrays_and_read_only_inputs_are_allowed():
    given = arguments(n=0, left=read_only(np.zeros((0, 3))))
    assert bind("recorder", **given)() == 7


@pytest.mark.parametrize("target", targets())
def test_each_instruction_set_has_the_operations_of_one_problem(monkeypatch, target):
    """Batches go one lane after the other where lanes do not pay; all else runs on every processor."""
    fastest = {name for name in operations() if not name.endswith("_lanes")}
    monkeypatch.setenv(VARIABLE, target)
    assert {name for name in operations() if not name.endswith("_lanes")} == fastest


@pytest.mark.parametrize("target", targets())
def test_the_environment_forces_an_instruction_set(monkeypatch, target):
    monkeypatch.setenv(VARIABLE, target)
    left, right = np.random.default_rng(1).normal(size=(2, 50, 3))
    product = np.empty_like(left)
    call = bind("cross_products", left=left, right=right, product=product)
    monkeypatch.delenv(VARIABLE)
    fastest = bind("cross_products", left=left, right=right, product=product)
    assert (call.operation == fastest.operation) == (target == targets()[-1])
    assert call() == 0
    np.testing.assert_array_equal(product, np.cross(left, right))


@pytest.mark.parametrize("wanted", ["", "x86-64-v9", "x86_64"])
def test_an_instruction_set_that_this_processor_lacks_is_an_error(monkeypatch, wanted):
    monkeypatch.setenv(VARIABLE, wanted)
    told = rf"^{VARIABLE}: expected one of {', '.join(targets())}, got '{wanted}'; correct or unset it$"
    with pytest.raises(CdprError, match=told):  # its exit code is that of wrong usage
        operations()


def test_the_example_and_the_message_of_the_page_are_as_there():
    page = (ROOT / "docs" / "kernels.md").read_text()
    code, random = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names = {}
    exec(code + random, names)
    np.testing.assert_array_equal(names["noise"], normal_numbers(Stream(0, "encoder").state, 3))
    assert names["status"] == 0
    np.testing.assert_array_equal(names["product"], np.cross(np.eye(3), np.ones((3, 3))))
    with pytest.raises(ValueError, match="expected shape") as raised:
        bind("cross_products", left=np.eye(3), right=np.ones((2, 3)), product=np.ones((3, 3)))
    assert f"`{raised.value}`" in " ".join(page.split())


def test_a_number_below_its_least_value_is_an_error():
    arrays = {"rows": np.zeros((1, 1)), "since": np.zeros(1), "figures": np.zeros(10), "kept": np.zeros((1, 1))}
    given = arrays | {"at": np.zeros(6, np.int64), "columns": np.zeros(1, np.int64), "first": 0}
    for _ in range(2):
        with pytest.raises(ValueError, match=r"^count_samples: every: expected at least 1, got 0\.$"):
            bind("count_samples", **given, every=0)
        bind("count_samples", **given, every=1)


def test_fields_are_read_from_the_library():
    found = operations()["cross_products"]
    assert [(field.name, field.type, field.role, str(field)) for field in found.fields] == [
        ("left", "double*", "in", "(n, 3)"),
        ("right", "double*", "in", "(n, 3)"),
        ("product", "double*", "out", "(n, 3)"),
        ("n", "int64", "size", "()"),
    ]
