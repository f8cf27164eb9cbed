"""HTML page of the GUI, with inlined styles and scripts; its only connection is its WebSocket.

The drawing scripts of reports (`cdpr.ui.report.player`) draw scene and plots. The scripts in this folder supply the
data from the socket and create form, playback controls and lists. Names and texts come from untrusted files: scripts
insert them as text, never as HTML.
"""

from __future__ import annotations

from base64 import b64encode
from functools import cache
from hashlib import sha256
from pathlib import Path
from string import Template
from typing import Any

from cdpr.formats.read import FORMATS
from cdpr.scenario import examples
from cdpr.ui.gui.outgoing import targets
from cdpr.ui.gui.server import MOST_UPLOAD
from cdpr.ui.report.player import assets
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.style import DASHES

FOLDER = Path(__file__).parent
# Order matters: each file uses those before it.
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
    "messages.js",
    "transport.js",
    "disturb.js",
    "link.js",
    "window.js",
)
STYLES = ("gui.css", "form.css")
# Data that do not depend on the robot.
FIXED = ("colours", "axes", "cables", "states", "ramp")


@cache
def document() -> str:
    """Return the page; its script opens the WebSocket at the page's own address."""
    own = "\n".join(_text(name) for name in FILES)
    script = f'(() => {{\n"use strict";\n{assets.drawing()}\n{own}}})();\n'
    # The policy allows only this script, whatever text files contain.
    policy = f"script-src 'sha256-{b64encode(sha256(script.encode()).digest()).decode()}'"
    style = assets.ground() + assets.style() + "".join(map(_text, STYLES))
    return Template(_text("page.html")).substitute(policy=policy, style=style, script=script)


def hello() -> dict[str, Any]:
    """Return the first message of a window: styles, examples, and import and export formats."""
    data = page_data(None, [], {}, Arrays())
    dashes = [[] if isinstance(dash, str) else list(dash[1]) for dash in DASHES]
    shown = [each for each in examples.examples() if each.kind in ("scenario", "robot")]
    names = {each.name: each for each in reversed(shown)}  # a name refers to the first match
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
