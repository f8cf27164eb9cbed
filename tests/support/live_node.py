"""A ROS 2 node over Zenoh, as far as tests need it; what is tested makes none of its keys, hashes and bytes."""

from __future__ import annotations

import json
import socket
import struct
import threading
import time
from contextlib import contextmanager

import zenoh
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TYPES = get_typestore(Stores.ROS2_JAZZY)
R = "rcl_interfaces/msg"
REQUESTS = {  # and answers, of the services that each node has
    "get_parameters": ("string[] names", f"{R}/ParameterValue[] values"),
    "get_parameter_types": ("string[] names", "uint8[] types"),
    "describe_parameters": ("string[] names", f"{R}/ParameterDescriptor[] descriptors"),
    "list_parameters": ("string[] prefixes\nuint64 depth", f"{R}/ListParametersResult result"),
    "set_parameters": (f"{R}/Parameter[] parameters", f"{R}/SetParametersResult[] results"),
    "set_parameters_atomically": (f"{R}/Parameter[] parameters", f"{R}/SetParametersResult result"),
}
for _name, _texts in REQUESTS.items():
    for _part, _text in zip(("request", "response"), _texts, strict=True):
        TYPES.register(get_types_from_msg(_text, f"test/msg/{_name}_{_part}"))
WAITS = 20.0  # s, that a test waits for anything
SENDER = bytes(range(100, 116))
TRIGGER = (
    "std_srvs::srv::dds_::Trigger_/RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"  # of Jazzy
)


def free_port():
    """Return a port without a listener."""
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return held.getsockname()[1]


def _session(mode, listen, connect):
    config = zenoh.Config()
    for key, value in {
        "mode": mode,
        "listen/endpoints": listen,
        "connect/endpoints": connect,
        "scouting/multicast/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


@contextmanager
def router(port):
    """Stand-in for rmw_zenohd."""
    session = _session("router", [f"tcp/127.0.0.1:{port}"], [])
    try:
        yield session
    finally:
        session.close()


def serialize(kind, **values):
    """The bytes of a message of this type, whose fields are given."""
    message = TYPES.types[kind](**values)
    return bytes(TYPES.serialize_cdr(message, kind))


class Node:
    """One session: what came on each topic, as (time of arrival order, message, attachment)."""

    def __init__(self, port, domain=0):
        self.domain, self.session = domain, _session("peer", ["tcp/127.0.0.1:0"], [f"tcp/127.0.0.1:{port}"])
        self.messages, self._held, self._sent, self._some = {}, [], 0, threading.Condition()

    def key(self, topic, kind):
        package, group, name = kind.split("/")
        return f"{self.domain}{topic}/{package}::{group}::dds_::{name}_/{TYPES.hash_rihs01(kind)}"

    def tokens(self):
        """Return all liveliness tokens, split at slashes; a router may receive them a moment later."""
        deadline = time.monotonic() + WAITS
        while True:
            found = self.session.liveliness().get(f"@ros2_lv/{self.domain}/**", timeout=WAITS)
            tokens = [str(reply.ok.key_expr).split("/") for reply in found]
            if tokens or time.monotonic() > deadline:
                return tokens
            time.sleep(0.05)

    def subscribe(self, topic, kind):
        taken = self.messages.setdefault(topic, [])

        def hear(sample):
            message = TYPES.deserialize_cdr(sample.payload.to_bytes(), kind)
            with self._some:
                taken.append((message, sample.attachment.to_bytes()))
                self._some.notify_all()

        self._held.append(self.session.declare_subscriber(self.key(topic, kind), hear))

    def until(self, found):
        """Receive until a condition is true."""
        with self._some:
            assert self._some.wait_for(found, WAITS)

    def more(self, topic, count=3):
        """Receive this number of further messages."""
        wanted = len(self.messages[topic]) + count
        self.until(lambda: len(self.messages[topic]) >= wanted)

    def publish(self, topic, kind, data):
        self._sent += 1
        self.session.put(self.key(topic, kind), data, attachment=self._attachment(self._sent))

    def call(self, key, data=b"\0\1\0\0\0", attachment=None):
        """Call a service, and return the bytes of its answer and its attachment."""
        self._sent += 1
        attachment = self._attachment(self._sent) if attachment is None else attachment
        deadline = time.monotonic() + WAITS
        while time.monotonic() < deadline:
            for reply in self.session.get(f"{self.domain}/{key}", payload=data, attachment=attachment):
                if reply.ok is None:
                    raise ValueError(reply.err.payload.to_string())
                return reply.ok.payload.to_bytes(), reply.ok.attachment.to_bytes()
            time.sleep(0.05)  # it is not known yet
        raise AssertionError(f"nobody answers {key}")

    def trigger(self, name):
        """Call one of the services that need no more, and return (success, message)."""
        data, attachment = self.call(f"cdpr/{name}/{TRIGGER}")
        assert attachment[:8] == struct.pack("<q", self._sent)
        assert attachment[16:] == b"\x10" + SENDER
        size = struct.unpack("<I", data[8:12])[0]
        return bool(data[4]), data[12 : 12 + size - 1].decode()

    def ask(self, name, **values):
        """Call one of the services for parameters, and return its answer."""
        kind = "".join(part.capitalize() for part in name.split("_"))
        request = serialize(f"test/msg/{name}_request", **values)
        data, _ = self.call(f"cdpr/{name}/rcl_interfaces::srv::dds_::{kind}_/*", request)
        return TYPES.deserialize_cdr(data, f"test/msg/{name}_response")

    def _attachment(self, number):
        return struct.pack("<qqB16s", number, time.time_ns(), 16, SENDER)


@contextmanager
def node(port, domain=0):
    made = Node(port, domain)
    try:
        yield made
    finally:
        made.session.close()
