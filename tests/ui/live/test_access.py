"""Access control of the Foxglove server, and requests of clients."""

from __future__ import annotations

import json
import os
import random
import socket
import struct
import time
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial

import live_client
import numpy as np
import pytest
from click.testing import CliRunner
from live_client import FILE, TEXT_TIMEOUT, client
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import cdpr
from cdpr.base.errors import CdprError
from cdpr.ui.cli import cli
from cdpr.ui.live import foxglove_client
from cdpr.ui.live.received_messages import TENSION, WRENCH

foxglove = pytest.importorskip("cdpr.ui.live.foxglove")

CASES = int(os.environ.get("CDPR_WEB_CASES", "400"))  # malformed messages
NAMES = ("foxglove.sdk.v1", "foxglove.websocket.v1")
PAGE = "https://app.foxglove.dev"


def running(*words, **values):
    return live_client.running(partial(foxglove.Foxglove, port=0), *words, **values)


@contextmanager
def joined(url, names=NAMES[:1], **options):
    with connect(url, subprotocols=names, proxy=None, **options) as opened:
        yield json.loads(opened.recv(timeout=TEXT_TIMEOUT))


def refused(url, status, names=NAMES[:1], **options):
    with pytest.raises(InvalidStatus, match=str(status)):
        joined(url, names, **options).__enter__()


def test_web_pages_and_unknown_clients_cannot_steer():
    with running(0.2, held=True) as (link, found, said):
        bare = f"ws://127.0.0.1:{link.port}"
        for origin in (None, "https://evil.example", "null", bare.replace("ws", "http"), PAGE):
            refused(bare, 403, origin=origin)
            refused(f"{bare}/?token=guessed", 403, origin=origin)
        refused(link.url.replace("/?", "/x?"), 404)
        with connect(link.url.replace("127.0.0.1", "localhost"), subprotocols=NAMES, proxy=None):
            pass
        # A name that resolves to this machine: the request contains it.
        with closing(live_client.socket_to(link.port)) as raw:
            raw.sendall(f"GET /{link.url.partition('/?')[2]} HTTP/1.1\r\nHost: evil.example\r\n\r\n".encode())
            assert raw.recv(100).startswith(b"HTTP/1.1 421 ")
    plain = cdpr.simulate(cdpr.load_scenario(FILE, overrides={"simulation.duration": 0.2}))
    assert np.array_equal(found["run"].rows, plain.rows)
    assert said == []


def test_both_names_of_the_protocol_are_the_same_protocol():
    with closing(foxglove.Foxglove(port=0)) as link:
        for names in (NAMES[:1], NAMES[1:], NAMES, NAMES[::-1], ("other", NAMES[1])):
            for origin in (None, PAGE):
                with joined(link.url, names, origin=origin) as info:
                    assert info["op"] == "serverInfo"
                    assert set(info["capabilities"]) == {
                        "clientPublish", "parameters", "parametersSubscribe", "services", "time"
                    }  # fmt: skip
        refused(link.url, 400, ("foxglove.websocket.v2",))
        refused(link.url, 400, None)


def test_programs_may_connect_without_a_token_if_allowed():
    with closing(foxglove.Foxglove(port=0, programs=True)) as link:
        bare = f"ws://127.0.0.1:{link.port}"
        for url, origin in ((bare, None), (link.url, None), (link.url, PAGE)):
            with joined(url, origin=origin):
                pass
        for origin in (PAGE, "null", "http://127.0.0.1", ""):
            refused(bare, 403, additional_headers={"Origin": origin})
    result = CliRunner().invoke(cli, ["run", str(FILE), "--live", "ros2", "--live-no-token"])
    assert "--live-no-token requires --live foxglove" in result.output
    result = CliRunner().invoke(cli, ["run", str(FILE), "--live-no-token"])
    assert "--live-no-token requires --live" in result.output


def test_a_token_may_stay_the_same(monkeypatch):
    monkeypatch.setenv("CDPR_LIVE_TOKEN", "the_token_of-my-bench")
    with closing(foxglove.Foxglove(port=0)) as link, joined(f"ws://127.0.0.1:{link.port}/?token=the_token_of-my-bench"):
        assert link.where.startswith(f"ws://127.0.0.1:{link.port}/?token=the_token_of-my-bench ")
    for bad in ("short", "sixteen or more letters", "ü" * 20):
        monkeypatch.setenv("CDPR_LIVE_TOKEN", bad)
        with pytest.raises(CdprError, match="CDPR_LIVE_TOKEN: expected 16 or more"):
            foxglove.Foxglove(port=0)


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="this machine has no IPv6 beside IPv4")
@pytest.mark.parametrize(
    ("host", "local", "named"),
    [
        ("::1", "[::1]", "[::1]"),
        ("[::1]", "[::1]", "[::1]"),
        ("localhost", "127.0.0.1", "localhost"),
        ("0.0.0.0", "127.0.0.1", socket.gethostname()),
        ("::", "[::1]", socket.gethostname()),
    ],
)
def test_listening_address(host, local, named):
    said = []
    with closing(foxglove.Foxglove(host=host, port=0, say=said.append)) as link:
        assert link.url.startswith(f"ws://{named}:{link.port}/?token=")
        with joined(link.url.replace(named, local, 1)):
            pass
        with closing(socket.create_connection((local.strip("[]"), link.port), TEXT_TIMEOUT)) as raw:
            raw.sendall(b"GET /?token=x HTTP/1.1\r\nHost: rebound.example\r\n\r\n")
            assert raw.recv(100).startswith(b"HTTP/1.1 421 ")
    assert said == ([foxglove.EXPOSED] if host in ("0.0.0.0", "::") else [])


def test_parameters_that_are_not_finite_are_sent_as_text():
    with closing(foxglove.Foxglove(port=0, parameters={"controller.limit": np.inf})) as link, client(link) as seen:
        seen.say(op="subscribeParameterUpdates", parameterNames=["controller.limit"])
        seen.say(op="getParameters", parameterNames=["controller.limit"])
        seen.until(lambda: seen.parameters)
        assert seen.parameters["controller.limit"] == "inf"
        link.changed({"controller.limit": np.nan})
        seen.until(lambda: seen.parameters["controller.limit"] == "nan")
        link.changed({"controller.limit": 3.0})
        seen.until(lambda: seen.parameters["controller.limit"] == 3.0)
        assert seen.statuses == []


@pytest.mark.slow
def test_channels_are_freed():
    with closing(foxglove.Foxglove(port=0)) as link, client(link) as seen:
        channel = {"topic": WRENCH, "encoding": "json", "schemaName": "any"}
        for number in range(10 * foxglove_client.MOST_CHANNELS):
            seen.say(op="advertise", channels=[{"id": number, **channel}])
            seen.say(op="unadvertise", channelIds=[number])
        seen.say(op="getParameters", parameterNames=["speed"])
        seen.until(lambda: seen.parameters)
        assert seen.statuses == []
        assert link._clients[0]._channels == {}
        seen.say(op="advertise", channels=[{"id": number, **channel} for number in range(10**4)])
        seen.until(lambda: seen.statuses)
        assert "more than 100 channels" in seen.statuses[0]
        assert len(link._clients[0]._channels) == foxglove_client.MOST_CHANNELS
        end = time.monotonic() + TEXT_TIMEOUT
        seen.socket.close()
        while link._clients and time.monotonic() < end:
            time.sleep(0.01)
        assert link._clients == []


def test_one_that_takes_no_answers_is_cut(monkeypatch):
    monkeypatch.setattr(foxglove_client, "MOST_REPLIES", 50)
    monkeypatch.setattr(foxglove_client.Client, "_send", lambda self: None)  # it sends nothing
    with closing(foxglove.Foxglove(port=0)) as link, client(link) as seen:
        with suppress(ConnectionClosed):
            for _ in range(200):
                seen.say(op="getParameters", parameterNames=[])
        end = time.monotonic() + TEXT_TIMEOUT
        while link._clients and time.monotonic() < end:
            time.sleep(0.01)
        assert link._clients == []


def garbled(chance):
    """A message with something wrong in it, text or bytes."""
    odd = [None, True, -1, 2**32, 2**70, 1.5, "", "x", [], [[]], {}, {"id": 1}, [None], [{"id": None}], float("nan")]
    ops = [*foxglove_client.OPERATIONS, "fetchAsset", "subscribeConnectionGraph", "_call", "__class__", "", None, 3, []]
    keys = ["subscriptions", "subscriptionIds", "channels", "channelIds", "parameterNames", "parameters", "id"]
    kind = chance.randrange(4)
    if kind == 0:
        return chance.randbytes(chance.randrange(40))
    if kind == 1:
        head = bytes([chance.choice([0, 1, 1, 2, 2, 3, 255])])
        numbers = struct.pack("<III", *(chance.choice([0, 1, 4, 5, 2**31, 2**32 - 1]) for _ in range(3)))
        return head + numbers[: chance.randrange(13)] + chance.choice([b"", b"jso", b"cdr_{}", b"\xff\xff\xff\xff"])
    if kind == 2:
        return chance.choice(
            ["", "{", "[]", "null", "[" * 5000, '{"op"', "1e999", '"x"', "{}", '{"op": {}}', "\0", "ü"]
        )
    message = {"op": chance.choice(ops)} | {key: chance.choice(odd) for key in chance.sample(keys, 3)}
    nested = [{"id": chance.choice(odd), "channelId": chance.choice(odd), "topic": chance.choice(odd), "name": "speed"}]
    return json.dumps(message | ({chance.choice(keys): nested} if chance.random() < 0.5 else {}))


def test_malformed_messages_are_answered_and_change_nothing():
    chance = random.Random(5)
    with running(0.2, held=True) as (link, found, _), client(link) as seen:
        for number in range(CASES):
            data = garbled(chance)
            seen.socket.send(data)
            if number % 20 == 0:  # and so it takes the answers
                seen.parameters.clear()
                seen.say(op="getParameters", parameterNames=["speed"], id="?")
                seen.until(lambda: seen.parameters)
        assert any("malformed message" in text for text in seen.statuses)
        assert not any("Traceback" in text for text in seen.statuses)
        assert len(link._clients) == 1
    plain = cdpr.simulate(cdpr.load_scenario(FILE, overrides={"simulation.duration": 0.2}))
    assert np.array_equal(found["run"].rows, plain.rows)


def test_a_stop_does_not_wait_for_other_calls():
    with closing(foxglove.Foxglove(port=0)) as link, client(link) as seen:
        seen.until(lambda: "/cdpr/stop" in seen.services)
        for call in range(12):  # no simulation runs: no answers
            name = "/cdpr/stop" if call == 10 else "/cdpr/step"  # as many steps as wait at most come before it
            seen.socket.send(b"\x02" + struct.pack("<III", seen.services[name], call, 4) + b"json")
        seen.say(op="getParameters", parameterNames=["speed"])
        seen.until(lambda: seen.parameters)  # nothing that waits for an answer is before it
        requests = [link.requests.get(5.0) for _ in range(9)]
        assert sorted(each.what for each in requests) == ["step"] * 8 + ["stop"]
        for each in requests:
            each.done.set()
        seen.until(lambda: len(seen.replies) == 9)


def test_clients_are_few():
    with closing(foxglove.Foxglove(port=0)) as link, ExitStack() as held:
        for _ in range(foxglove.MOST_CLIENTS):
            held.enter_context(client(link))
        refused(link.url, 503)


def test_tensions_need_the_token_too():
    with running(0.3, held=True) as (link, found, _), client(link) as seen:
        seen.subscribe("/clock")
        seen.publish(TENSION, {"effort": [400.0] * 8})
        assert seen.call("/cdpr/resume")["success"]
        seen.more("/clock", 5)
    assert (found["run"].tension == 400.0).all(axis=1).any()
