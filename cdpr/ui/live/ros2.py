"""Live link as a ROS 2 node over Zenoh: nodes with rmw_zenoh subscribe, publish, call services and set parameters.

Experimental: tested without ROS 2. `cdpr.ui.live.rmw_zenoh` defines the names.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import count
from threading import Thread
from typing import Any

from cdpr.base.errors import CdprError, MissingPackageError
from cdpr.log.ros2 import decode, encode
from cdpr.log.topics import Topic
from cdpr.ui.live.parameters import PARAMETER_SERVICES
from cdpr.ui.live.received_messages import KINDS, bounded
from cdpr.ui.live.sender import SERVICES, Sender

try:
    import zenoh

    from cdpr.ui.live.rmw_zenoh import PUBLISHER, SERVICE, SUBSCRIPTION, Node, attachment, gid, parse_attachment
except ImportError as error:
    text = f"a live link to ROS 2 needs Zenoh and xxhash ({error}): pip install 'cdpr[live]'"
    raise MissingPackageError(text) from None

NAME = "cdpr"
ROUTER = 7447  # port of a Zenoh router
MOST_DOMAIN = 232  # as for DDS, where ports limit it
KEPT = 10  # pending messages of a topic, as in its quality of service
DEPTH = 1000  # history depth of parameter services, as in rcl
TRIGGER = "std_srvs/srv/Trigger"


class Ros2(Sender):
    """Node that publishes samples and receives messages, service calls and parameters.

    Args:
        host, port: Zenoh router, rmw_zenohd, through which nodes discover each other. It may be started later.
        say: called with refusals.
        parameters: names and values of settable parameters besides `paused` and `speed`.
        domain: ROS_DOMAIN_ID; by default that of the environment, or 0.

    Raises:
        CdprError: if an argument is invalid.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = ROUTER,
        say: Callable[[str], None] = lambda text: None,
        parameters: dict[str, Any] | None = None,
        domain: int | None = None,
    ) -> None:
        super().__init__(host, port, say, parameters)
        domain = _domain() if domain is None else domain
        if not port:
            raise CdprError(f"--live-port: expected the port of a Zenoh router, mostly {ROUTER}, got 0")
        try:
            self._session = zenoh.open(_config(self.address))
        except zenoh.ZError as error:
            raise CdprError(f"--live-host: {self.address}: {' '.join(str(error).split())}") from None
        self.where = f"ROS 2 node /{NAME} (experimental), domain {domain}, Zenoh router at {self.address}"
        if not self.met:
            self.where += "; no router found yet: ros2 run rmw_zenoh_cpp rmw_zenohd"
        self._node = Node(domain, str(self._session.zid()), NAME)
        self._numbers = count(1)
        self._publishers: list[tuple[zenoh.Publisher, bytes, Iterator[int]]] = []
        # Zenoh removes declarations without references.
        self._held: list[object] = [self._token(self._node.token())]
        for topic, kind in KINDS.items():
            self._declare(SUBSCRIPTION, topic, kind)
            # Zenoh drops the oldest messages of a flood without the interpreter.
            subscriber = self._session.declare_subscriber(self._node.key(topic, kind), zenoh.handlers.RingChannel(KEPT))
            self._held.append(subscriber)
            Thread(
                target=self._listen, args=(topic, subscriber), name=f"cdpr subscribes to {topic}", daemon=True
            ).start()
        for name in SERVICES:
            self._serve(name, TRIGGER, self._trigger(name))
        for kind, answer in PARAMETER_SERVICES.items():
            self._serve(_snake(kind), kind, partial(answer, self), DEPTH)

    @property
    def met(self) -> bool:
        """True if a router is connected."""
        return bool(self._session.info.routers_zid())

    def _token(self, key: str) -> zenoh.LivelinessToken:
        return self._session.liveliness().declare_token(key)

    def _declare(self, entity: str, name: str, kind: str, depth: int = 10) -> bytes:
        """Declare a topic or service, and return the identifier of its sender."""
        token = self._node.endpoint(next(self._numbers), entity, name, kind, depth)
        self._held.append(self._token(token))
        return gid(token)

    def _listen(self, topic: str, subscriber: zenoh.Subscriber[Any]) -> None:
        with suppress(zenoh.ZError):  # the session is closed
            for sample in subscriber:
                if self.attend():
                    self.receive(topic, "cdr", sample.payload.to_bytes())

    def _trigger(self, name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
        def answer(_: dict[str, Any]) -> dict[str, Any]:
            refused = self.call(name)
            return {"success": not refused, "message": refused}

        return answer

    def _serve(self, name: str, kind: str, answer: Callable[[dict[str, Any]], dict[str, Any]], depth: int = 10) -> None:
        """Answer the calls of a service."""
        key = self._node.key(f"/{NAME}/{name}", kind)

        def handle(query: zenoh.Query) -> None:
            with query:
                if not self.attend():
                    return
                try:
                    sequence, _, caller = parse_attachment(query.attachment.to_bytes() if query.attachment else b"")
                    data = query.payload.to_bytes() if query.payload else b""
                    request = decode(f"{kind}_Request", bounded(data))
                except ValueError as error:
                    self.refused(f"/{NAME}/{name}: {error}")
                    query.reply_err(str(error))
                    return
                data, _ = encode(f"{kind}_Response", answer(request))
                query.reply(key, data, attachment=attachment(sequence, time.time_ns(), caller))

        self._declare(SERVICE, f"/{NAME}/{name}", kind, depth)
        self._held.append(self._session.declare_queryable(key, handle, complete=True))

    def _open(self, topics: tuple[Topic, ...]) -> None:
        for topic in topics:
            publisher = self._session.declare_publisher(
                self._node.key(topic.name, topic.kind), congestion_control=zenoh.CongestionControl.DROP
            )
            sender = self._declare(PUBLISHER, topic.name, topic.kind)
            self._publishers.append((publisher, sender, count(1)))

    def _wanted(self) -> list[bool]:
        return [_matching(publisher) for publisher, _, _ in self._publishers]

    def _put(self, time_: int, messages: Iterator[tuple[int, bytes]]) -> None:
        for k, data in messages:
            publisher, sender, numbers = self._publishers[k]
            publisher.put(data, attachment=attachment(next(numbers), time.time_ns(), sender))

    def _shut(self) -> None:
        self._session.close()  # type: ignore[no-untyped-call]


def _matching(publisher: zenoh.Publisher) -> bool:
    """Return True if there is a subscriber; `matching_status` is an object, unlike in Zenoh's type hints."""
    status: Any = publisher.matching_status
    return bool(getattr(status, "matching", status))


def _config(address: str) -> zenoh.Config:
    """Return the configuration of rmw_zenoh's sessions: a peer of this machine that finds others through a router."""
    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "connect/endpoints": [f"tcp/{address}"],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "listen/endpoints": ["tcp/127.0.0.1:0"],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": True,
        "scouting/gossip/target": {"router": ["router", "peer"], "peer": ["router"]},
        "scouting/gossip/autoconnect_strategy": {"peer": {"to_router": "always", "to_peer": "greater-zid"}},
        "timestamping/enabled": True,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _domain() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    if not text.isdecimal() or int(text) > MOST_DOMAIN:
        raise CdprError(f"ROS_DOMAIN_ID: expected a whole number from 0 to {MOST_DOMAIN}, got {text!r}")
    return int(text)


def _snake(kind: str) -> str:
    """Return the name of a service type in rcl: "get_parameters"."""
    name = kind.rpartition("/")[2]
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")
