"""Damage of files, drawn at random: what disks, interrupted copies, editors and mixed-up folders do."""

from __future__ import annotations

import copy
import json
import os
import random
from pathlib import Path
from typing import Any

from cdpr.base.checksums import sealed

SCALE = int(os.environ.get("CDPR_DAMAGE", "1"))  # times the number of cases of each test

VALUES: tuple[Any, ...] = (None, True, "", "x", "../x", -1, 0, 3, 1e308, -2.5, 10**30, [], [1], {}, {"a": 1}, [[[]]])


def damaged(rng: random.Random, content: bytes) -> bytes:
    """Return other bytes."""
    at, size = rng.randrange(len(content)), rng.randrange(1, 64)
    return rng.choice(
        (
            content[:at],
            content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :],
            content[:at] + bytes(byte ^ 0xFF for byte in content[at : at + size]) + content[at + size :],
            content[:at] + content[at + size :],
            content[:at] + rng.randbytes(size) + content[at:],
            content + rng.randbytes(size),
        )
    )


def edited(rng: random.Random, data: Any) -> Any:
    """Return JSON data with one value changed, removed or added."""
    data = copy.deepcopy(data)
    before = json.dumps(data)
    while json.dumps(data) == before:
        place = data
        while True:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            key = rng.choice(list(keys))
            inner = place[key]
            if isinstance(inner, dict | list) and inner and rng.random() < 0.8:
                place = inner
                continue
            break
        how = rng.random()
        if how < 0.15:
            del place[key]
        elif how < 0.25 and isinstance(inner, float | int) and not isinstance(inner, bool):
            place[key] = inner * 2 + 1
        elif how < 0.35 and isinstance(place, dict):
            place[rng.choice(("more", "name", "value"))] = rng.choice(VALUES)
        else:
            place[key] = rng.choice(VALUES)
    return data


def damage_json(rng: random.Random, path: Path) -> None:
    """Damage a JSON file: its bytes, or a value of it."""
    content = path.read_bytes()
    if rng.random() < 0.5:
        path.write_bytes(damaged(rng, content))
    else:
        path.write_text(json.dumps(edited(rng, json.loads(content)), indent=1) + "\n")


def forge_json(rng: random.Random, path: Path, job: str = "") -> None:
    """Change a value of a JSON file and compute its checksum anew."""
    data = json.loads(path.read_text())
    data.pop("checksum")
    path.write_text(json.dumps(sealed(edited(rng, data), job)) + "\n")
