"""Player scripts and styles for inlining into HTML pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from cdpr.scene import colours
from cdpr.scene.colours import Pair
from cdpr.ui.report.player.data import block
from cdpr.ui.report.style import paired
from cdpr.ui.report.text.aligned import number

FOLDER = Path(__file__).with_name("script")
# Order matters: each file uses those before it. All files except player.js only draw; images.js is only for reports.
DRAWING = ("data.js", "camera.js", "gl.js", "flat.js", "scene.js", "viewer.js", "plot.js")
FILES = (*DRAWING, "images.js", "player.js")


def script(data: Mapping[str, Any]) -> str:
    """Return the data block and the player script as HTML."""
    return f"{block(data)}\n<script>\n{_code()}</script>"


@cache
def drawing() -> str:
    """Return the drawing part of the script, for windows that control the time and the scene themselves."""
    return _joined(DRAWING)


@cache
def ground() -> str:
    """Return the base style of all pages, with light and dark colours."""
    return (FOLDER / "ground.css").read_text(encoding="utf-8")


@cache
def style() -> str:
    """Return the style of the player's elements."""
    return (FOLDER / "player.css").read_text(encoding="utf-8")


def viewer(data: Mapping[str, Any]) -> str:
    """Return the scene as HTML with its legend; playback controls are included if a scene has several frames."""
    several = any(scene["time"]["n"] > 1 for scene in data["scenes"])
    return _text("viewer.html").substitute(legend=_legend(data), transport=transport() if several else "")


def transport() -> str:
    """Return the playback controls (play, pause, seek) as HTML."""
    return _text("transport.html").template


def _legend(data: Mapping[str, Any]) -> str:
    first, *others = scenes = data["scenes"]
    shown = []
    if others:
        shown += [_swatch(Pair(*scene["colour"]), escape(scene["label"]), thing=scene["thing"]) for scene in scenes]
    elif "tension" in first:
        low, high = map(number, first["range"])
        shown.append(f'<span class="scale">tension {low} N <i id="bar"></i> {high} N</span>')
        shown.append(_swatch(colours.SLACK, "slack", "dashed"))
        shown.append(_swatch(colours.LIMIT, "at a limit ▲▼"))
    toggles = ["numbers"]
    if "desired" in first:
        toggles.insert(0, "ghost")
    if first["time"]["n"] > 1:
        toggles.insert(0, "path")
    if any("force" in scene for scene in scenes):
        toggles.append("force")
    if "sensors" in first:
        toggles.append("sensors")
    marks = {"ghost": _swatch(colours.DESIRED, "desired"), "force": _swatch(colours.FORCE, "force")}
    marks["sensors"] = _swatch(colours.SENSOR, "sensors")
    buttons = [f'<button type="button" data-do="{key}">{marks.get(key, key)}</button>' for key in toggles]
    return f'<div class="legend">{"".join([*shown, *buttons])}</div>'


def _swatch(pair: Pair, text: str, line: str = "solid", thing: str = "") -> str:
    of = f' data-thing="{escape(thing)}"' if thing else ""
    return f'<span><i class="swatch paired" style="{paired(pair)};border-top-style:{line}"{of}></i>{text}</span>'


@cache
def _text(name: str) -> Template:
    return Template((FOLDER / name).read_text(encoding="utf-8"))


@cache
def _code() -> str:
    return f'(() => {{\n"use strict";\n{_joined(FILES)}}})();\n'


def _joined(names: Iterable[str]) -> str:
    return "\n".join((FOLDER / name).read_text(encoding="utf-8") for name in names)
