"""A running simulation for Foxglove and PlotJuggler, over a WebSocket of the foxglove SDK."""

from __future__ import annotations

import json
import logging
import os
import secrets
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from threading import Event, Thread
from typing import Any

from cdpr.errors import CdprError, PluginError
from cdpr.live.heard import KINDS, unheard
from cdpr.live.requests import Request
from cdpr.live.sender import BACKLOG, SERVICES, Sender
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.topics import Topic

try:
    import foxglove
    from foxglove.websocket import Capability, Parameter, ServerListener, Service, ServiceSchema, StatusLevel
    from websockets.exceptions import WebSocketException
    from websockets.sync.client import connect
except ImportError as error:
    raise PluginError(
        f"a live link needs the foxglove SDK and websockets ({error}): pip install 'cdpr[live]'"
    ) from None

CLOSES = 1.0  # s, that is waited for clients to go
FEW = 10  # messages in a second may wait for what becomes of a parameter that they set,
SOON = 0.03  # s, longer than a slice takes in real time
WAITS = 1.0  # s, that its own client waits for the server
REST = 0.05  # s, from one time that subscribers are told of parameters to the next
PROTOCOL = "foxglove.sdk.v1"
# What clients get wrong the SDK would log, a line for each, however many: it took the run's time.
_LOGGER = logging.getLogger("foxglove")
if _LOGGER.level == logging.NOTSET:
    _LOGGER.setLevel(logging.CRITICAL)


class Foxglove(Sender):
    """A server that shows samples, and hears what clients publish, call and set.

    Args:
        host, port: where it listens; port 0 takes a free one.
        say: called with what is refused.
        parameters: names and values of what clients may set beside `paused` and `speed`.

    Raises CdprError where it cannot listen there, as where the port is taken.

    Attributes:
        port: on which it listens.
        subscribed: whether anybody ever asked to be told of parameters that change.
        secret: by which its own client is known.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8765,
        say: Callable[[str], None] = lambda text: None,
        parameters: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(host, port, say, parameters)
        self.secret = secrets.token_hex(16)
        self.subscribed = False
        self._context = foxglove.Context()
        self._channels: list[foxglove.Channel] = []
        services = [
            Service(f"/cdpr/{name}", schema=ServiceSchema(f"cdpr/{name}"), handler=self._handler(name))
            for name in SERVICES
        ]
        capabilities = [Capability.ClientPublish, Capability.Parameters, Capability.Services, Capability.Time]
        try:
            self._server = foxglove.start_server(
                name="cdpr",
                host=self.host,
                port=port,
                capabilities=capabilities,
                server_listener=_Listener(self),
                supported_encodings=["json", "cdr"],
                services=services,
                context=self._context,
                message_backlog_size=BACKLOG,
            )
        except (RuntimeError, OSError, OverflowError) as error:
            text = " ".join(str(error).split())
            raise CdprError(
                f"--live-port: cannot listen at {self.address}: {text}; 0 takes a free port, --live-host another place"
            ) from None
        self.port = self._server.port
        self._news = Event()
        self._pushing = Thread(target=self._push, name="cdpr parameters", daemon=True)
        self._pushing.start()
        self.where = f"ws://{self.address}, for Foxglove and PlotJuggler"

    def _tell(self, text: str) -> None:
        """Tell all clients, too."""
        super()._tell(text)
        self._server.publish_status(text, StatusLevel.Warning)

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Tell who subscribes to parameters, too, soon."""
        super().changed(parameters)
        self._news.set()

    def _push(self) -> None:
        """Tell subscribers of all parameters as a client of its own that sets them.

        The SDK's method for that is never called: it waits, with the interpreter, for the lock of who subscribes and
        waits for the interpreter. What a client sets the SDK tells all who subscribe, without the interpreter.
        """
        times: dict[str, Any] = {"open_timeout": WAITS, "close_timeout": WAITS, "ping_interval": None}
        client = partial(connect, f"ws://{self.address}", subprotocols=[PROTOCOL], proxy=None, **times)
        said = json.dumps({"op": "setParameters", "parameters": [], "id": self.secret})
        while self._news.wait() and not self._ended.is_set():
            self._news.clear()
            if self.subscribed:
                with suppress(OSError, WebSocketException), client() as link:
                    link.send(said)
            self._ended.wait(REST)

    def given(self) -> list[Parameter]:
        """All parameters."""
        return [Parameter(name, value=value) for name, value in self.parameters.items()]

    def _handler(self, name: str) -> Callable[[Any], bytes]:
        def handle(_: Any) -> bytes:
            answer = self.call(name)
            return json.dumps({"success": not answer, "message": answer}).encode()

        return handle

    def _open(self, topics: tuple[Topic, ...]) -> None:
        for topic in topics:
            text = schema_text(topic.kind).encode()
            schema = foxglove.Schema(name=full_name(topic.kind), encoding="ros2msg", data=text)
            made = foxglove.Channel(topic.name, schema=schema, message_encoding="cdr", context=self._context)
            self._channels.append(made)

    def _wanted(self) -> list[bool]:
        return [channel.has_sinks() for channel in self._channels]

    def _put(self, time: int, messages: Iterator[tuple[int, bytes]]) -> None:
        self._server.broadcast_time(time)
        for k, data in messages:
            self._channels[k].log(data, log_time=time)

    def _shut(self) -> None:
        self._news.set()
        self._pushing.join()
        for channel in self._channels:
            channel.close()
        stopping = Thread(target=self._server.stop)
        stopping.start()
        stopping.join(CLOSES)
        if stopping.is_alive():  # a client that sends without end holds it up, and the end of the program
            _cut(self.port)
            stopping.join()


class _Listener(ServerListener):
    """Hears clients, in threads of the server: to wait here long for the simulation would hold up all of them."""

    def __init__(self, server: Foxglove) -> None:
        self._server, self._topics = server, dict[tuple[int, int], tuple[str, str]]()

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        self._topics[client.id, channel.id] = channel.topic, channel.encoding
        if self._server.attend() and channel.topic not in KINDS:
            self._server.refused(unheard(channel.topic))

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._topics.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        topic, encoding = self._topics.get((client.id, client_channel_id), ("", ""))
        if self._server.attend():
            self._server.hear(topic, encoding, data)

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        self._server.subscribed = True

    def on_get_parameters(self, client: Any, param_names: list[str], request_id: str | None = None) -> list[Parameter]:
        self._server.attend()
        return [one for one in self._server.given() if not param_names or one.name in param_names]

    def on_set_parameters(
        self, client: Any, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        # Of a flood nothing is waited for. The SDK tells all who subscribe of what is returned.
        if request_id == self._server.secret:
            return self._server.given()
        for one in parameters if self._server.attend() else ():
            request = self._server.setting(one.name, one.get_value())
            if isinstance(request, Request):
                self._server.requests.put(request)
                if self._server.heard <= FEW:
                    request.done.wait(SOON)
        names = {one.name for one in parameters}
        return [one for one in self._server.given() if one.name in names]


def _cut(port: int) -> None:
    """End the connections that this process has at a port of its own."""
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):  # it is gone, or no socket
            held = os.dup(int(name))
            try:
                found = socket.socket(fileno=held)
                if found.getsockname()[1:2] == (port,):
                    found.shutdown(socket.SHUT_RDWR)
                found.detach()
            finally:
                os.close(held)
