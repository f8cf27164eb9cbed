"""Worker process for one FMU: it serves `cdpr.fmu.run.process` over a socket until that closes.

A message is one packet. Request: an operation, a number (int64), then the inputs (doubles), and JSON for `START` and
`TUNE`. Answer: `DONE`, a number (int64) and the outputs (doubles); or the name of an error and its text. Nothing is
pickled, so that hostile native code in this process can at most send wrong numbers.

The parent reads the FMU's output and log from the standard error stream.
"""

from __future__ import annotations

import dataclasses
import json
import os
import socket
import struct
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.processes import end_with
from cdpr.fmu.run.instance import Instance, Plan, Setting

HEAD = struct.Struct("=cq")
START, STEP, REFRESH, SAVE, RESTORE, FORGET, TUNE = (bytes([letter]) for letter in b"sgrkbft")
DONE, FAILED = b".", b"!"
MOST = 200_000  # bytes of a packet: what Linux sends at once


def encode(settings: Sequence[Setting]) -> bytes:
    """Return settings as JSON."""
    return json.dumps([dataclasses.astuple(setting) for setting in settings]).encode()


def decode(content: bytes) -> list[Setting]:
    """Return settings from JSON."""
    return [Setting(kind, reference, tuple(values)) for kind, reference, values in json.loads(content)]


def main(descriptor: int, parent: int, plan: dict[str, Any]) -> None:
    """Serve one FMU until the parent closes the socket; end with the parent, however that ends."""
    end_with(parent)
    with socket.socket(fileno=descriptor) as line:
        instance = _make_instance(line, plan)
        if instance is not None:
            _serve(line, instance)
    os._exit(0)  # threads or exit handlers of the FMU do not run


def _make_instance(line: socket.socket, plan: dict[str, Any]) -> Instance | None:
    try:
        from cdpr.fmu.run import slave  # loads FMPy

        variables = {name: tuple(map(tuple, plan[name])) for name in ("inputs", "outputs")}
        instance = slave.make(Plan(**plan | variables), hear=_write_line)
    except CdprError as error:
        line.send(_failure(error))
        return None
    line.send(HEAD.pack(DONE, 0) + instance.outputs.tobytes())
    return instance


def _serve(line: socket.socket, instance: Instance) -> None:
    """Answer requests until the socket closes."""
    request = bytearray(MOST)
    answer = bytearray(HEAD.size + instance.outputs.nbytes)
    inputs, outputs = instance.inputs.view(np.uint8), instance.outputs.view(np.uint8)
    rest = HEAD.size + inputs.size
    given, reply = np.frombuffer(request, np.uint8)[HEAD.size : rest], np.frombuffer(answer, np.uint8)[HEAD.size :]
    operations: dict[bytes, Callable[[int], int | None]] = {
        STEP: instance.step,
        REFRESH: lambda _: instance.refresh(),
        SAVE: lambda _: instance.save(),
        RESTORE: instance.restore,
        FORGET: instance.forget,
    }
    while size := line.recv_into(request):
        operation, number = HEAD.unpack_from(request)
        inputs[:] = given
        try:
            result = None
            if operation == START:
                instance.start(decode(bytes(request[rest:size])))
            elif operation == TUNE:
                instance.tune(decode(bytes(request[rest:size])))
            else:
                result = operations[operation](number)
        except CdprError as error:
            line.send(_failure(error))
            continue
        HEAD.pack_into(answer, 0, DONE, result or 0)
        reply[:] = outputs
        line.send(answer)
    instance.close()


def _failure(error: CdprError) -> bytes:
    return FAILED + json.dumps([type(error).__name__, str(error)]).encode()[: MOST - 1]


def _write_line(line: str) -> None:
    os.write(sys.stderr.fileno(), f"{line}\n".encode())
