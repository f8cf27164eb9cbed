"""The broadcast between the simulation and its windows: bounded whatever windows do."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr.ui.gui.broadcast import KINDS, Broadcast, encoded


def test_a_slow_window_gets_the_newest_alone():
    broadcast = Broadcast()
    broadcast.curves.begin({"tension": (1, 3)}, 10)
    reader = broadcast.join()
    texts = iter(reader)
    for n in range(1000):
        broadcast.put({"kind": "frame", "n": n})
        broadcast.put({"kind": "message", "n": n})
    broadcast.put({"kind": "hello"})
    first = [next(texts) for _ in range(2)]
    assert first == [encoded({"kind": "hello"}), encoded({"kind": "frame", "n": 999})]
    broadcast.curves.add(np.ones((3, 2)))
    with broadcast.changed:
        broadcast.curves.show()
    rest = [next(texts) for _ in range(51)]  # an empty `samples`, and the last of the messages
    assert '"samples"' in rest[0]
    assert rest[-1] == encoded({"kind": "message", "n": 999})
    assert '"t":[1.0,1.0,1.0]' in next(texts)
    late = iter(broadcast.join())
    assert next(late) == encoded({"kind": "hello"})
    broadcast.leave(reader)
    assert list(texts) == []


def test_no_message_holds_what_json_has_not():
    assert set(KINDS) == {"hello", "form", "scene", "status", "frame", "images"}
    with pytest.raises(ValueError, match="not JSON compliant"):
        encoded({"kind": "frame", "t": float("nan")})
