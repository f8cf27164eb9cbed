"""Layout of all reports: a self-contained HTML page without network access."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from cdpr.scene import colours
from cdpr.ui.report.player import assets

BEGINS, MADE_BY = b"<!DOCTYPE html>", b'<meta name="generator" content="cdpr">'
PAGE, STYLE = (Path(__file__).with_name(name) for name in ("page.html", "page.css"))


def page(
    title: str,
    subtitle: str,
    banner: str,
    links: Mapping[str, str],
    parts: Iterable[str],
    data: Mapping[str, Any] | None = None,
) -> str:
    """Return a complete page.

    Args:
        title: plain text.
        subtitle: plain text.
        banner: HTML.
        links: names of the parts by their ids, for the navigation.
        parts: HTML.
        data: player data, if the page has a player.
    """
    navigation = [f'<li><a href="#{key}">{escape(name)}</a></li>' for key, name in links.items()]
    return Template(PAGE.read_text(encoding="utf-8")).substitute(
        title=escape(title),
        subtitle=escape(subtitle),
        banner=banner,
        navigation="\n".join(navigation),
        sections="\n".join(parts),
        style=style() + ("" if data is None else assets.style()),
        script="" if data is None else assets.script(data),
    )


def is_page(content: bytes) -> bool:
    """Return True if `content` is a page of cdpr.

    Only the head before the title is checked, because it contains no user text.
    """
    head, title, _ = content.partition(b"<title>")
    return bool(title) and head.startswith(BEGINS) and MADE_BY in head


def style() -> str:
    """Return the style of all pages."""
    dark = "".join(f" --of-{light[1:]}: {dark};" for light, dark in colours.DARK.items())
    figures = f"@media screen and (prefers-color-scheme: dark) {{ :root {{{dark} }} }}\n"
    return assets.ground() + STYLE.read_text(encoding="utf-8") + figures


def banner(mood: str, claim: str, rest: str = "") -> str:
    """Return a banner as HTML: a claim, followed by `rest`; `mood` is "good", "warn" or "bad"."""
    return f'<p class="banner {mood}" role="status"><strong>{claim}</strong>{rest}</p>'


def section(key: str, body: str) -> str:
    """Return a part as wide as the page."""
    return f'<section id="{key}" class="wide">\n{body}\n</section>'


def figure(key: str, title: str, svg: str, caption: str, *, live: str = "", minor: bool = False, kind: str = "") -> str:
    """Return a figure with its caption.

    Args:
        key: id of the figure.
        title: HTML.
        svg: HTML; shown in print and without scripts if `live` is given.
        caption: HTML.
        live: HTML that the script fills.
        minor: omit the figure in print.
        kind: CSS class of the box.
    """
    still = f'<div class="scroll{" static" * bool(live)}">{svg}</div>\n' if svg else ""
    kind = f"{kind} minor".strip() if minor else kind
    style = f' class="{kind}"' if kind else ""
    if live:
        caption = f'<details class="about"><summary>About this figure</summary>{caption}</details>'
    return f'<figure id="{key}"{style}>\n<h2>{title}</h2>\n{live}{still}<figcaption>{caption}</figcaption>\n</figure>'


def hall(figures: Iterable[str], kind: str) -> str:
    """Return figures in a box of the CSS class `kind`."""
    return f'<div class="{kind}">\n' + "\n".join(figures) + "\n</div>"


def theatre(scene: str, gallery: Iterable[str] = ()) -> str:
    """Return the scene with its plots beside it in a separate box: while the plots scroll, the scene stays in view."""
    beside = list(gallery)
    inside = [hall([scene], "hall" if beside else "hall alone"), *([hall(beside, "gallery")] if beside else [])]
    return hall(inside, "theatre wide")


def panels(key: str) -> str:
    """Return the placeholder that the script fills with the panels of this name."""
    return f'<div class="panels live" data-panels="{key}"></div>\n'


def swatch(look: Mapping[str, Any]) -> str:
    """Return a colour sample for tables."""
    light = look["color"]
    of = f' data-thing="{escape(look["thing"])}"' if "thing" in look else ""
    return f'<span class="key paired" style="--light:{light};--dark:{colours.DARK.get(light, light)}"{of}></span>'


def table(rows: Iterable[tuple[str, ...]], titles: tuple[str, ...] = (), *, numeric: bool = True) -> str:
    """Return a table of HTML cells; the first cell of each row is its heading. Tables that are too wide scroll."""
    kind = ' class="n"' if numeric and titles else ""
    out = ['<div class="scroll"><table>']
    if titles:
        rest = "".join(f"<th{kind}>{title}</th>" for title in titles[1:])
        out.append(f"<thead><tr><th>{titles[0]}</th>{rest}</tr></thead>")
    out.append("<tbody>")
    for row in rows:
        rest = "".join(f"<td{kind}>{cell}</td>" for cell in row[1:])
        out.append(f'<tr><th scope="row">{row[0]}</th>{rest}</tr>')
    return "\n".join([*out, "</tbody></table></div>"])
