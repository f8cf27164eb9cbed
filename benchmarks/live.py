"""What it costs to be watched: a live run with one client, and with none, beside the same run unwatched.

1 kHz physics, 60 Hz out, every topic, as fast as it goes and by turns in one process; CPU of the thread that simulates,
and of the process. Then messages of 1 kHz that arrive. With --minutes N, whether memory grows meanwhile.
Run: python benchmarks/live.py [--json] [--minutes N].
"""

from __future__ import annotations

import json
import struct
import sys
import threading
from contextlib import closing
from pathlib import Path
from time import monotonic, sleep, thread_time

from websockets.sync.client import connect

import cdpr
from cdpr.live.drive import Driven, Request
from cdpr.live.foxglove import Foxglove
from cdpr.log.run import Header

FILE = Path(__file__).parent.parent / "scenarios" / "caroca.yaml"
DURATION = 20.0  # s simulated
SPEED = 20.0  # times real time
ROUNDS = 8


class Nobody(Foxglove):
    """What neither shows nor hears."""

    def begin(self, header: Header) -> None:
        """Do nothing."""

    def show(self, row: object, sample: int) -> None:
        """Do nothing."""


def listen(port: int, received: list[int], ready: threading.Event) -> None:
    """Subscribe to all, and count messages."""
    with connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
        for data in socket:
            if isinstance(data, bytes):
                received.append(struct.unpack("<Q", data[5:13])[0] if data[0] == 1 else 0)
            elif (said := json.loads(data))["op"] == "advertise":
                chosen = [{"id": one["id"], "channelId": one["id"]} for one in said["channels"]]
                socket.send(json.dumps({"op": "subscribe", "subscriptions": chosen}))
                ready.set()


def cost(kind: type[Foxglove], client: bool) -> tuple[float, int]:
    """CPU s of the thread that simulates, and how many messages came."""
    received, ready = list[int](), threading.Event()
    with closing(kind(port=0)) as link:
        if client:
            threading.Thread(target=listen, args=(link.port, received, ready), daemon=True).start()
        else:
            ready.set()
        begun = watched(link, ready, DURATION, SPEED, 60.0)
        return thread_time() - begun, len(received)


def watched(link: Foxglove, ready: threading.Event, duration: float, speed: float, rate: float) -> float:
    """Run, once somebody is ready; return the CPU time of this thread when it began, s."""
    scenario = cdpr.load_scenario(FILE, overrides={"simulation.duration": duration})
    made = Driven(scenario, None, link, speed, rate)
    made.ask_pause()

    def resume() -> None:
        ready.wait()
        sleep(0.1)  # until the server has heard of it
        link.requests.put(Request("pause", {"paused": False}))

    threading.Thread(target=resume, daemon=True).start()
    begun = thread_time()
    made.drive(lambda done, total: None)
    return begun


def memory() -> float:
    """MiB that this process holds."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


def grows(minutes: float) -> dict[str, float]:
    """MiB after a tenth of the time, and at the end."""
    scenario = cdpr.load_scenario(FILE, overrides={"simulation.duration": 60.0 * minutes, "log.step": 0.1})
    received: list[int] = []
    held: list[float] = []
    with closing(Foxglove(port=0)) as link:
        threading.Thread(target=listen, args=(link.port, received, threading.Event()), daemon=True).start()
        until = monotonic() + 6.0 * minutes

        def look(done: int, total: int) -> None:
            received.clear()
            if not held and monotonic() > until:
                held.append(memory())

        Driven(scenario, None, link, 1.0, 60.0).drive(look)
    return {"minutes": minutes, "after a tenth, MiB": held[0] if held else memory(), "at the end, MiB": memory()}


WAYS: dict[str, tuple[type[Foxglove], bool]] = {
    "unwatched": (Nobody, False),
    "no client": (Foxglove, False),
    "one client": (Foxglove, True),
}


def measured() -> dict[str, float]:
    """Return all ratios."""
    least, count = dict.fromkeys(WAYS, 1e9), 0
    cost(Foxglove, True)  # what a first run loads
    for _ in range(ROUNDS):
        for name, (kind, client) in WAYS.items():
            seconds, count = cost(kind, client)
            least[name] = min(least[name], seconds)
    found = {f"{name} / unwatched": least[name] / least["unwatched"] for name in ("no client", "one client")}
    everything = [stamp for stamp in arrived(1000.0) if stamp % 10**6 == 0]
    return found | {"messages of one client": float(count), "of 3000 at 1 kHz": float(len(set(everything)))}


def arrived(rate: float) -> list[int]:
    """Times, ns, of the messages that come of 3 s in real time at this rate."""
    received, ready = list[int](), threading.Event()
    with closing(Foxglove(port=0)) as link:
        threading.Thread(target=listen, args=(link.port, received, ready), daemon=True).start()
        watched(link, ready, 3.0, 1.0, rate)
        sleep(0.5)
    return received


if __name__ == "__main__":
    table = measured()
    if "--minutes" in sys.argv:
        table |= grows(float(sys.argv[sys.argv.index("--minutes") + 1]))
    if "--json" in sys.argv[1:]:
        print(json.dumps(table, indent=1))
    else:
        for name, value in table.items():
            print(f"{name:<28}{value:.4g}")
