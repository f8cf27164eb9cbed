"""Processes that the system refuses to start."""

from __future__ import annotations

import errno
import subprocess
from threading import Thread

import pytest

from cdpr.base import processes
from cdpr.base.errors import CdprError


def no_resources():
    raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: subprocess.Popen(["/no/such/program"]), "'/no/such/program': No such file or directory"),
        (no_resources, "Resource temporarily unavailable; close other programs, or raise `ulimit -u` and `ulimit -n`"),
    ],
)
def test_a_refused_process_is_reported(call, text):
    errors = []

    def begin():
        with pytest.raises(CdprError) as caught:
            processes.start(call)
        errors.append(str(caught.value))

    begin()
    other = Thread(target=begin)
    other.start()
    other.join()
    assert errors == [f"cannot start a process: {text}"] * 2
