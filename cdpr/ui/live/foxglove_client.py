"""Client of the Foxglove server: subscriptions, channels, and pending data."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from threading import Condition, Semaphore, Thread
from typing import Any

from cdpr.base.problems import shown
from cdpr.link.web_socket import Message, WebSocket
from cdpr.log.topics import Topic
from cdpr.simulation.requests import Request
from cdpr.ui.live import foxglove_protocol as protocol
from cdpr.ui.live.received_messages import KINDS, unknown_topic
from cdpr.ui.live.sender import BACKLOG, SERVICES, Sender

MOST_REPLIES = 1000  # pending replies; a client that does not read them is disconnected
MOST_CHANNELS = 100  # channels that a client may advertise
MOST_CALLS = 8  # concurrent service calls of a client
FEW = 10  # messages per second up to which setting a parameter waits for its new value
SOON = 0.03  # s, longer than a slice in real time

Content = dict[str, Any]


class Client:
    """Connected client.

    Args:
        link: the live link.
        web_socket: its connection.

    Attributes:
        subscriptions: subscription by channel.
    """

    def __init__(self, link: Sender, web_socket: WebSocket) -> None:
        self._link, self._web_socket = link, web_socket
        self.subscriptions: dict[int, int] = {}
        self._offered = 0  # number of channels
        self._channels: dict[int, tuple[str, str]] = {}  # topic and encoding of the client's channels
        self._watched = set[str]()  # subscribed parameters
        self._set_late = set[str]()  # parameters that it has set and whose new values follow after the answer
        self._changed = set[str]()  # parameters with values to send
        self._samples = deque[list[Message]](maxlen=BACKLOG)
        self._replies = deque[Message]()
        self._some, self._ended = Condition(), False
        self._calls, self._stops = Semaphore(MOST_CALLS), Semaphore(1)
        self._sender = Thread(target=self._send, name="foxglove client", daemon=True)

    def serve(self) -> None:
        """Receive messages until the connection ends."""
        self._sender.start()
        try:
            for message in self._web_socket:
                if not self._link.attend():
                    break
                self._receive(message)
        finally:
            self.end()
            self._sender.join()

    def reply(self, *messages: Message) -> None:
        """Send messages that must arrive; disconnect a client that does not read them."""
        with self._some:
            self._replies += messages
            crowded = len(self._replies) > MOST_REPLIES
            self._some.notify()
        if crowded:
            self._web_socket.abort()

    def offer(self, topics: Sequence[Topic]) -> None:
        """Offer these topics for subscription."""
        self._offered = len(topics)
        self.reply(protocol.advertise(topics))

    def show(self, time: int, messages: Iterable[tuple[int, bytes]]) -> None:
        """Send messages of topics, (channel, bytes) each; drop the oldest if the client is slow."""
        chosen = self.subscriptions
        found = [protocol.message_data(chosen[k], time, data) for k, data in messages if k in chosen]
        with self._some:
            self._samples.append([protocol.time_data(time), *found])
            self._some.notify()

    def changed(self, names: Iterable[str]) -> None:
        """Send the values of these parameters if the client has subscribed to or set them."""
        with self._some:
            self._changed |= (self._watched | self._set_late) & set(names)
            self._set_late -= set(names)
            self._some.notify()

    def end(self) -> None:
        """Send the pending data and stop."""
        with self._some:
            self._ended = True
            self._some.notify()

    def leave(self, seconds: float) -> None:
        """Send the pending data for up to `seconds`."""
        self.end()
        if self._sender.is_alive():  # not started yet if the client has just connected
            self._sender.join(seconds)

    def _send(self) -> None:
        try:
            while True:
                with self._some:
                    while not (self._replies or self._samples or self._changed or self._ended):
                        self._some.wait()
                    replies, samples, changed = list(self._replies), list(self._samples), self._changed
                    if self._ended and not (replies or samples):
                        return
                    self._replies.clear()
                    self._samples.clear()
                    self._changed = set()
                if changed:
                    replies.append(protocol.parameter_values(self._values(changed)))
                self._web_socket.send(*replies, *(message for sample in samples for message in sample))
        except ConnectionError:
            self.end()

    def _receive(self, message: Message) -> None:
        try:
            if isinstance(message, bytes):
                self._binary(message)
            else:
                self._text(json.loads(message))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            text = f"{type(error).__name__}: {error}" if not isinstance(error, ValueError) else str(error)
            self.reply(protocol.status(protocol.ERROR, f"malformed message: {text[:200]}"))

    def _binary(self, data: bytes) -> None:
        op = data[0] if data else 0
        if op == protocol.PUBLISHED:
            channel, content = protocol.parse_published(data)
            topic, encoding = self._channels.get(channel, ("", ""))
            self._link.receive(topic, encoding, content)
        elif op == protocol.SERVICE_CALL:
            self._call(*protocol.parse_call(data))
        else:
            raise ValueError(f"binary messages begin with byte 1 or 2, got {data[:1].hex() or 'an empty one'}")

    def _text(self, message: Any) -> None:
        op = message.get("op") if isinstance(message, dict) else None
        if not isinstance(op, str) or op not in OPERATIONS:
            raise ValueError(f"op: expected one of {', '.join(OPERATIONS)}, got {shown(op)}")
        OPERATIONS[op](self, message)

    def _subscribe(self, message: Content) -> None:
        wanted = {_number(each["channelId"]): _number(each["id"]) for each in message["subscriptions"]}
        unknown = [channel for channel in wanted if not 0 <= channel < self._offered]
        if unknown:
            raise ValueError(f"subscribe: there is no channel {unknown[0]}")
        self.subscriptions = {**self.subscriptions, **wanted}  # replaced, not changed: another thread reads it

    def _unsubscribe(self, message: Content) -> None:
        gone = {_number(each) for each in message["subscriptionIds"]}
        self.subscriptions = {channel: each for channel, each in self.subscriptions.items() if each not in gone}

    def _advertise(self, message: Content) -> None:
        for each in message["channels"]:
            number, topic, encoding = _number(each["id"]), str(each["topic"]), str(each["encoding"])
            if number not in self._channels and len(self._channels) >= MOST_CHANNELS:
                raise ValueError(f"advertise: more than {MOST_CHANNELS} channels; unadvertise others first")
            self._channels[number] = topic, encoding
            if topic not in KINDS:
                self._link.refused(unknown_topic(topic))

    def _unadvertise(self, message: Content) -> None:
        for each in message["channelIds"]:
            self._channels.pop(_number(each), None)

    def _get(self, message: Content) -> None:
        names = _names(message) or list(self._link.parameters)
        self.reply(protocol.parameter_values(self._values(names), message.get("id")))

    def _set(self, message: Content) -> None:
        """Set parameters; do not wait for the new values of a flood."""
        names = []
        for each in message["parameters"]:
            names.append(name := str(each["name"]))
            request = self._link.setting(name, each.get("value"))
            if isinstance(request, Request):
                with self._some:
                    self._set_late.add(name)
                self._link.requests.put(request)
                if self._link.received <= FEW:
                    request.done.wait(SOON)
        if message.get("id") is not None:
            self.reply(protocol.parameter_values(self._values(names), message["id"]))

    def _watch(self, message: Content) -> None:
        names = set(_names(message) or self._link.parameters)
        self._watched |= names & set(self._link.parameters)

    def _unwatch(self, message: Content) -> None:
        self._watched -= set(_names(message) or self._watched)

    def _call(self, service: int, call: int, encoding: str) -> None:
        """Call a service in its own thread: the answer may take time, and a stop must not wait for it."""
        text, stop = "", service < len(SERVICES) and SERVICES[service] == "stop"
        places = self._stops if stop else self._calls  # a stop has a place of its own
        if service >= len(SERVICES):
            text = f"there is no service {service}"
        elif encoding != "json":
            text = f"expected the encoding json, got {shown(encoding)}"
        elif not places.acquire(blocking=False):
            text = f"{1 if stop else MOST_CALLS} calls wait for the simulation already"
        if text:
            self.reply(protocol.service_failure(service, call, text))
            return
        Thread(target=self._answer, args=(service, call, places), name="foxglove service", daemon=True).start()

    def _answer(self, service: int, call: int, places: Semaphore) -> None:
        try:
            refused = self._link.call(SERVICES[service])
            self.reply(protocol.service_response(service, call, {"success": not refused, "message": refused}))
        finally:
            places.release()

    def _values(self, names: Iterable[str]) -> Mapping[str, Any]:
        parameters = self._link.parameters
        return {name: parameters[name] for name in names if name in parameters}


OPERATIONS = {
    "subscribe": Client._subscribe,
    "unsubscribe": Client._unsubscribe,
    "advertise": Client._advertise,
    "unadvertise": Client._unadvertise,
    "getParameters": Client._get,
    "setParameters": Client._set,
    "subscribeParameterUpdates": Client._watch,
    "unsubscribeParameterUpdates": Client._unwatch,
}


def _number(value: object) -> int:
    """Return the number of a channel or subscription.

    Raises:
        ValueError: if it is invalid.
    """
    if type(value) is not int or not 0 <= value < 2**32:
        raise ValueError(f"expected a whole number from 0 to {2**32 - 1}, got {shown(value)}")
    return value


def _names(message: Content) -> Sequence[str]:
    """Return the names of parameters; an empty list means all.

    Raises:
        ValueError: if they are invalid.
    """
    names = message.get("parameterNames", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"parameterNames: expected a list of names, got {shown(names)}")
    return names
