"""The frame of every report: one HTML page that needs nothing else, neither network nor script."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from string import Template

PAGE = Path(__file__).with_name("page.html")


def page(title: str, subtitle: str, banner: str, links: Mapping[str, str], parts: Iterable[str]) -> str:
    """Return a whole page. `title` and `subtitle` are text; `links` name the parts by their ids, for the navigation;
    `banner` and `parts` are HTML.
    """
    navigation = [f'<li><a href="#{key}">{escape(name)}</a></li>' for key, name in links.items()]
    return Template(PAGE.read_text(encoding="utf-8")).substitute(
        title=escape(title),
        subtitle=escape(subtitle),
        banner=banner,
        navigation="\n".join(navigation),
        sections="\n".join(parts),
    )


def section(key: str, body: str) -> str:
    """A part as wide as the page."""
    return f'<section id="{key}" class="wide">\n{body}\n</section>'


def figure(key: str, title: str, svg: str, caption: str) -> str:
    """A figure with its caption; all but `key` is HTML."""
    return (
        f'<figure id="{key}">\n<h2>{title}</h2>\n<div class="scroll">{svg}</div>\n'
        f"<figcaption>{caption}</figcaption>\n</figure>"
    )


def table(rows: Iterable[tuple[str, ...]], titles: tuple[str, ...] = (), *, numeric: bool = True) -> str:
    """Rows of HTML cells; the first cell of each is its heading."""
    kind = ' class="n"' if numeric and titles else ""
    out = ["<table>"]
    if titles:
        rest = "".join(f"<th{kind}>{title}</th>" for title in titles[1:])
        out.append(f"<thead><tr><th>{titles[0]}</th>{rest}</tr></thead>")
    out.append("<tbody>")
    for row in rows:
        rest = "".join(f"<td{kind}>{cell}</td>" for cell in row[1:])
        out.append(f'<tr><th scope="row">{row[0]}</th>{rest}</tr>')
    return "\n".join([*out, "</tbody></table>"])
