"""Import and export by the socket of a window: what comes in, what goes out, and that neither harms what is edited."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import zipfile
from base64 import b64decode

import pytest
import yaml
from conftest import ROOT
from plugin_cases import SUCCESSOR, TRAJECTORY
from show_cases import Looker, wait
from spread import sampled

pytest.importorskip("websockets")

from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

import cdpr
from cdpr.formats import import_file
from cdpr.formats.write.export_model import begin, export
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.editor import Editor
from cdpr.ui.gui.exchange import Exchange
from cdpr.ui.gui.incoming import Incoming
from cdpr.ui.gui.server import MOST_BYTES
from cdpr.ui.gui.window import Window

CAROCA = ROOT / "scenarios" / "caroca.yaml"
ROBOT = SUCCESSOR.encode()
UNLIMITED = """<mujoco><worldbody><site name="a" pos="0 0 2"/>
<body name="load"><joint type="slide" axis="0 0 1"/><geom size="0.1" mass="1"/>
<site name="b" pos="0 0 0.1"/></body></worldbody>
<tendon><spatial name="right"><site site="a"/><site site="b"/></spatial></tendon>
<actuator><motor tendon="right" gear="-1"/></actuator></mujoco>
"""
FILES = {"crane.yaml": ROBOT, "way.yaml": TRAJECTORY.encode()}


@pytest.fixture(scope="module")
def window():
    log = []
    with Window(Editor(str(CAROCA)), log.append, port=0) as made:
        made.begin()
        wait(made._board, "status", lambda status: status["phase"] == "ready")
        yield made
    assert log == []


@pytest.fixture
def looker(window):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        found = Looker(opened)
        form = found.get("form")
        if form["file"] != str(CAROCA) or form["modified"] or not form["applied"]:  # by the test before
            found.send(do="open", name=str(CAROCA))
            found.get("form", lambda form: form["file"] == str(CAROCA) and form["applied"])
        found.get("status", lambda status: status["phase"] == "ready")
        yield found


def upload(looker, files, **more):
    sizes = [{"name": name, "size": len(content)} for name, content in files.items()]
    said = json.dumps({"do": "import", "files": sizes, **more}).encode()
    looker.socket.send(said + b"\n" + b"".join(files.values()))


def answer(looker, about):
    """The first message about something."""
    while True:
        message = json.loads(looker.socket.recv(timeout=60))
        if message.get("about") == about:
            return message


def failed(looker, about):
    message = answer(looker, about)
    assert message["level"] == "error", message
    assert "\n" not in message["text"]
    assert "internal error" not in message["text"]
    return message["text"]


def command(*words):
    """Export in another process: a command that ends would end the window's thread."""
    subprocess.run([sys.executable, "-m", "cdpr", "export", CAROCA, *words], check=True, capture_output=True)


def test_what_is_uploaded_is_shown_then_written_and_opened(looker, tmp_path):
    upload(looker, FILES, trajectory="way.yaml")
    shown = answer(looker, "import")
    (source,) = shown["sources"]
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    known = import_file(tmp_path / "crane.yaml", trajectory=str(tmp_path / "way.yaml"))
    assert {each["name"]: each["text"] for each in source["files"]} == known.files
    plain = [text.replace(f"{tmp_path}/", "") for text in known.left_out]
    assert (source["source"], source["left_out"]) == ("crane.yaml", plain)  # no folder that is gone by now
    assert "the file does not name the node that plays it" in source["warnings"][0]

    out = tmp_path / "mine"
    assert not out.exists()
    out.mkdir()
    (out / "crane_way.yaml").write_text("# hours of work\n")
    looker.send(do="take", out=str(out), open="crane_way.yaml")
    assert f"'{out}/crane_way.yaml' exists already and is not overwritten: choose another folder" in failed(
        looker, "take"
    )
    assert [path.name for path in out.iterdir()] == ["crane_way.yaml"]
    looker.send(do="take", out=str(out / "new"), open="nowhere.yaml")
    assert "open: one of crane.yaml, crane_way.yaml is expected" in failed(looker, "take")
    looker.send(do="take", out=str(out / "new"), open="crane_way.yaml")  # nothing is lost
    form = looker.get("form", lambda form: form["file"] != str(CAROCA))
    assert answer(looker, "take")["text"] == f"imported: {out}/new/crane.yaml, {out}/new/crane_way.yaml"
    assert (form["file"], form["applied"], form["problems"]) == (f"{out}/new/crane_way.yaml", True, [])
    assert (out / "crane_way.yaml").read_text() == "# hours of work\n"
    assert {path.name: path.read_text() for path in (out / "new").iterdir()} == known.files
    looker.send(do="undo")
    assert looker.get("form")["file"] == str(CAROCA)
    looker.send(do="take", out=str(out / "again"), open="crane.yaml")
    assert "there is nothing to write" in failed(looker, "take")


@pytest.mark.slow
def test_of_a_folder_all_that_can_be_read_is_shown(looker, tmp_path):
    for folder, name, text in (("a", "crane.yaml", SUCCESSOR), ("b", "crane.yaml", SUCCESSOR), ("b", "x.sdf", "<sdf")):
        (tmp_path / "in" / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / "in" / folder / name).write_text(text)
    looker.send(do="import", path=str(tmp_path / "in"))
    first, second, third = answer(looker, "import")["sources"]
    assert [each["name"] for each in first["files"]] == ["crane.yaml"]
    assert [each["name"] for each in second["files"]] == ["crane_2.yaml"]
    assert "invalid XML" in third["error"]
    looker.send(do="take", out=str(tmp_path / "out"), open="crane.yaml")
    answer(looker, "take")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["crane.yaml", "crane_2.yaml"]
    assert cdpr.load_robot(tmp_path / "out" / "crane.yaml").m == 4


def test_what_was_read_belongs_to_its_window_alone(window, looker, tmp_path):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        other = Looker(opened)
        upload(other, {"crane.yaml": ROBOT})
        answer(other, "import")
        looker.send(do="take", out=str(tmp_path / "out"), open="crane.yaml")
        assert "there is nothing to write" in failed(looker, "take")
    assert not (tmp_path / "out").exists()
    looker.send(do="yaml")
    looker.get("yaml")
    assert not any(message["kind"] == "imported" for message in looker.seen)


@sampled(
    lambda words, said: "MIN < MAX" not in said,  # asks a process
    ("words", "said"),
    [
        ({}, "choose files, or enter a path"),
        ({"path": 3}, "the name of a file is expected, got 3"),
        ({"path": "nowhere.sdf"}, "there is no file 'nowhere.sdf'"),
        ({"path": "nowhere.sdf", "force": True}, "import: 'force' is not known"),
        ({"path": "nowhere.sdf", "cable_set": [1]}, "cable_set: a name is expected, got"),
        ({"path": "nowhere.sdf", "tension": 5}, "tension: two numbers are expected"),
        ({"path": "nowhere.sdf", "tension": ["", 5]}, "tension: two numbers are expected"),
        ({"path": "nowhere.sdf", "tension": [5, 1]}, "tension: expected 0 <= MIN < MAX"),
        ({"path": "nowhere.sdf", "seconds": 0}, "seconds: a number above 0"),
        ({"path": "nowhere.sdf", "seconds": "x"}, "seconds: a number above 0"),
        ({"files": {"a": 1}}, "100 files at most are taken"),
        ({"files": [{}] * 101}, "100 files at most are taken"),
        ({"files": [1]}, "a name without folders, of 255 bytes at most, is expected of a file, got null"),
        ({"files": [{"name": "a.xml", "size": 1}]}, "a.xml: the received size differs from the announced one"),
        ({"files": [{"name": "a.xml", "size": -1}]}, "a.xml: the received size differs from the announced one"),
        ({"files": [{"name": "a.xml", "size": 0}, {"name": "a.xml", "size": 0}]}, "two files are called 'a.xml'"),
        ({"files": [{"name": "a.xml", "size": 0}], "trajectory": "../b"}, "'../b' is not among the files"),
        ({"files": [{"name": "a.xml", "size": 0}], "trajectory": "a.xml"}, "a trajectory alone is no robot"),
    ],
)
def test_what_makes_no_sense_is_told(looker, words, said):
    looker.send(do="import", **words)
    assert said in failed(looker, "import")


@pytest.mark.slow
def test_limits_that_a_file_has_not_are_given(looker):
    unlimited = UNLIMITED.encode()
    upload(looker, {"a.xml": unlimited})
    assert "(the fields Tension limits)" in failed(looker, "import")
    upload(looker, {"a.xml": unlimited}, tension=[5, 500], seconds=20)
    (source,) = answer(looker, "import")["sources"]
    cables = yaml.safe_load(source["files"][0]["text"])
    assert cables["tension"] == {"min": 5.0, "max": 500.0}


@pytest.mark.parametrize(
    "name",
    ["../a.xml", "/etc/a", "..", ".", "", "a/b.xml", "..\\a.xml", "a\0.xml", "a\n.xml", "\ud800.xml", 256 * "a"],
)
def test_names_that_could_lead_anywhere_are_refused(looker, name):
    looker.send(do="import", files=[{"name": name, "size": 0}])
    assert "a name without folders, of 255 bytes at most, is expected" in failed(looker, "import")


def test_more_than_was_said_is_refused(looker):
    looker.socket.send(b'{"do": "import", "files": [{"name": "a.xml", "size": 1}]}\nab')
    assert "received more data than announced" in failed(looker, "import")
    looker.socket.send(b'{"do": "undo"}\nab')
    assert "'body' is not known" in looker.get("message")["text"]


@pytest.mark.parametrize("message", [b" " * (MOST_BYTES + 1), b" " * (MOST_BYTES + 1) + b"\n{}"])
def test_what_is_said_of_files_is_short(window, message):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        opened.send(message)
        with pytest.raises(ConnectionClosedError, match="1009"):
            Looker(opened).get("nothing")


@pytest.mark.slow
def test_what_is_exported_is_what_the_command_writes(looker, tmp_path):
    looker.send(do="export", to="sdf", style="legs", version="1.6")
    file = answer(looker, "export")
    command("--to", "sdf", "--style", "legs", "--sdf-version", "1.6", "--out", tmp_path / "out")
    assert b64decode(file["content"]) == (tmp_path / "out").read_bytes()
    assert answer(looker, "export")["text"] == "exported: caroca.sdf"
    for to, name in (("mjcf", "caroca.xml"), ("urdf", "caroca.urdf")):
        looker.send(do="export", to=to)
        file = answer(looker, "export")
        assert b64decode(file["content"]).decode() == export(begin(cdpr.load_scenario(CAROCA)), to)
        assert answer(looker, "export")["text"] == f"exported: {name}"


@pytest.mark.slow
def test_packages_come_as_an_archive(looker, tmp_path):
    found = []
    for _ in range(2):
        looker.send(do="export", to="ros2")
        found.append(answer(looker, "export"))
        answer(looker, "export")
    assert found[0] == found[1]
    assert found[0]["name"] == "caroca_ros2.zip"
    command("--to", "ros2", "--out", tmp_path / "caroca_ros2")
    written = {str(path.relative_to(tmp_path)): path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with zipfile.ZipFile(io.BytesIO(b64decode(found[0]["content"]))) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == written


def test_what_the_form_says_is_exported_saved_or_not(looker):
    looker.send(do="edit", path="robot.platform.mass", value=141.5)
    looker.send(do="export", to="urdf")
    assert b'<mass value="141.5" />' in b64decode(answer(looker, "export")["content"])
    looker.send(do="edit", path="robot.platform.mass", value=-1)
    looker.send(do="edit", path="robot.tension.min", value="low")
    looker.send(do="export", to="urdf")
    answer(looker, "export")
    assert "not exported: 2 problems, the first: " in failed(looker, "export")
    looker.send(do="revert")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({}, "to: one of mjcf, sdf, urdf, ros2 is expected, got ''"),
        ({"to": "sfd"}, "to: did you mean 'sdf'"),
        ({"to": ["sdf"]}, "ros2 is expected, got a list of 1"),
        ({"to": "urdf", "style": "legs"}, "urdf: style: is for formats that have such an option"),
        ({"to": "sdf", "style": "wheels"}, "style: one of platform, legs is expected, got 'wheels'"),
        ({"to": "sdf", "version": 2}, "version: one of 1.9, 1.6 is expected, got 2"),
        ({"to": "sdf", "out": "/tmp/a"}, "export: 'out' is not known"),
    ],
)
def test_exports_that_make_no_sense_are_told(looker, words, said):
    looker.send(do="export", **words)
    assert said in failed(looker, "export")


def test_what_is_left_out_and_what_a_format_cannot_say_is_told(looker):
    looker.send(do="open", name=str(CAROCA.with_name("winch.yaml")))
    looker.send(do="export", to="urdf")
    name = answer(looker, "export")["name"]
    told = answer(looker, "export")
    assert told["level"] == "warning"
    assert told["text"].startswith(f"{name}: left out: winches and elasticity of cable_1")
    answer(looker, "export")
    looker.send(do="export", to="mjcf")
    assert "MJCF has no winches and no elastic cables" in failed(looker, "export")


def test_an_import_is_given_up_and_one_goes_on_at_a_time(looker, window, tmp_path, monkeypatch):
    stuck = tmp_path / "stuck"
    stuck.write_text("#!/bin/sh\nexec sleep 600\n")
    stuck.chmod(0o755)
    with monkeypatch.context() as patch:
        patch.setattr("cdpr.ui.gui.incoming.sys.executable", str(stuck))
        upload(looker, {"crane.yaml": ROBOT})
        looker.send(do="export", to="urdf")
        assert "another import or export is in progress" in failed(looker, "export")
        with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
            Looker(opened).send(do="give_up")  # another's
        looker.send(do="edit", path="simulation.duration", value=0.2)  # edits go on
        looker.get("form", lambda form: form["undo"] == "simulation.duration = 0.2")
        while window._exchange._incoming._process is None:
            pass
        looker.send(do="give_up")
        assert failed(looker, "import") == "crane.yaml: reading it was stopped"
    looker.send(do="undo")
    window._exchange._thread.join()
    upload(looker, {"crane.yaml": ROBOT})
    assert answer(looker, "import")["kind"] == "imported"


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("kill -SEGV $$", "crane.yaml: the process that reads it was ended by SIGSEGV: nothing"),
        ("exit 3", "ended with exit code 3"),
    ],
)
def test_what_crashes_ends_no_window(looker, tmp_path, monkeypatch, script, said):
    broken = tmp_path / "broken"
    broken.write_text(f"#!/bin/sh\n{script}\n")
    broken.chmod(0o755)
    monkeypatch.setattr("cdpr.ui.gui.incoming.sys.executable", str(broken))
    upload(looker, {"crane.yaml": ROBOT})
    assert said in failed(looker, "import")


def test_what_takes_too_long_is_given_up(looker, monkeypatch):
    monkeypatch.setattr("cdpr.ui.gui.incoming.SECONDS", 0.01)
    upload(looker, {"crane.yaml": ROBOT})
    assert failed(looker, "import") == "crane.yaml: reading it takes more than 0.01 s, and was stopped"


@pytest.mark.slow
def test_a_trajectory_that_comes_with_one_robot_is_its(looker):
    upload(looker, FILES)
    (source,) = answer(looker, "import")["sources"]
    assert [each["name"] for each in source["files"]] == ["crane.yaml", "crane_way.yaml"]


def test_faults_of_ours_are_told_and_the_terminal_has_more(tmp_path, monkeypatch):
    broken = tmp_path / "broken"
    broken.write_text("""#!/bin/sh\ncat > /dev/null\necho '{"fault": "KeyError: 1", "trace": "Traceback: of it"}'\n""")
    broken.chmod(0o755)
    monkeypatch.setattr("cdpr.ui.gui.incoming.sys.executable", str(broken))
    log, reader = [], Broadcast().join()
    exchange = Exchange(lambda: None, lambda name, reader: None, log.append)
    exchange.begin("import", {"path": "a.xml"}, reader)
    exchange._thread.join()
    exchange.close()
    (message,) = reader.own
    assert message["text"] == "internal error: RuntimeError: KeyError: 1; the terminal has more"
    assert message["about"] == "import"
    assert "Traceback: of it" in log[0]


@pytest.mark.slow
def test_long_texts_are_not_shown_and_are_written_all_the_same(monkeypatch, tmp_path):
    monkeypatch.setattr("cdpr.ui.gui.incoming.MOST_SHOWN", 100)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "crane.yaml").write_bytes(ROBOT)
    incoming, reader = Incoming(), Broadcast().join()
    (message,) = incoming.read(reader, path="theirs/crane.yaml")
    (file,) = message["sources"][0]["files"]
    assert file["text"] is None
    assert incoming.write(reader, open="crane.yaml") == (["crane.yaml"], "crane.yaml")
    assert len((tmp_path / "crane.yaml").read_text()) == file["size"]
    assert yaml.safe_load((tmp_path / "crane.yaml").read_text())["platform"]["mass"] == 15.0
    incoming.close()
    with pytest.raises(cdpr.CdprError, match="being closed"):
        incoming.read(reader, path="theirs/crane.yaml")


@pytest.mark.slow
def test_what_makes_no_sense_is_told_in_a_sentence(looker):
    looker.send(do="export", to="sdf", style=["legs"])
    assert "style: one of platform, legs is expected, got a list of 1" in failed(looker, "export")
    looker.send(do="import", path="x" * 5000)
    assert "name too long" in failed(looker, "import")


@pytest.mark.slow
def test_the_longest_name_that_a_file_may_have(looker):
    name = "r" * 250 + ".yaml"
    upload(looker, {name: ROBOT})
    assert answer(looker, "import")["sources"][0]["source"] == name
