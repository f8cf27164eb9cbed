"""A client of the WebSocket protocol that Foxglove speaks, as far as tests need it."""

from __future__ import annotations

import json
import socket
import struct
import threading
from contextlib import closing, contextmanager

from conftest import ROOT
from websockets.sync.client import connect

import cdpr
from cdpr.base.errors import CdprError
from cdpr.simulation.requests import Request
from cdpr.ui.live.drive import drive

TEXT_TIMEOUT = 20.0  # s, that a test waits for anything
RUN_TIMEOUT = 60.0  # s, that a test waits for the end of a run
FILE = ROOT / "scenarios" / "caroca.yaml"


@contextmanager
def running(make, duration=2.0, out=None, speed=1.0, held=False, file=FILE, **overrides):
    """Return a link for `say` and `parameters`, its run or exception, and the messages.

    If `held`, it has started and is paused.
    """
    scenario = cdpr.load_scenario(file, overrides={"simulation.duration": duration, **overrides})
    found, said = {}, []
    with closing(make(say=said.append, parameters=scenario.options().numbers())) as link:
        pause = Request("pause", {})
        if held:
            link.requests.put(pause)

        def work():
            try:
                found["run"] = drive(scenario, link, out=out, speed=speed)
            except CdprError as error:
                found["error"] = error

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        try:
            assert not held or pause.done.wait(RUN_TIMEOUT)
            yield link, found, said
        finally:
            for _ in range(10):  # whatever failed, and also if a client's last message pauses again
                link.requests.put(Request("pause", {"paused": False}))
                thread.join(0.1 * RUN_TIMEOUT)
                if not thread.is_alive():
                    break
            assert not thread.is_alive()


class Client:
    """One connection: what came, by its kind."""

    def __init__(self, socket):
        self.socket, self.channels, self.services, self.statuses = socket, {}, {}, []
        self.messages, self.parameters, self.replies, self._call = [], {}, {}, 0

    def hear(self, timeout=TEXT_TIMEOUT):
        """Take one message."""
        data = self.socket.recv(timeout=timeout)
        if isinstance(data, bytes):
            if data[0] == 1:
                channel, time = struct.unpack("<IQ", data[1:13])
                self.messages.append((self.channels.get(channel, channel), time, data[13:]))
            elif data[0] == 3:
                _, call, length = struct.unpack("<III", data[1:13])
                self.replies[call] = json.loads(data[13 + length :])
            return
        said = json.loads(data)
        if said["op"] == "advertise":
            self.channels |= {one["id"]: one["topic"] for one in said["channels"]}
        elif said["op"] == "advertiseServices":
            self.services |= {one["name"]: one["id"] for one in said["services"]}
        elif said["op"] == "status":
            self.statuses.append(said["message"])
        elif said["op"] == "parameterValues":
            self.parameters |= {one["name"]: one.get("value") for one in said["parameters"]}

    def until(self, found):
        """Receive until a condition is true."""
        while not found():
            self.hear()

    def say(self, **message):
        self.socket.send(json.dumps(message))

    def subscribe(self, *topics):
        self.until(lambda: set(topics) <= set(self.channels.values()))
        chosen = [number for number, topic in self.channels.items() if topic in topics]
        self.say(op="subscribe", subscriptions=[{"id": number, "channelId": number} for number in chosen])

    def more(self, topic, count=3):
        """Receive this number of further messages of a topic."""
        wanted = count + sum(each[0] == topic for each in self.messages)
        self.until(lambda: sum(each[0] == topic for each in self.messages) >= wanted)

    def publish(self, topic, content, encoding="json"):
        number = 1 + hash(topic) % 1000
        channel = {"id": number, "topic": topic, "encoding": encoding, "schemaName": "any"}
        self.say(op="advertise", channels=[channel])
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.socket.send(b"\x01" + struct.pack("<I", number) + body)
        self.say(op="unadvertise", channelIds=[number])

    def call(self, name):
        """Call a service, and return its answer."""
        self.until(lambda: name in self.services)
        self._call += 1
        call = self._call
        self.socket.send(b"\x02" + struct.pack("<III", self.services[name], call, 4) + b"json" + b"{}")
        self.until(lambda: call in self.replies)
        return self.replies[call]

    def set(self, name, value):
        self.say(op="setParameters", parameters=[{"name": name, "value": value}], id=name)


def socket_to(port):
    return socket.create_connection(("127.0.0.1", port), timeout=TEXT_TIMEOUT)


@contextmanager
def client(link, subprotocol="foxglove.sdk.v1"):
    with connect(link.url, subprotocols=[subprotocol], max_size=None, close_timeout=0.2) as opened:
        yield Client(opened)
