"""Hostile files of others, each in a process of its own: one clear message, and nothing read that was not sent."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import zipfile

import pytest
from caspr_cases import bodies, cables
from plugin_cases import SUCCESSOR

pytest.importorskip("websockets")

from cdpr.base.errors import CdprError
from cdpr.formats.read.import_files import ImportResult
from cdpr.ui.gui import reading
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.incoming import Incoming


def archive():
    """An archive that is 10 MB when it is unpacked, and 10 kB before."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        made.writestr("crane.yaml", SUCCESSOR + "#" * 10_000_000)
    return file.getvalue()


ENTITIES = '<!DOCTYPE sdf [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><sdf>&b;</sdf>'


HOSTILE = {
    "a.sdf": (b"<sdf version='1.6'><model></sdf>", "a.sdf:1: invalid XML"),
    "b.sdf": (ENTITIES.encode(), "b.sdf:1: it declares the entity 'a': entities are not resolved"),
    "c.yaml": (SUCCESSOR.encode().replace(b"Grey", b"\xff\xfe"), "c.yaml:2:29: not UTF-8 text (byte 0xff)"),
    "d.yaml": (SUCCESSOR.encode() + b"#" * 300_000, "d.yaml:1:1: larger than 256 KiB"),
    "e.xml": (b"<bodies_system>" + b"<a>" * 100, "or nested more than 64 deep"),
    "f.yaml": (archive(), "f.yaml: unknown format; supported are CASPR"),
}


def read(files, **more):
    body = b"".join(files.values())
    sizes = [{"name": name, "size": len(content)} for name, content in files.items()]
    return Incoming().read(Broadcast().join(), files=sizes, body=body, **more)


@pytest.mark.slow
def test_hostile_files_end_in_one_message_each(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (message,) = read({name: content for name, (content, _) in HOSTILE.items()})
    assert [source["source"] for source in message["sources"]] == list(HOSTILE)
    for source, (_, said) in zip(message["sources"], HOSTILE.values(), strict=True):
        assert said in source["error"]
        assert source["files"] == []
    assert str(tmp_path) not in json.dumps(message)
    with pytest.raises(CdprError, match=r"a\.zip: unknown format"):
        read({"a.zip": archive()})
    with pytest.raises(CdprError, match=r"none of these files has a supported format: \.xml"):
        read({"a.zip": archive(), "b.zip": archive()})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_model_reads_nothing_but_what_came_with_it(tmp_path, monkeypatch):
    (tmp_path / "secret.traj").write_text("root:x:0:0\n")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    places = (f"{tmp_path}/secret.traj", "../secret.traj", "sub/../../secret.traj")
    motions = "".join(f'<file_trajectory id="m{k}" filename="{place}"/>' for k, place in enumerate(places))
    motions = f"<trajectories><joint_trajectories>{motions}</joint_trajectories></trajectories>"
    model = {"a_bodies.xml": bodies(), "a_cables.xml": cables(), "a_trajectories.xml": motions}
    (message,) = read({name: text.encode() for name, text in model.items()})
    (source,) = message["sources"]
    assert [each["name"] for each in source["files"]] == ["a.yaml"]
    assert sum("leads out of the folder of the model" in text for text in source["left_out"]) == len(places)
    assert "root:x" not in json.dumps(message)


@pytest.mark.slow
def test_python_files_that_come_along_are_not_run(tmp_path):
    evil = f"open({str(tmp_path / 'run')!r}, 'w')".encode()
    names = ("json.py", "yaml.py", "sitecustomize.py", "cdpr.py", "mujoco.py")
    (message,) = read({"crane.yaml": SUCCESSOR.encode(), **dict.fromkeys(names, evil)})
    assert [source["error"] for source in message["sources"]] == [""]
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_displays_and_outputs_are_limited(monkeypatch):
    monkeypatch.setattr("cdpr.ui.gui.incoming.MOST_LINES", 2)
    (message,) = read({"crane.yaml": SUCCESSOR.encode()})
    assert message["sources"][0]["left_out"][2:] == ["and 5 more"]
    made = ImportResult("a.xml", {"a.yaml": "x" * 6, "b.csv": "y" * 5})
    monkeypatch.setattr("cdpr.formats.read.import_files.import_any", lambda path: [made])
    monkeypatch.setattr(reading, "MOST_MADE", 11)
    assert reading._answer({"path": "a.xml"}) == {"taken": [vars(made)]}
    monkeypatch.setattr(reading, "MOST_MADE", 10)
    assert "MiB would be written" in reading._answer({"path": "a.xml"})["error"]


def run(program, asked):
    """Answers of a process that starts with a program."""
    code = f"import os; from cdpr.ui.gui import reading; {program}; reading.main(os.getppid())"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_printed_output_is_not_an_answer():
    assert run("reading._answer = lambda asked: {'said': print('x')}", {}) == {"said": None}


def test_internal_errors_are_reported(monkeypatch):
    def fails(error):
        def import_any(path):
            raise error

        return import_any

    monkeypatch.setattr("cdpr.formats.read.import_files.import_any", fails(KeyError("x")))
    answer = reading._answer({"path": "a.xml"})
    assert answer["fault"] == "KeyError: 'x'"
    assert "Traceback" in answer["trace"]
