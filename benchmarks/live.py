"""Cost of a live link: a live run with one client, and with none, beside the same run without a link."""

from __future__ import annotations

import json
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial
from pathlib import Path
from time import monotonic, perf_counter, sleep
from typing import Any

import numpy as np
import zenoh
from websockets.sync.client import connect
from websockets.typing import Subprotocol

import cdpr
from cdpr.base.errors import Interrupted
from cdpr.log.header import Header
from cdpr.log.ros2 import decode
from cdpr.model.robot import Array
from cdpr.simulation.requests import Request
from cdpr.ui.live.drive import LiveDriver
from cdpr.ui.live.foxglove import Foxglove
from cdpr.ui.live.ros2 import Ros2
from cdpr.ui.live.sender import Sender

FILE = Path(__file__).parent.parent / "scenarios" / "caroca.yaml"
FULL = 1e6  # times real time: as fast as it goes
TURN = 0.25  # s: long beside a message, short beside what else this machine does
TURNS = 60  # of each way
FASTEST = 5  # turns of a way that count: the others met what else this machine does
SECONDS = 3.0  # in which all samples of 1 kHz are to arrive
LAST = "/cdpr/desired_path"  # the topic that is offered last


class Nobody(Foxglove):
    """Link without output and input."""

    def begin(self, header: Header) -> None:
        """Do nothing."""

    def show(self, row: object, sample: int, header: Header) -> None:
        """Do nothing."""


# The other side, in a process of its own: it answers each word of its input by how many messages came and how many
# different times of /clock.
Count = list[int]


def foxglove_client(where: str, count: Count, times: set[int]) -> Callable[[str], None]:
    """Listen to a WebSocket; return what a word does."""
    topics = dict[int, str]()
    link = connect(where, subprotocols=[Subprotocol("foxglove.sdk.v1")], max_size=None)

    def listen() -> None:
        for data in link:
            if isinstance(data, str):
                said = json.loads(data)
                if said["op"] == "advertise":
                    topics.update({one["id"]: one["topic"] for one in said["channels"]})
            elif data[0] == 1:
                channel, time = struct.unpack("<IQ", data[1:13])
                count[0] += 1
                if topics[channel] == "/clock":
                    times.add(time)

    def obey(word: str) -> None:
        while LAST not in topics.values():
            sleep(0.01)
        if word == "on":
            said: dict[str, Any] = {"op": "subscribe", "subscriptions": [{"id": k, "channelId": k} for k in topics]}
            link.send(json.dumps(said))
        elif word == "off":
            link.send(json.dumps({"op": "unsubscribe", "subscriptionIds": list(topics)}))

    threading.Thread(target=listen, daemon=True).start()
    return obey


def ros2_client(where: str, count: Count, times: set[int]) -> Callable[[str], None]:
    """Listen to all topics of a ROS 2 node; return what a word does."""
    session, held = opened("peer", "tcp/127.0.0.1:0", where), list[Any]()

    def hear(sample: zenoh.Sample) -> None:
        count[0] += 1
        if str(sample.key_expr).startswith("0/clock/"):
            clock = decode("rosgraph_msgs/Clock", sample.payload.to_bytes())["clock"]
            times.add(clock["sec"] * 10**9 + clock["nanosec"])

    def obey(word: str) -> None:
        if word == "on":
            held.append(session.declare_subscriber("0/**", hear))
        elif word == "off":
            held.pop().undeclare()

    return obey


def opened(mode: str, listen: str, meet: str = "") -> zenoh.Session:
    """Return a Zenoh session of this machine."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("listen/endpoints", json.dumps([listen]))
    config.insert_json5("connect/endpoints", json.dumps([meet] if meet else []))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


CLIENTS = {"foxglove": foxglove_client, "ros2": ros2_client}


def client(tool: str, where: str) -> None:
    """Be the other side."""
    count, times = [0], set[int]()
    if tool == "router":
        held = opened("router", where)
        print(held.zid(), flush=True)
        sys.stdin.read()
        return
    obey = CLIENTS[tool](where, count, times)
    for line in sys.stdin:
        obey(line.strip())
        print(json.dumps([count[0], len(times)]), flush=True)


class Other:
    """That process."""

    def __init__(self, tool: str, where: str) -> None:
        words = [sys.executable, __file__, "--client", tool, where]
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def say(self, word: str) -> list[int]:
        """Send a word, and return the answer."""
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()
        return list(json.loads(self._process.stdout.readline()))

    def wait(self) -> None:
        """Wait for an unsolicited message."""
        assert self._process.stdout
        self._process.stdout.readline()

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.communicate()


@contextmanager
def met(tool: str) -> Iterator[tuple[Sender, Other]]:
    """A link, and somebody who will listen to it."""
    with ExitStack() as stack:
        if tool == "ros2":
            with socket.socket() as free:
                free.bind(("127.0.0.1", 0))
                port = free.getsockname()[1]
            where = f"tcp/127.0.0.1:{port}"
            stack.enter_context(closing(router := Other("router", where)))
            router.wait()
            link: Sender = stack.enter_context(closing(Ros2(port=port)))
        else:
            found = stack.enter_context(closing(Foxglove(port=0)))
            link, where = found, found.url
        yield link, stack.enter_context(closing(Other(tool, where)))


def driven(link: Sender, duration: float, speed: float, rate: float, **overrides: object) -> LiveDriver:
    """Return a driver that is not begun."""
    scenario = cdpr.load_scenario(FILE, overrides={"simulation.duration": duration, **overrides})
    return LiveDriver(scenario, None, link, speed, rate)


def rates(link: Sender, begin: Callable[[], object], count: int) -> list[float]:
    """Samples a second of the wall clock, of this many turns of a run; the first after `begin` is not counted."""
    found, since = list[float](), list[tuple[float, int]]()

    def look(done: int, total: int) -> None:
        now = perf_counter()
        if not since:
            begin()
        elif now < since[-1][0] + TURN:
            return
        elif len(since) > 1:
            found.append((done - since[-1][1]) / (now - since[-1][0]))
        since.append((perf_counter(), done))
        if len(found) == count:
            raise Interrupted

    with suppress(Interrupted):
        driven(link, 1e5, FULL, 60.0, **{"log.step": 1.0}).run(look)
    return found


def ratios(tool: str) -> dict[str, float]:
    """Return how much slower it is, relative to the run that nobody can watch."""
    found: dict[str, list[float]] = {"unwatched": [], "no client": [], "one client": []}
    with closing(Nobody(port=0)) as nobody:
        rates(nobody, lambda: None, 2)  # what a first run loads
        for _ in range(TURNS // 4):
            found["unwatched"] += rates(nobody, lambda: None, 4)
            for name, word in (("no client", "wait"), ("one client", "on")):
                with met(tool) as (link, other):
                    found[name] += rates(link, partial(other.say, word), 4)
    best = {name: float(np.mean(sorted(values)[-FASTEST:])) for name, values in found.items()}
    return {f"time, {name} / unwatched": best["unwatched"] / best[name] for name in ("no client", "one client")}


def arrived(tool: str) -> dict[str, float]:
    """Return how many samples come at 1 kHz in real time."""
    with met(tool) as (link, other):
        made = driven(link, SECONDS, 1.0, 1000.0)
        made.request_pause()
        shown, show = set[int](), link.show

        def kept(row: Array, sample: int) -> None:
            shown.add(sample)
            show(row, sample)

        link.show = kept  # type: ignore[method-assign]

        def resume() -> None:
            other.say("on")
            sleep(0.5)  # until it is found
            link.requests.put(Request("pause", {"paused": False}))

        threading.Thread(target=resume, daemon=True).start()
        made.run()
        sleep(1.0)
        return {"samples shown at 1 kHz": float(len(shown)), "and arrived": float(other.say("tell")[1])}


def memory() -> float:
    """MiB that this process holds."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


def grows(tool: str, minutes: float) -> dict[str, float]:
    """MiB after a tenth of the time, and at the end."""
    held, until = list[float](), monotonic() + 6.0 * minutes
    with met(tool) as (link, other):
        listens = threading.Timer(1.0, other.say, ["on"])
        listens.start()

        def look(done: int, total: int) -> None:
            if not held and monotonic() > until:
                held.append(memory())

        driven(link, 60.0 * minutes, 1.0, 60.0, **{"log.step": 0.1}).run(look)
        count = other.say("tell")[0]
    told = {"minutes": minutes, "messages": float(count)}
    return told | {"MiB after a tenth": held[0], "MiB at the end": memory()}


def main(words: list[str]) -> None:
    """Measure, and print."""
    tools = [word for word in words if word in CLIENTS] or list(CLIENTS)
    table = dict[str, float]()
    for tool in tools:
        found = ratios(tool) | arrived(tool)
        if "--minutes" in words:
            found |= grows(tool, float(words[words.index("--minutes") + 1]))
        table |= {f"{tool}: {name}": value for name, value in found.items()}
    if "--json" in words:
        print(json.dumps(table, indent=1))
    else:
        for name, value in table.items():
            print(f"{name:<45}{value:.4g}")


if __name__ == "__main__":
    if "--client" in sys.argv:
        client(sys.argv[2], sys.argv[3])
    else:
        main(sys.argv[1:])
