"""A running simulation for Foxglove and PlotJuggler, over a WebSocket of the foxglove SDK."""

from __future__ import annotations

import json
import queue
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from cdpr.errors import CdprError, PluginError
from cdpr.live.drive import Request
from cdpr.live.heard import KINDS, request_of
from cdpr.live.messages import Messages
from cdpr.log.chunk import nanoseconds
from cdpr.log.ros2 import schema_text
from cdpr.log.run import Header
from cdpr.model.robot import Array

try:
    import foxglove
    from foxglove.websocket import Capability, Parameter, ServerListener, Service, ServiceSchema, StatusLevel
except ImportError as error:
    raise PluginError(f"a live link needs the foxglove SDK ({error}): pip install 'cdpr[live]'") from None

ANSWERS = 2.0  # s, that who asks for something waits for it
BACKLOG = 256  # messages that wait for a client; the oldest are dropped
SERVICES = ("pause", "resume", "step", "reset", "stop")


class Foxglove:
    """A server that shows samples, and hears what clients publish, call and set.

    Args:
        host, port: where it listens; port 0 takes a free one.
        say: called with what is refused.
        parameters: names and values of what clients may set beside `paused` and `speed`.

    Raises CdprError where the port is taken.

    Attributes:
        port: on which it listens.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8765,
        say: Callable[[str], None] = lambda text: None,
        parameters: dict[str, Any] | None = None,
    ) -> None:
        self._context, self._say = foxglove.Context(), say
        self._parameters = {"paused": False, "speed": 1.0, **(parameters or {})}
        self.requests: queue.SimpleQueue[Request] = queue.SimpleQueue()
        self._shown: deque[tuple[Array, int]] = deque(maxlen=BACKLOG)
        self._some = threading.Event()
        self._channels: list[foxglove.Channel] = []
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        services = [
            Service(f"/cdpr/{name}", schema=ServiceSchema(f"cdpr/{name}"), handler=self._handler(name))
            for name in SERVICES
        ]
        capabilities = [Capability.ClientPublish, Capability.Parameters, Capability.Services, Capability.Time]
        try:
            self._server = foxglove.start_server(
                name="cdpr",
                host=host,
                port=port,
                capabilities=capabilities,
                server_listener=_Listener(self),
                supported_encodings=["json"],
                services=services,
                context=self._context,
                message_backlog_size=BACKLOG,
            )
        except (RuntimeError, OSError, OverflowError) as error:
            text = " ".join(str(error).split())
            raise CdprError(f"--live-port: cannot listen at {host}:{port}: {text}; 0 takes a free port") from None
        self.port = self._server.port

    def begin(self, header: Header) -> None:
        """Open a channel for each topic, and send from now on."""
        self._messages = Messages(header)
        self._step = header.control_step
        for topic in self._messages.topics:
            package, _, name = topic.kind.partition("/")
            text = schema_text(topic.kind).encode()
            schema = foxglove.Schema(name=f"{package}/msg/{name}", encoding="ros2msg", data=text)
            made = foxglove.Channel(topic.name, schema=schema, message_encoding="cdr", context=self._context)
            self._channels.append(made)
        self._thread = threading.Thread(target=self._send, name="cdpr live", daemon=True)
        self._thread.start()

    def show(self, row: Array, sample: int) -> None:
        """Keep it for who sends; of many that wait the oldest are dropped."""
        self._shown.append((row, sample))
        self._some.set()

    def refused(self, text: str) -> None:
        """Tell all clients, and who started it."""
        self._say(text)
        self._server.publish_status(text, StatusLevel.Warning)

    def close(self) -> None:
        """Send no more, and close all connections."""
        self._ended.set()
        self._some.set()
        if self._thread is not None:
            self._thread.join()
        for channel in self._channels:
            channel.close()
        self._server.stop()

    def ask(self, request: Request) -> str:
        """Hand a request to the simulation, and return "" or why it was refused."""
        self.requests.put(request)
        late = "the simulation does not answer: it is over, or has not begun"
        return request.answer if request.done.wait(ANSWERS) else late

    def given(self) -> list[Parameter]:
        """All parameters."""
        return [Parameter(name, value=value) for name, value in self._parameters.items()]

    def set(self, name: str, value: Any) -> None:
        """Let a parameter have another value, if the simulation takes it."""
        if name not in self._parameters:
            self.refused(f"{name}: there is no such parameter; there are {', '.join(self._parameters)}")
            return
        kinds = {"paused": ("pause", "paused"), "speed": ("speed", "speed")}
        what, key = kinds.get(name, ("set", "value"))
        wrong = isinstance(value, bool) != (name == "paused") or not isinstance(value, bool | int | float)
        if wrong:
            self.refused(f"{name}: {'true or false' if name == 'paused' else 'a number'} is expected, got {value!r}")
            return
        values = {key: value} if what != "set" else {"key": name, "value": value}
        if not self.ask(Request(what, values)):
            self._parameters[name] = value
            self._server.publish_parameter_values(self.given())

    def _handler(self, name: str) -> Callable[[Any], bytes]:
        def handle(_: Any) -> bytes:
            what, values = ("pause", {"paused": False}) if name == "resume" else (name, {})
            answer = self.ask(Request(what, values))
            if not answer and what in ("pause", "step"):
                self._parameters["paused"] = name != "resume"
                self._server.publish_parameter_values(self.given())
            return json.dumps({"success": not answer, "message": answer}).encode()

        return handle

    def _send(self) -> None:
        """Send what is shown, if somebody listens."""
        while not self._ended.is_set():
            self._some.wait()
            self._some.clear()
            while self._shown:
                row, sample = self._shown.popleft()
                wanted = [channel.has_sinks() for channel in self._channels]
                if any(wanted):
                    self._log(row, sample, wanted)

    def _log(self, row: Array, sample: int, wanted: list[bool]) -> None:
        import numpy as np

        time = int(nanoseconds(np.array([sample]), self._step)[0])
        self._server.broadcast_time(time)
        for k, data in self._messages.of(row, sample, wanted):
            self._channels[k].log(data, log_time=time)


class _Listener(ServerListener):
    """Hears clients, in threads of the server."""

    def __init__(self, server: Foxglove) -> None:
        self._server, self._topics = server, dict[tuple[int, int], tuple[str, str]]()

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        self._topics[client.id, channel.id] = channel.topic, channel.encoding
        if channel.topic not in KINDS:
            self._server.refused(f"{channel.topic}: nobody listens there; {', '.join(KINDS)} are heard")

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._topics.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        topic, encoding = self._topics.get((client.id, client_channel_id), ("", ""))
        try:
            self._server.requests.put(request_of(topic, encoding, data))
        except CdprError as error:
            self._server.refused(str(error))

    def on_get_parameters(self, client: Any, param_names: list[str], request_id: str | None = None) -> list[Parameter]:
        return [one for one in self._server.given() if not param_names or one.name in param_names]

    def on_set_parameters(
        self, client: Any, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        for one in parameters:
            self._server.set(one.name, one.get_value())
        names = {one.name for one in parameters}
        return [one for one in self._server.given() if one.name in names]
