"""FMU in this process: the only module that uses FMPy, for its declarations of the FMI functions.

FMPy's own classes require all 75 functions of FMI 3, create objects in each call and keep a pointer to freed memory.
This module binds only the functions in use, with the signatures of FMPy, and a step allocates no array.
"""

from __future__ import annotations

import ctypes
import inspect
import typing
from abc import abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path
from types import UnionType
from typing import Any, NoReturn
from weakref import WeakValueDictionary

from fmpy import calloc, fmi2, fmi3, free, freeLibrary
from fmpy.logging import addLoggerProxy

from cdpr.base.errors import BackendDied, FmuError, PlantEnded
from cdpr.fmu.run.folder import Folder
from cdpr.fmu.run.instance import Instance, Plan, Setting

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
WARNING, DISCARD, FATAL = 1, 2, 4
TERMINATED = 3  # of fmi2StatusKind

TIME_TOLERANCE = 1e-9  # relative to the time, at least to 1 s: an FMU may add up its steps

LINES = 5  # kept messages of the log
LINE = 300  # kept characters of one message

NEEDED = ("FreeInstance", "EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "DoStep")


def make(plan: Plan, folder: Folder | None = None, hear: Callable[[str], None] | None = None) -> Slave:
    """Load the library of an extracted FMU and make an instance.

    It owns `folder`, if given; `hear` receives each line that the FMU logs, instead of the attribute `log`.
    """
    return (Slave3 if plan.fmi == "3.0" else Slave2)(plan, folder, hear)


class Slave(Instance):
    """Base class for both versions of the standard; `make` chooses the class.

    Attributes:
        log: last lines that the FMU logged.
    """

    declared: type  # module of FMPy with the functions
    prefix: str
    real: str
    needed: tuple[str, ...]
    kinds: tuple[str, ...]
    other: tuple[str, ...] = ()
    integers: str  # type of enumerations
    state: str  # name of FMUState in the standard

    def __init__(self, plan: Plan, folder: Folder | None, hear: Callable[[str], None] | None) -> None:
        super().__init__(plan, folder)
        self.log: deque[str] = deque(maxlen=LINES)
        self.hear = self.log.append if hear is None else hear
        self._instance: ctypes.c_void_p | None = None
        self._library: Any = None
        self._started = self._running = self._fatal = False
        self._kept: dict[int, tuple[ctypes.c_void_p, int]] = {}  # states and their steps
        self._numbers = count(1)
        self._environment = next(_environments)
        if plan.alone and any(other.plan.token == plan.token for other in _open.values()):
            self._refuse("can be used only once in a process; choose isolation: process")
        try:
            self._library = ctypes.CDLL(plan.library)
        except OSError as error:
            self._refuse(f"has a library that cannot be loaded: {error}")
        self._functions = self._bind()
        _open[self._environment] = self
        pointer = self._instantiate()
        if not pointer:
            self.close()
            self._refuse(f"could not be instantiated{self.last_words}")
        self._instance = ctypes.c_void_p(pointer)
        self._write = self._transfer("Set", plan.inputs, self.inputs)
        self._read = self._transfer("Get", plan.outputs, self.outputs)

    @property
    def last_words(self) -> str:
        """Return the last lines of the log, to append to a message."""
        return f"; it logged: {' | '.join(self.log)}" if self.log else ""

    def start(self, settings: Sequence[Setting]) -> None:
        """Initialise at time zero with these start values and the present inputs."""
        if self._started:
            self._call("Reset")
        self.steps, self._started = 0, True
        for setting in settings:
            self._set(setting)
        self._initialize()
        self._write()
        self._call("ExitInitializationMode")
        self._running = True
        self._read()

    def step(self, n: int) -> None:
        """Advance by n communication steps."""
        self._check_running()
        self._write()
        for _ in range(n):
            self._advance(self.time)
            self.steps += 1
        self._read()

    def refresh(self) -> None:
        """Read the outputs for the present inputs without a step."""
        self._check_running()
        self._write()
        self._read()

    def tune(self, settings: Sequence[Setting]) -> None:
        """Change tunable parameters between two steps, and read the outputs."""
        self._check_running()
        for setting in settings:
            self._set(setting)
        self._read()

    def save(self) -> int:
        """Save the present state and return its number."""
        state, number = ctypes.c_void_p(), next(self._numbers)
        self._call(f"Get{self.state}", ctypes.byref(state))
        self._kept[number] = state, self.steps
        return number

    def restore(self, number: int) -> None:
        """Restore a saved state; `inputs` do not change."""
        state, steps = self._kept[number]
        self._call(f"Set{self.state}", state)
        self.steps = steps
        self._read()

    def forget(self, number: int) -> None:
        """Free a saved state."""
        state, _ = self._kept.pop(number)
        self._call(f"Free{self.state}", ctypes.byref(state))

    def end(self) -> None:
        """Free instance and library; may be called again. After Fatal no function of the FMU is called any more."""
        library, self._library = self._library, None
        instance, self._instance = self._instance, None
        running, self._running = self._running, False
        if library is None or self._fatal:
            return
        functions, self._functions = self._functions, {}
        if instance is not None:
            for state, _ in self._kept.values():
                functions[f"Free{self.state}"](instance, ctypes.byref(state))
            if running:
                functions["Terminate"](instance)
            functions["FreeInstance"](instance)
        _open.pop(self._environment, None)
        freeLibrary(library._handle)

    @abstractmethod
    def _instantiate(self) -> int | None:
        """Return the pointer to a new instance, None if the FMU makes none."""

    @abstractmethod
    def _initialize(self) -> None:
        """Enter initialization mode at time zero."""

    @abstractmethod
    def _advance(self, time: float) -> None:
        """Do one communication step from `time`, s."""

    def _set(self, setting: Setting) -> None:
        name = f"Set{self.integers if setting.kind == 'Enumeration' else setting.kind}"
        if name not in self._functions:
            self._refuse(f"has a parameter of type {setting.kind}, which cannot be set: {self.prefix}{name} is missing")
        item = self._functions[name].argtypes[3]._type_
        values = [value.encode() if isinstance(value, str) else value for value in setting.values]
        reference = (ctypes.c_uint * 1)(setting.reference)
        self._call(name, reference, 1, (item * len(values))(*values), *self._sizes(len(values)))

    def _bind(self) -> dict[str, Any]:
        """Return the functions of the library, with the types that FMPy declares."""
        states = tuple(f"{verb}{self.state}" for verb in ("Get", "Set", "Free")) if self.plan.saves else ()
        needed = (*NEEDED, *self.needed, f"Get{self.real}", f"Set{self.real}", *states)
        functions, missing = {}, []
        for name in (*needed, *(f"Set{kind}" for kind in self.kinds), *self.other):
            try:
                function = getattr(self._library, self.prefix + name)
            except AttributeError:
                if name in needed:
                    missing.append(self.prefix + name)
                continue
            function.argtypes, function.restype = signature(self.declared, self.prefix + name)
            functions[name] = function
        if missing:
            self._refuse(f"has a library without {', '.join(missing)}, which FMI requires for co-simulation")
        return functions

    def _transfer(self, verb: str, variables: Sequence[tuple[int, int]], values: Any) -> Any:
        """Return a function that sets or gets the variables, all in one call."""
        references = (ctypes.c_uint * len(variables))(*(reference for reference, _ in variables))
        buffer = values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        arguments = (self._instance, references, len(variables), buffer, *self._sizes(len(values)))
        function, name = self._functions[verb + self.real], verb + self.real

        def transfer() -> None:
            status = function(*arguments)
            if status > WARNING:
                self._fail(name, status)

        return transfer if variables else lambda: None

    def _sizes(self, size: int) -> tuple[int, ...]:
        """Return the arguments after the values: their number, in FMI 3."""
        return ()

    def _check_running(self) -> None:
        if not self._running:
            raise BackendDied(f"FMU '{self.plan.name}' has ended; only a reset restarts it")

    def _call(self, name: str, *arguments: Any) -> None:
        if self._fatal or self._instance is None:
            raise BackendDied(f"FMU '{self.plan.name}' is closed or failed; it cannot be called again")
        status = self._functions[name](self._instance, *arguments)
        if status > WARNING:
            self._fail(name, status)

    def _fail(self, name: str, status: int) -> NoReturn:
        self._running, self._fatal = False, self._fatal or status == FATAL
        what = STATUS[status] if 0 <= status < len(STATUS) else str(status)
        raise BackendDied(f"FMU '{self.plan.name}': {self.prefix}{name} returned {what}{self.last_words}")

    def _refuse(self, text: str) -> NoReturn:
        raise FmuError(f"FMU '{self.plan.name}' {text}")

    def _end(self) -> NoReturn:
        self._running = False
        raise PlantEnded(f"FMU '{self.plan.name}' requested the end of the simulation{self.last_words}")


class Slave2(Slave):
    """Instance of FMI 2.0."""

    declared = fmi2.FMU2Slave
    prefix, real, integers, state = "fmi2", "Real", "Integer", "FMUstate"
    needed = ("Instantiate", "SetupExperiment")
    kinds = ("Integer", "Boolean", "String")
    other = ("GetBooleanStatus",)

    def _instantiate(self) -> int | None:
        self._callbacks = callbacks = fmi2.fmi2CallbackFunctions()  # the FMU keeps its address
        callbacks.logger = _heard_2
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        callbacks.componentEnvironment = self._environment
        addLoggerProxy(ctypes.byref(callbacks))  # it formats messages, with arguments that ctypes does not support
        name, token = self.plan.name.encode(), self.plan.token.encode()
        uri = Path(self.plan.resources).as_uri().encode()
        pointer: int | None = self._functions["Instantiate"](
            name, fmi2.fmi2CoSimulation, token, uri, ctypes.byref(callbacks), False, True
        )
        return pointer

    def _initialize(self) -> None:
        self._call("SetupExperiment", False, 0.0, 0.0, False, 0.0)
        self._call("EnterInitializationMode")

    def _advance(self, time: float) -> None:
        status = self._functions["DoStep"](self._instance, time, self.plan.step, not self.plan.saves)
        if status > WARNING:
            if status == DISCARD and self._terminated():
                self._end()
            self._fail("DoStep", status)

    def _terminated(self) -> bool:
        answer = ctypes.c_int(0)
        function = self._functions.get("GetBooleanStatus")
        known = function is not None and function(self._instance, TERMINATED, ctypes.byref(answer)) <= WARNING
        return known and bool(answer.value)


class Slave3(Slave):
    """Instance of FMI 3.0, without event mode and early return: steps are equidistant, as controllers require."""

    declared = fmi3.FMU3Slave
    prefix, real, integers, state = "fmi3", "Float64", "Int64", "FMUState"
    needed = ("InstantiateCoSimulation",)
    kinds = ("Float32", *(f"{u}Int{n}" for n in (8, 16, 32, 64) for u in ("", "U")), "Boolean", "String")

    def _instantiate(self) -> int | None:
        self._event, self._terminate, self._early = ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()
        self._reached = ctypes.c_double()
        flags = (self._event, self._terminate, self._early, self._reached)
        self._answers = (not self.plan.saves, *(ctypes.byref(flag) for flag in flags))
        name, token = self.plan.name.encode(), self.plan.token.encode()
        resources = f"{self.plan.resources}/".encode()
        no_update = fmi3.fmi3IntermediateUpdateCallback()
        pointer: int | None = self._functions["InstantiateCoSimulation"](
            name, token, resources, False, True, False, False, None, 0, self._environment, _heard_3, no_update
        )
        return pointer

    def _initialize(self) -> None:
        self._call("EnterInitializationMode", False, 0.0, 0.0, False, 0.0)

    def _advance(self, time: float) -> None:
        step = self.plan.step
        status = self._functions["DoStep"](self._instance, time, step, *self._answers)
        if status > WARNING:
            self._fail("DoStep", status)
        if self._terminate.value:
            self._end()
        end, reached = time + step, self._reached.value
        if not abs(reached - end) <= TIME_TOLERANCE * max(1.0, end):
            self._running = False
            raise BackendDied(
                f"FMU '{self.plan.name}' was to go to {end:.9g} s, but reports {reached:.9g} s: its own step "
                f"does not divide the communication step of {step:g} s{self.last_words}"
            )

    def _sizes(self, size: int) -> tuple[int, ...]:
        return (size,)


def signature(declared: type, name: str) -> tuple[list[Any], Any]:
    """Return the types of the arguments and of the result of an FMI function, as FMPy declares them."""
    function = inspect.signature(getattr(declared, name))
    kinds = [parameter.annotation for parameter in list(function.parameters.values())[1:]]  # without self
    arguments = [typing.get_args(kind)[0] if isinstance(kind, UnionType) else kind for kind in kinds]
    result = function.return_annotation
    return arguments, ctypes.c_int if result is int else result


def _store_message(environment: int | None, status: int, message: bytes | None) -> None:
    """Store a message; called by an FMU, from any thread and at any time."""
    slave = _open.get(environment or 0)
    if slave is not None:
        text = " ".join((message or b"")[:LINE].decode(errors="replace").split())
        slave.hear(f"{STATUS[status]}: {text}" if WARNING <= status < len(STATUS) else text)


# One callback for all FMUs, identified by their environment: FMPy's proxy keeps a single logger, that of the last FMU.
_heard_2 = fmi2.fmi2CallbackLoggerTYPE(lambda e, name, status, category, message: _store_message(e, status, message))
_heard_3 = fmi3.fmi3LogMessageCallback(lambda e, status, category, message: _store_message(e, status, message))
_open: WeakValueDictionary[int, Slave] = WeakValueDictionary()
_environments = count(1)
