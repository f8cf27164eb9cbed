"""Edits of YAML texts: what they mean comes out, and all else stays as it was written."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from cdpr.base.errors import CdprError
from cdpr.config.document import copied
from cdpr.config.yaml_text import flow
from cdpr.ui.gui.editor.edit import insert, read, remove, same, set_value

TEXT = """\
# Head.
robot: robots/caroca.yaml          # the robot
world: {gravity: [0, 0, -9.81]}    # m/s^2

simulation:
  # own line
  duration: 4.0   # s
  name: 'a'
trajectory:       # goes
  type: quintic
  to:
    position: [1.5,  0.5, 1.6]      # m
events:
- {type: wrench, time: 1.0}   # one
- type: sine
  time: 2  # two
"""


def test_a_number_changes_at_its_position() -> None:
    assert set_value(TEXT, ("simulation", "duration"), 5) == TEXT.replace("4.0   # s", "5   # s")
    assert set_value(TEXT, ("world", "gravity", 2), -9.8) == TEXT.replace("-9.81", "-9.8")


def test_a_list_changes_item_by_item() -> None:
    assert set_value(TEXT, ("trajectory", "to", "position"), [1.5, 0.5, 1.7]) == TEXT.replace("1.6]", "1.7]")


def test_a_text_keeps_its_quotes() -> None:
    assert set_value(TEXT, ("simulation", "name"), "b") == TEXT.replace("'a'", "'b'")
    assert 'name: "25 kg\'s"' in set_value(TEXT, ("simulation", "name"), "25 kg's")


def test_a_key_is_added_beside_its_siblings() -> None:
    assert set_value(TEXT, ("simulation", "seed"), 7) == TEXT.replace("name: 'a'\n", "name: 'a'\n  seed: 7\n")
    assert set_value(TEXT, ("world", "x"), 7) == TEXT.replace("-9.81]}", "-9.81], x: 7}")
    assert set_value(TEXT, ("log", "step"), 0.1) == TEXT + "log: {step: 0.1}\n"
    assert set_value(TEXT.rstrip("\n"), ("log", "step"), 0.1) == TEXT + "log: {step: 0.1}"


def test_a_key_is_removed_with_its_comment_and_no_other() -> None:
    assert remove(TEXT, ("simulation", "duration")) == TEXT.replace("  duration: 4.0   # s\n", "")
    assert remove(TEXT, ("world",)) == TEXT.replace("world: {gravity: [0, 0, -9.81]}    # m/s^2\n", "")
    assert remove(TEXT, ("events", 1, "type")) == TEXT.replace("- type: sine\n  time", "- time")
    with pytest.raises(CdprError, match=r"simulation\.seed: is not given"):
        remove(TEXT, ("simulation", "seed"))


def test_items_come_and_go() -> None:
    assert insert(TEXT, ("events",), {"type": "x"}) == TEXT + "- {type: x}\n"
    assert remove(TEXT, ("events", 0)) == TEXT.replace("- {type: wrench, time: 1.0}   # one\n", "")
    assert remove(remove(TEXT, ("events", 0)), ("events", 0)).endswith("events: []  # two\n")
    assert insert("a: []  # none\n", ("a",), {"b": 1}) == "a:  # none\n- {b: 1}\n"
    assert insert("a: [1, 2]\n", ("a",), 3) == "a: [1, 2, 3]\n"


def test_a_section_becomes_a_name_beside_its_key() -> None:
    assert "trajectory: x       # goes      # m\nevents" in set_value(TEXT, ("trajectory",), "x")


def test_a_shared_value_changes_where_it_is_changed_alone() -> None:
    text = "a: &d {r: 0.1}  # one\nb: *d\nc: *d\n"
    assert set_value(text, ("b", "r"), 0.2) == "a: &d {r: 0.1}  # one\nb: {r: 0.2}\nc: *d\n"
    assert set_value(text, ("a", "r"), 0.2) == "a: &d {r: 0.2}  # one\nb: {r: 0.1}\nc: {r: 0.1}\n"
    assert set_value(text, ("b",), 5) == "a: &d {r: 0.1}  # one\nb: 5\nc: *d\n"


def test_missing_items_are_rejected() -> None:
    with pytest.raises(CdprError, match=r"there is no events\[7\]"):
        set_value(TEXT, ("events", 7, "time"), 1)
    with pytest.raises(CdprError, match="not valid YAML"):
        set_value("a: [", ("a",), 1)
    with pytest.raises(CdprError, match="tab character"):
        set_value("a:\n\tb: 1\n", ("a", "b"), 1)


# Documents of all styles, and edits of them.

WORDS = st.sampled_from(["a", "b", "mass", "long_key", "x y", "1", "true", "é"])
SCALARS = st.one_of(
    st.integers(-1000, 1000),
    st.floats(allow_nan=False, allow_infinity=False, width=32),
    st.booleans(),
    st.none(),
    st.sampled_from(
        ["text", "two words", "", "1", "true", "# no comment", "a: b", "it's", 'say "x"', "é", "- x", "[", "a, b"]
    ),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=8,
)
DOCUMENTS = st.dictionaries(WORDS, VALUES, min_size=1, max_size=4)


class Writer:
    """Writes plain data in one of many ways, each line end with a comment of its own where it may have one."""

    def __init__(self, draw: Any) -> None:
        self.draw, self.comments, self.shared = draw, 0, {}

    def pick(self, *ways: str) -> str:
        return self.draw(st.sampled_from(ways))

    def comment(self) -> str:
        if self.draw(st.booleans()):
            return ""
        self.comments += 1
        return f"  # comment {self.comments} {{[\"'"

    def block(self, value: Any, indent: int) -> str:
        """Text after a colon or a dash, with its line end."""
        pad = " " * indent
        if isinstance(value, dict) and value and self.pick("block", "flow") == "block":
            rows = [f"{pad}{flow(key)}:{self.own(item, indent)}" for key, item in value.items()]
            return f"{self.anchor()}{self.comment()}\n" + "".join(rows)
        if isinstance(value, list) and value and self.pick("block", "flow") == "block":
            rows = [f"{pad}-{self.own(item, indent)}" for item in value]
            return f"{self.anchor()}{self.comment()}\n" + "".join(rows)
        text = self.inline(value, indent)
        return f" {text}\n" if text[:2] in ("|-", ">-") else f" {text}{self.comment()}\n"

    def own(self, value: Any, indent: int) -> str:
        lines = "" if self.draw(st.integers(0, 3)) else "\n"
        name = json.dumps(value)
        if name in self.shared and self.draw(st.booleans()):
            return f" *{self.shared[name]}{self.comment()}\n{lines}"
        text = self.block(value, indent + self.draw(st.integers(1, 3))) + lines
        if self.last:
            self.shared[name] = self.last
            self.last = ""
        return text

    last = ""

    def anchor(self) -> str:
        return ""

    def inline(self, value: Any, indent: int) -> str:
        if value in ("text", "two words") and (way := self.pick("", "|-", ">-")):
            return f"{way}{self.comment()}\n{' ' * (indent + 2)}{value}"
        if value == "two words" and self.pick("one", "many") == "many":
            return f"two\n{' ' * (indent + 3)}words"
        if isinstance(value, str) and value.isprintable() and self.pick("plain", "single") == "single":
            return "'" + value.replace("'", "''") + "'"
        if value is None and self.pick("word", "~") == "~":
            return "~"
        if isinstance(value, list) and value and self.pick("one", "many") == "many":
            pad = "\n" + " " * (indent + 4)
            return "[" + f",{pad}".join(flow(item) for item in value) + ("," if self.draw(st.booleans()) else "") + " ]"
        if isinstance(value, dict) and self.pick("one", "many") == "many":
            inner = ", ".join(f"{json.dumps(key)}: {flow(item)}" for key, item in value.items())
            return f"{{ {inner} }}"
        return flow(value)


class Sharing(Writer):
    """Names some values, and uses aliases for equal ones."""

    def block(self, value: Any, indent: int) -> str:
        text = super().block(value, indent)
        if isinstance(value, (list, dict)) and self.draw(st.booleans()):
            self.last = name = f"n{len(self.shared)}_{self.comments}_{indent}"
            if name in self.named:
                self.last = ""
                return text
            self.named.add(name)
            return f" &{name}{text}"
        return text

    def __init__(self, draw: Any) -> None:
        super().__init__(draw)
        self.named: set[str] = set()


@st.composite
def texts(draw: Any) -> str:
    data = draw(DOCUMENTS)
    writer = Sharing(draw)
    rows = ["# head\n" if draw(st.booleans()) else "", "---\n" if draw(st.booleans()) else ""]
    for key, value in data.items():
        rows.append(f"{flow(key)}{writer.pick(':', ' :')}{writer.own(value, 0)}")
    text = "".join(rows) + ("...\n" if draw(st.integers(0, 3)) == 0 else "")
    if draw(st.booleans()):
        text = text.rstrip("\n")
    if draw(st.integers(0, 3)) == 0:
        text = text.replace("\n", "\r\n")
    return text


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [path] if path else []
    for part, item in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        found += places(item, (*path, part))
    return found


def holder(data: Any, path: tuple[Any, ...]) -> Any:
    for part in path:
        data = data[part]
    return data


def comments(text: str) -> list[str]:
    return [line.partition("# comment ")[2].split()[0] for line in text.splitlines() if "# comment " in line]


@pytest.mark.slow
@settings(max_examples=150, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(texts(), st.data())
def test_every_edit_comes_out_and_disturbs_nothing(text: str, data: Any) -> None:
    before = read(text)
    path = data.draw(st.sampled_from(places(before)))
    parent = holder(copied(before), path[:-1])
    meant = copied(before)
    kinds = ["set", "add"] if len(before) == 1 and len(path) == 1 else ["set", "remove", "add"]
    kind = data.draw(st.sampled_from(kinds))
    if kind == "remove":
        del holder(meant, path[:-1])[path[-1]]
        after = remove(text, path)
    elif kind == "set":
        value = data.draw(VALUES)
        holder(meant, path[:-1])[path[-1]] = value
        after = set_value(text, path, value)
    else:
        value = data.draw(VALUES)
        if isinstance(parent, list):
            holder(meant, path[:-1]).append(value)
            after = insert(text, path[:-1], value)
        else:
            holder(meant, path[:-1])["new"] = value
            after = set_value(text, (*path[:-1], "new"), value)
    assert same(read(after), meant)
    if "\r\n" in text:
        assert after.count("\n") == after.count("\r\n")
    kept = comments(after)
    assert kept == sorted(kept, key=lambda number: comments(text).index(number))  # none twice, none out of order
    if kind == "add":
        assert set(kept) == set(comments(text))


def test_no_edit_is_none() -> None:
    assert set_value(TEXT, ("simulation", "duration"), 4.0) == TEXT
