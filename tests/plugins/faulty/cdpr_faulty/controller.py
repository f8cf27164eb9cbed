"""Computed torque that raises, hangs, crashes, exits or is killed."""

import ctypes
import os
import signal
import sys
import time
from pathlib import Path

from cdpr_controllers.computed_torque import ComputedTorque


class Faulty(ComputedTorque):
    """Sound but for one call."""

    calls = 0

    def control(self, now, state, desired, wrench):
        """The wrench of computed torque, or worse."""
        self.calls += 1
        if self.calls == self.options.at and self.options.fault != "none":
            self._break()
        super().control(now, state, desired, wrench)

    def _break(self):
        if self.options.once:
            marker = Path(self.options.once)
            if marker.exists():
                return
            marker.touch()
        match self.options.fault:
            case "raise":
                raise RuntimeError("no law")
            case "hang":
                while True:
                    time.sleep(1.0)
            case "crash":
                os.write(2, b"the engine says goodbye\n")
                ctypes.string_at(0)
            case "exit":
                os._exit(7)
            case "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            case "chatter":  # as engines do, past Python, and more than a pipe holds
                for _ in range(1000):
                    os.write(1, b"\x80\x04 not an answer\n" * 20)
                print("nor this", file=sys.stderr)
