"""Operations that were compiled elsewhere, and calls of bound operations on other arrays."""

from __future__ import annotations

import ctypes
import mmap
from concurrent.futures import ThreadPoolExecutor
from time import sleep
from types import SimpleNamespace

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import CdprError, PluginError
from cdpr.model.robot import read_only
from cdpr.native.bind import bind
from cdpr.native.foreign import MAPPINGS, OPERATION, Foreign
from cdpr.plugins import CompiledSolver, Controller
from cdpr.plugins.registry import registry


def test_a_numba_function_takes_arrays():
    numba = pytest.importorskip("numba")
    types = numba.types

    @numba.cfunc(types.int32(types.CPointer(types.CPointer(types.float64)), types.float64))
    def scale(place, time):
        for i in range(3):
            place[1][i] = time * place[0][i]
        return 7

    given, out = np.array([1.0, 2.0, 3.0]), np.zeros(3)
    call = Foreign(scale, given, out)
    del scale  # its code stays
    assert call(2.0) == 7
    np.testing.assert_array_equal(out, [2.0, 4.0, 6.0])
    assert call() == 7
    np.testing.assert_array_equal(out, 0.0)
    assert call.arrays == (given, out)
    assert call.place == call.words.ctypes.data


def test_the_struct_holds_addresses_and_numbers():
    seen = []

    class Place(ctypes.Structure):
        _fields_ = [("array", ctypes.c_void_p), ("number", ctypes.c_double), ("count", ctypes.c_int64)]

    def look(place, time):
        found = Place.from_address(place)
        seen.append((found.array, found.number, found.count, time))
        return 0

    call, array = OPERATION(look), np.zeros(2)
    address = ctypes.cast(call, ctypes.c_void_p).value
    for function in (address, SimpleNamespace(address=address)):
        assert Foreign(function, array, 0.5, 3)(0.25) == 0
    assert seen == [(array.ctypes.data, 0.5, 3, 0.25)] * 2


@pytest.mark.parametrize(
    ("arguments", "error", "told"),
    [
        ((np.zeros(3, np.float32),), TypeError, "argument 0: expected an array of float64 or int64, got float32"),
        ((1, np.zeros((4, 4))[:, 0]), ValueError, "argument 1: expected a C-contiguous"),
        ((2**63,), ValueError, "argument 0: expected an integer of 64 bits"),
        (("text",), TypeError, "argument 0: expected an array or a number, got str"),
    ],
)
def test_unsupported_struct_members_are_rejected(arguments, error, told):
    with pytest.raises(error, match=told):
        Foreign(1 << 20, *arguments)


NOTHING = OPERATION(lambda place, time: 0)


def test_a_writeable_array_shares_no_memory():
    """A kernel would read what it has overwritten; read-only views may overlap, as of a state and its position."""
    numbers = np.zeros(8)
    fixed = read_only(numbers)
    for first, second in ((numbers, numbers), (fixed, numbers[:1]), (numbers[:5], fixed[4:]), (fixed, numbers)):
        with pytest.raises(ValueError, match="argument 2: shares memory with argument 0, and one"):
            Foreign(NOTHING, first, 1, second)
    for first, second in (
        (fixed, fixed[3:]),
        (numbers[:4], numbers[4:]),
        (numbers, numbers[:0]),
        (numbers[2:2], fixed),
    ):
        assert Foreign(NOTHING, first, second).words.size == 2


class Overlapping(CompiledSolver):
    """Its work array is the end of its answer."""

    def __init__(self, robot, options):
        super().__init__(robot, options, NOTHING)

    def compiled(self, W, wrench, t_min, t_max, tension):
        return Foreign(NOTHING, W, wrench, t_min, t_max, tension, tension[-2:])


def test_a_solver_whose_work_arrays_overlap_those_of_the_stage_is_rejected():
    with pytest.raises(PluginError, match="argument 5: shares memory with argument 4"):
        cdpr.simulate("caroca", solver=Overlapping, overrides={"simulation.duration": 0.01})


def test_a_function_of_ctypes_is_called_by_its_address():
    function = ctypes.CDLL(None).abs
    assert Foreign(function, 1).operation == ctypes.cast(function, ctypes.c_void_p).value


def test_functions_without_an_address_are_rejected():
    with pytest.raises(TypeError, match="function: expected an address"):
        Foreign(print)


@pytest.fixture
def products():
    left, right = np.eye(3), np.ones((3, 3))
    return bind("cross_products", left=left, right=right, product=np.empty((3, 3)))


def test_an_operation_runs_on_other_arrays(products):
    rng = np.random.default_rng(0)
    for _ in range(2):
        left, right, product = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), np.empty((3, 3))
        left.flags.writeable = False
        assert products.on(bytes([0, 1, 2]), left, right, product) == 0
        np.testing.assert_allclose(product, np.cross(left, right))
    assert products() == 0  # its own are as they were
    np.testing.assert_array_equal(products.arrays[2], np.cross(np.eye(3), np.ones((3, 3))))
    assert products.on(bytes([2]), product) == 0
    np.testing.assert_array_equal(product, products.arrays[2])


def test_arrays_that_differ_are_rejected(products):
    good, read_only = np.zeros((3, 3)), np.zeros((3, 3))
    read_only.flags.writeable = False
    wrong = [np.zeros((2, 3)), np.zeros(9), np.zeros((3, 3), np.float32), np.zeros((3, 3), np.int64)]
    for bad in (*wrong, np.zeros((3, 3)).T.copy("F"), np.zeros((6, 3))[::2], "text"):
        with pytest.raises((ValueError, BufferError, TypeError)):
            products.on(bytes([0, 1, 2]), good, bad, good.copy())
    with pytest.raises((ValueError, BufferError)):
        products.on(bytes([0, 1, 2]), good, good, read_only)
    for positions, arrays in ((b"", [good]), (bytes([3]), [good]), (bytes([9]), [good]), ("text", [good])):
        with pytest.raises((ValueError, TypeError)):
            products.on(positions, *arrays)
    with pytest.raises(TypeError):
        products.on()


def test_arrays_that_share_memory_are_rejected(products):
    memory, other = np.zeros(27), np.ones((3, 3))
    left, right, product = (memory[i : i + 9].reshape(3, 3) for i in (0, 9, 17))
    for arrays in ((left, other, left), (left, right, product), (product, left, product[:])):
        with pytest.raises(ValueError, match="on: an array that is written shares memory with another one"):
            products.on(bytes([0, 1, 2]), *arrays)
    assert products.on(bytes([0, 1, 2]), other, other, left) == 0  # both are read
    nothing = memory[3:3].reshape(0, 3)
    empty = bind("cross_products", left=nothing, right=nothing, product=np.empty((0, 3)))
    assert empty.on(bytes([2]), nothing) == 0


@pytest.mark.parametrize("address", [0, 1, 2, -1, 1 << 63, 1 << 64, 1 << 200])
def test_an_address_below_all_code_is_an_error(address):
    with pytest.raises(ValueError, match="expected the address of a function"):
        Foreign(address)


@pytest.mark.skipif(not MAPPINGS.exists(), reason="this system does not list the memory of a process")
def test_an_address_without_code_is_an_error():
    """That of data, such as where ctypes stores the address of a function; and of a library that is not loaded."""
    function, array = OPERATION(lambda place, time: 0), np.zeros(3)
    with mmap.mmap(-1, mmap.PAGESIZE) as memory:
        unmapped = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for address in (ctypes.addressof(function), array.ctypes.data, unmapped):
        with pytest.raises(ValueError, match=f"{address:#x}, where no code is; .*c_void_p"):
            Foreign(address)


def test_a_code_that_is_no_status_is_an_error_in_distributions():
    function = OPERATION(lambda place, time: 42)

    class Wrong(CompiledSolver):
        def __init__(self, robot, options):
            super().__init__(robot, options, ctypes.cast(function, ctypes.c_void_p).value)

    robot = cdpr.load_robot("caroca")
    poses = np.repeat(robot.home[None], 3, axis=0)
    with pytest.raises(cdpr.PluginError, match="returned 42, which is no"):
        cdpr.distribute(robot, poses, solver=Wrong(robot, None))


@pytest.mark.parametrize(
    ("code", "value", "error"),
    [
        (42, 1.0, "the controller's compiled operation returned 42; expected 0"),
        (-(1 << 31), 1.0, "the controller's compiled operation returned -2147483648; expected 0"),
        (0, np.nan, "the controller wrote no wrench, or NaN"),
        (0, None, "the controller wrote no wrench, or NaN"),
    ],
)
def test_a_controller_that_fails_is_a_clear_error(code, value, error):
    def law(place, time):
        if value is not None:
            out[:] = value
        return code

    function, out = OPERATION(law), None

    class Law(Controller):
        def control(self, time, state, desired, out):
            out[:] = 0.0

        def compiled(self, state, desired, given):
            nonlocal out
            out = given
            return Foreign(ctypes.cast(function, ctypes.c_void_p).value, given)

    with pytest.raises(cdpr.PluginError, match=error):
        cdpr.simulate("caroca", controller=Law, overrides={"simulation.duration": 0.01})


@pytest.mark.parametrize(
    ("code", "value", "error"),
    [
        (5, 100.0, "returned 5, which is no"),
        (-1, 100.0, "returned -1, which is no"),
        (0, np.nan, "wrote no tensions, or NaN"),
        (0, None, "wrote no tensions, or NaN"),
    ],
)
def test_a_solver_that_fails_is_a_clear_error(code, value, error):
    def solve(place, time):
        words = ctypes.cast(place, ctypes.POINTER(ctypes.c_void_p))
        tension = ctypes.cast(words[4], ctypes.POINTER(ctypes.c_double))
        for i in range(8 if value is not None else 0):
            tension[i] = value
        return code

    function = OPERATION(solve)

    class Wrong(CompiledSolver):
        def __init__(self, robot, options):
            super().__init__(robot, options, ctypes.cast(function, ctypes.c_void_p).value)

    with pytest.raises(cdpr.PluginError, match=error):
        cdpr.simulate("caroca", solver=Wrong, overrides={"simulation.duration": 0.01})


def made_of(robot, name):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options({}))


class Slow(CompiledSolver):
    """Writes the wrench that it reads after a while into the first tension."""

    def __init__(self, robot, options):
        def solve(place, time):
            words = ctypes.cast(place, ctypes.POINTER(ctypes.c_void_p))
            wrench, tension = (ctypes.cast(words[i], ctypes.POINTER(ctypes.c_double)) for i in (1, 4))
            sleep(0.02)
            tension[0] = wrench[0]
            return 0

        self.function = OPERATION(solve)
        super().__init__(robot, options, ctypes.cast(self.function, ctypes.c_void_p).value)


def test_threads_that_solve_by_one_foreign_function_do_not_disturb_each_other():
    robot = cdpr.load_robot("caroca")
    solver, W = Slow(robot, None), np.zeros((robot.n, robot.m))

    def solve(number):
        tension = np.empty(robot.m)
        assert solver.solve(W, np.full(robot.n, number), tension.copy(), tension.copy(), tension) == 0
        return tension[0]

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(solve, range(8))) == list(range(8))


@pytest.mark.parametrize("solver", ["qp", "closed_form", "daqp"])
def test_an_answer_may_take_the_place_of_an_input(solver):
    robot = cdpr.load_robot("caroca")
    rng = np.random.default_rng(2)
    made = made_of(robot, solver)
    W, low, high = rng.normal(size=(6, 8)), np.full(8, 1.0), np.full(8, 90.0)
    wrench = W @ np.linspace(20.0, 60.0, 8)
    wanted = np.full(8, np.nan)
    assert made.solve(W, wrench, low, high, wanted) == 0
    for place in range(4):
        given = [W.copy(), wrench.copy(), low.copy(), high.copy()]
        tension = given[place].ravel()[:8] if place != 1 else None
        if place == 1:
            memory = np.concatenate([wrench, [0.0, 0.0]])
            given[1], tension = memory[:6], memory
        assert made.solve(*given, tension) == 0
        np.testing.assert_array_equal(tension, wanted)


@pytest.mark.parametrize("solver", ["qp", "daqp"])
def test_a_solver_rejects_arrays_that_are_not_of_real_numbers(solver):
    robot = cdpr.load_robot("caroca")
    made = made_of(robot, solver)
    W, wrench, low, high = np.ones((6, 8)), np.ones(6), np.ones(8), np.full(8, 9.0)
    for bad in (W + 1j, W.astype(object), np.ma.masked_equal(W, 1.0)):
        with pytest.raises(CdprError, match=r"^W: "):
            made.solve(bad, wrench, low, high, np.empty(8))
