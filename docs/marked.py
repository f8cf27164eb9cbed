"""Generated parts of a Markdown file: text between <!-- NAME --> and <!-- end of NAME -->."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence


def rewritten(text: str, parts: Mapping[str, Callable[[], str]]) -> str:
    """The text with each of its marked parts written anew."""
    for mark, content in parts.items():
        new = content() + "\n"
        pattern = rf"(?<=<!-- {mark} -->\n).*?(?=<!-- end of {mark} -->)"
        text, count = re.subn(pattern, lambda _, new=new: new, text, flags=re.DOTALL)
        if count != 1:
            raise SystemExit(f"there are {count} places for {mark}, not one")
    return text


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(cells) + " |" for cells in (titles, *rows)]
    return "\n".join([lines[0], "|---" * len(titles) + "|", *lines[1:]])
