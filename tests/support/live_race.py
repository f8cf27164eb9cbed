"""Clients that subscribe to parameters without end, while these change: ends after a second, or hangs for good."""

from __future__ import annotations

import sys
from contextlib import closing
from threading import Event, Thread
from time import monotonic

from live_client import client

from cdpr.ui.live.foxglove import Foxglove

SECONDS = float(sys.argv[1])


def subscribe(link, over):
    with client(link) as seen:
        while not over.is_set():
            for op in ("subscribeParameterUpdates", "unsubscribeParameterUpdates"):
                seen.say(op=op, parameterNames=["paused"])


over, end, changes = Event(), monotonic() + SECONDS, 0
with closing(Foxglove(port=0)) as link:
    threads = [Thread(target=subscribe, args=(link, over)) for _ in range(2)]
    for thread in threads:
        thread.start()
    while monotonic() < end:
        changes += 1
        link.changed({"paused": changes % 2 == 0})
    over.set()
    for thread in threads:
        thread.join()
print(changes)
