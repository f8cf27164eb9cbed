"""Reading YAML: positions, and everything that is refused before it costs anything."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from cdpr.base.problems import Mark
from cdpr.config import yaml_nodes
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import MAX_BYTES, MAX_DEPTH, MAX_NODES, parse, parse_value
from cdpr.config.yaml_text import dump

PARSERS = [pytest.param(yaml.SafeLoader, id="pure")]
if hasattr(yaml, "CSafeLoader"):
    PARSERS.append(pytest.param(yaml.CSafeLoader, id="libyaml"))

both = pytest.mark.parametrize("parser", PARSERS)


def read(content, parser=yaml.SafeLoader):
    found = Problems()
    return parse(content, "f.yaml", found, parser=parser), [str(problem) for problem in found.items]


def refused(content, parser=yaml.SafeLoader) -> str:
    document, found = read(content, parser)
    assert document is None
    assert len(found) == 1
    return found[0]


@both
def test_data_and_positions(parser):
    document, found = read('a: 1\nb:\n  - {c: "x", d: [1.5, ~]}\n  - yes\n', parser)
    assert not found
    assert document.data == {"a": 1, "b": [{"c": "x", "d": [1.5, None]}, "yes"]}
    assert document.keys[("b", 0, "d")] == Mark("f.yaml", 3, 14)
    assert document.values[("b", 0, "d", 1)] == Mark("f.yaml", 3, 23)
    assert document.values[("b", 1)] == Mark("f.yaml", 4, 5)


@both
@pytest.mark.parametrize("text", ["---\na: 1\n", "a: 1\n...\n", "---\na: 1\n...\n# end\n", "a: 1\r\n", "{a: 1}"])
def test_other_ways_to_write_one_document(parser, text):
    assert read(text, parser)[0].data == {"a": 1}


@both
def test_positions_count_characters_not_bytes(parser):
    document, _ = read("ä: 'öß'\nü: {é: 1, x: 2}\n".encode(), parser)
    assert document.values[("ü", "x")] == Mark("f.yaml", 2, 14)


@both
@pytest.mark.parametrize("quoted", ["'5'", '"5"', "|-\n  5", ">-\n  5"])
def test_quoted_scalars_and_blocks_are_texts(parser, quoted):
    assert read(f"a: {quoted}\n", parser)[0].data == {"a": "5"}


@both
@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("", "1:1", "the file is empty"),
        ("# only a comment\n", "1:1", "the file is empty"),
        ("5\n", "1:1", "a mapping"),
        ("- a\n- b\n", "1:1", "got a list"),
        ("a: 1\n---\nb: 2\n", "2:1", "a second document"),
        ("%YAML 1.1\n---\na: 1\n", "1:1", "directives"),
        ("b: *x\n", "1:4", "no anchor &x precedes this alias"),
        ("&k a: 1\n", "1:1", "a key takes no anchor"),
        ("a: &x k\n*x : 1\n", "2:1", "a key takes no anchor and no alias"),
        ("a: &x [*x]\n", "1:8", "the alias *x is inside its own anchor"),
        ("a: &x 1\nb: &x 2\n", "2:4", "the anchor &x is given twice"),
        ("a: &x {b: 1}\nc: {<<: *x}\n", "2:5", "merge keys"),
        ("a: {<<: {b: 1}}\n", "1:5", "merge keys"),
        ("a: !!python/object/apply:os.system [id]\n", "1:4", "tags are not supported"),
        ("a: !!int 5\n", "1:4", "tags are not supported"),
        ("a: !foo 5\n", "1:4", "tags are not supported"),
        ("a: ! 5\n", "1:4", "tags are not supported"),
        ("!!str a: 5\n", "1:1", "tags are not supported"),
        ("? [a]\n: 1\n", "1:3", "a key must be a word"),
        ("~: 1\n", "1:1", "a key is missing"),
        ("a:\n\t- 1\n", "2:1", "tab character"),
        ("<?xml version='1.0'?>\n<a>\n\t<b/>\n</a>\n", "1:1", "expected YAML, got XML; 'cdpr import' reads robots"),
        ("\n<mujoco/>\n", "1:1", "expected YAML, got XML"),
        ("a: 1\n\tb: 2\n", "2:1", "tab character"),
        ("a: [1, 2\n", None, "not valid YAML"),
        ("a: b: c\n", "1:5", "not valid YAML"),
        ("a: 'x\n", None, "not valid YAML"),
        ("a: @x\n", "1:4", "not valid YAML"),
        ("a: 1\n b: 2\n", "2:3", "not valid YAML"),
        ("a: 1\nb: x\0y\n", "2:5", "control character U+0000"),
        ("a: x\x07\n", "1:5", "control character U+0007"),
        ("a: x\x7f\n", "1:5", "control character U+007F"),
        ("a: x\x85y\n", "1:5", "control character U+0085"),
        ("a: x\u2028y\n", "1:5", "control character U+2028"),
        ("\ufeffa: 1\n", "1:1", "byte order mark"),
    ],
)
def test_refused(parser, text, where, what):
    for content in (text, text.encode()):
        line = refused(content, parser)
        assert what in line
        assert line.startswith(f"f.yaml:{where}: " if where else "f.yaml:")


@both
def test_aliases_are_what_was_written_at_their_anchors(parser):
    """As PyYAML dumps an object that a dict holds twice; also within each other, and not one object for two."""
    shared = [1.0, {"b": "x"}]
    data = {"a": shared, "b": {"c": shared, "d": {"e": shared[1]}}, "f": [shared, shared]}
    text = yaml.safe_dump(data)
    assert "*id001" in text
    assert "&id002" in text
    document, found = read(text, parser)
    assert not found
    assert document.data == data
    assert document.data["a"] is not document.data["f"][0]
    assert document.values[("b", "c", 0)] == document.values[("a", 0)]


@both
def test_errors_in_an_alias_are_reported_at_their_position(parser):
    _, found = read("a: &x {c: 1, c: 2}\nb: *x\n", parser)
    assert found == [f"f.yaml:1:14: {key}.c: given twice; the first is in line 1, remove one" for key in "ab"]


@both
def test_a_tab_in_a_comment_is_fine(parser):
    assert read("a: 1  #\tcomment\n", parser)[0].data == {"a": 1}


def test_an_escape_that_is_no_character_is_refused():
    assert "not a character" in refused('a: "\\ud800"\n')
    assert "not a character" in refused('"\\ud800": 1\n')


@pytest.mark.parametrize(
    ("content", "where"),
    [(b"a: 1\nb: \xe9t\xe9\n", "2:4"), ("a: 1".encode("utf-16"), "1:1"), (b"\xff\xfe\x00", "1:1")],
)
def test_other_encodings_are_refused_where_they_show(content, where):
    assert refused(content).startswith(f"f.yaml:{where}: not UTF-8 text (byte 0x")


@both
def test_duplicate_keys_name_both_lines_and_reading_continues(parser):
    document, found = read("a: 1\nb: {c: 1, c: 2}\na: 3\nb: 4\nb: 5\n", parser)
    assert document is not None
    assert found == [
        "f.yaml:2:11: b.c: given twice; the first is in line 2, remove one",
        "f.yaml:3:1: a: given twice; the first is in line 1, remove one",
        "f.yaml:4:1: b: given twice; the first is in line 2, remove one",
        "f.yaml:5:1: b: given twice; the first is in line 2, remove one",
    ]


@both
def test_a_huge_integer_is_one_problem(parser):
    _, found = read(f"a: {'7' * 5000}\nb: 1\n", parser)
    assert found == ["f.yaml:1:4: a: a whole number of 5000 digits is too large"]


@both
@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a: " + "[" * 30_000 + "]" * 30_000, f"nested more than {MAX_DEPTH} deep"),
        ("a: " + "{a: " * 30_000, f"nested more than {MAX_DEPTH} deep"),
        ("".join(f"{' ' * i}a:\n" for i in range(600)), f"nested more than {MAX_DEPTH} deep"),
        ("- " * 30_000, f"nested more than {MAX_DEPTH} deep"),
        ("a: [" + "1," * 100_000 + "]", f"more than {MAX_NODES} values"),
        ("".join(f"k{i}: 1\n" for i in range(MAX_NODES)), f"more than {MAX_NODES} values"),
        ("a: " + "x" * 10_000_000, "larger than 256 KiB"),
        ("k0: &a0 [x, x]\n" + "".join(f"k{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 30)), "values"),
        ("k0: &a0 [x]\n" + "".join(f"k{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 500)), f"more than {MAX_DEPTH} deep"),
        ("a: &a [" + "1," * 5000 + "]\nb: [" + "*a," * 5000 + "]\n", f"more than {MAX_NODES} values"),
    ],
)
@pytest.mark.usual("*-libyaml")
def test_bombs_are_refused_at_once(parser, text, what, monkeypatch):
    """No more values are read than are allowed, plus the first one too many."""
    looked_at, value = [], yaml_nodes._Composer._value
    monkeypatch.setattr(yaml_nodes._Composer, "_value", lambda *given: [looked_at.append(None), value(*given)][1])
    assert what in refused(text, parser)
    assert len(looked_at) <= MAX_NODES + 1


@both
@pytest.mark.usual("libyaml")
def test_the_limits_themselves_are_allowed(parser):
    depth = MAX_DEPTH - 1  # the mapping around is one
    assert read("a: " + "[" * depth + "]" * depth, parser)[0] is not None
    assert "nested" in refused("a: " + "[" * (depth + 1) + "]" * (depth + 1), parser)
    full = ", ".join("1" for _ in range(MAX_NODES - 3))  # and the mapping, its key and the list
    assert read(f"a: [{full}]", parser)[0] is not None
    assert "values" in refused(f"a: [{full}, 1]", parser)
    text = "a: 1 #".ljust(MAX_BYTES)
    assert read(text, parser)[0] is not None
    assert "KiB" in refused(text + " ", parser)


def test_no_code_runs(tmp_path):
    canary = tmp_path / "canary"
    for tag in ("object/apply:os.system", "object/new:os.system", "name:os.system", "module:os"):
        refused(f"a: !!python/{tag} ['touch {canary}']\n")
    assert not canary.exists()


def test_values_of_overrides_follow_the_same_rules():
    assert parse_value("[1, 2e-3, x, {a: true}]") == [1, 0.002, "x", {"a": True}]
    assert parse_value("") is None
    assert parse_value("010") == "010"
    for text, what in [
        ("[1,", "not valid YAML"),
        ("*a", "no anchor &a"),
        ("{a: 1, a: 2}", "a: given twice"),
        ("!x 1", "tags"),
    ]:
        with pytest.raises(ValueError, match=what):
            parse_value(text)


PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**300), 10**300)
    | st.floats(allow_nan=False)
    | st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
    | st.sampled_from(
        ["1e-3", "no", "true", "null", "~", "010", "- a", "#", "a: b", "x #y", "", " a", "a ", "'", '"', "<<"]
    ),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text(st.characters(exclude_categories=["Cs"]), max_size=8), inner, max_size=4)
    ),
    max_leaves=20,
)


@pytest.mark.slow
@given(
    st.dictionaries(
        st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8),
        PLAIN,
        min_size=1,
        max_size=5,
    )
)
def test_round_trip_of_written_files(data):
    for (parser,) in (entry.values for entry in PARSERS):
        document, found = read(dump(data), parser)
        assert not found
        assert repr(document.data) == repr(data)  # repr distinguishes 1, 1.0 and true


def test_floats_are_written_by_repr():
    assert dump({"a": 1e-05, "b": [0.1, 1e22], "c": {"d": []}}) == "a: 1e-05\nb: [0.1, 1e+22]\nc:\n  d: []\n"


@both
@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ("a: 1\nb:\n  c: 2\n  d\ne: 3\n", "4:3", "a colon is missing after this word"),
        ("a: 1\nb: {c: 2\nd: 3\n", "2:4", "the bracket { that opens here"),
        ("a: 1\nb: [c, 2\nd: 3\n", "2:4", "the bracket [ that opens here"),
        ('a: 1\nb: "c\nd: 3\n', "2:4", "the quote that begins here"),
        ("a: 1\nb: {c: 2 d: 3}\n", "2:", "bracket {"),  # in one line: where it is noticed
        ("a:\n  b: 1\n c: 2\n", "3:2", "block mapping"),
    ],
)
def test_a_syntax_error_is_at_its_start(parser, text, place, what):
    line = refused(text, parser)
    assert line.startswith(f"f.yaml:{place}")
    assert what in line
