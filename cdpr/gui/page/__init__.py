"""The window's page: one HTML text with style and scripts in it, which asks for nothing but its own socket.

Scene and plots are drawn by the scripts of the reports (`cdpr.report.player`); what is here feeds them with what the
socket tells, and makes form, transport and lists. Names and texts come from files of others: scripts set them as text,
never as HTML.
"""

from __future__ import annotations

from base64 import b64encode
from functools import cache
from hashlib import sha256
from pathlib import Path
from string import Template
from typing import Any

from cdpr.formats.read import FORMATS
from cdpr.gui.outgoing import targets
from cdpr.gui.server import MOST_UPLOAD
from cdpr.report.marks import DASHES
from cdpr.report.player import assets
from cdpr.report.player.arrays import Arrays
from cdpr.report.player.data import page_data
from cdpr.scenario import examples

FOLDER = Path(__file__).parent
# In this order: each uses what stands before it.
FILES = (
    "words.js",
    "parts.js",
    "live.js",
    "handles.js",
    "curves.js",
    "widgets.js",
    "degrees.js",
    "fields.js",
    "table.js",
    "form.js",
    "files.js",
    "exchange.js",
    "told.js",
    "transport.js",
    "disturb.js",
    "link.js",
    "window.js",
)
STYLES = ("gui.css", "form.css")
# What is fixed whatever robot is shown.
FIXED = ("colours", "axes", "cables", "states", "ramp")


@cache
def document() -> str:
    """Return the page. It opens its socket at its own address, query and all."""
    own = "\n".join(_text(name) for name in FILES)
    script = f'(() => {{\n"use strict";\n{assets.drawing()}\n{own}}})();\n'
    # No script but this one runs, whatever a file's texts hold.
    policy = f"script-src 'sha256-{b64encode(sha256(script.encode()).digest()).decode()}'"
    style = assets.ground() + assets.style() + "".join(map(_text, STYLES))
    return Template(_text("page.html")).substitute(policy=policy, style=style, script=script)


def hello() -> dict[str, Any]:
    """Return what a window is told first: what stands for what, and what can be opened, imported and exported."""
    data = page_data(None, [], {}, Arrays())
    dashes = [[] if isinstance(dash, str) else list(dash[1]) for dash in DASHES]
    shown = [each for each in examples.examples() if each.kind in ("scenario", "robot")]
    names = {each.name: each for each in reversed(shown)}  # a name finds the first
    listed = [
        {
            "kind": each.kind,
            "label": each.name,
            "name": each.name if names[each.name] is each else str(each.path),
            "shows": each.shows,
        }
        for each in shown
    ]
    exchange = {"imports": [each.name for each in FORMATS], "exports": targets(), "upload": MOST_UPLOAD}
    return {**{key: data[key] for key in FIXED}, "dashes": dashes, "examples": listed, **exchange}


def _text(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")
