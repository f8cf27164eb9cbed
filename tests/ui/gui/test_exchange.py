"""Import and export by the socket of a window, without damage to the edited file."""

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
from driver_cases import FakeWindow, wait
from plugin_cases import SUCCESSOR, TRAJECTORY
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
        wait(made._broadcast, "status", lambda status: status["phase"] == "ready")
        yield made
    assert log == []


@pytest.fixture
def looker(window):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        found = FakeWindow(opened)
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


def test_uploads_are_shown_written_and_opened(looker, tmp_path):
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
    assert f"'{out}/crane_way.yaml' already exists and is not overwritten: choose another folder" in failed(
        looker, "take"
    )
    assert [path.name for path in out.iterdir()] == ["crane_way.yaml"]
    looker.send(do="take", out=str(out / "new"), open="nowhere.yaml")
    assert "open: expected one of crane.yaml, crane_way.yaml" in failed(looker, "take")
    looker.send(do="take", out=str(out / "new"), open="crane_way.yaml")  # nothing is lost
    form = looker.get("form", lambda form: form["file"] != str(CAROCA))
    assert answer(looker, "take")["text"] == f"imported: {out}/new/crane.yaml, {out}/new/crane_way.yaml"
    assert (form["file"], form["applied"], form["problems"]) == (f"{out}/new/crane_way.yaml", True, [])
    assert (out / "crane_way.yaml").read_text() == "# hours of work\n"
    assert {path.name: path.read_text() for path in (out / "new").iterdir()} == known.files
    looker.send(do="undo")
    assert looker.get("form")["file"] == str(CAROCA)
    looker.send(do="take", out=str(out / "again"), open="crane.yaml")
    assert "no imported data to write" in failed(looker, "take")


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


@pytest.mark.slow
def test_imported_data_belongs_to_its_window(window, looker, tmp_path):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        other = FakeWindow(opened)
        upload(other, {"crane.yaml": ROBOT})
        answer(other, "import")
        looker.send(do="take", out=str(tmp_path / "out"), open="crane.yaml")
        assert "no imported data to write" in failed(looker, "take")
    assert not (tmp_path / "out").exists()
    looker.send(do="yaml")
    looker.get("yaml")
    assert not any(message["kind"] == "imported" for message in looker.seen)


@sampled(
    lambda words, said: "MIN < MAX" not in said,  # calls a process
    ("words", "said"),
    [
        ({}, "choose files, or enter a path"),
        ({"path": 3}, "expected the name of a file, got 3"),
        ({"path": "nowhere.sdf"}, "there is no file 'nowhere.sdf'"),
        ({"path": "nowhere.sdf", "force": True}, "import: unknown argument 'force'"),
        ({"path": "nowhere.sdf", "cable_set": [1]}, "cable_set: expected a name, got"),
        ({"path": "nowhere.sdf", "tension": 5}, "tension: expected two numbers"),
        ({"path": "nowhere.sdf", "tension": ["", 5]}, "tension: expected two numbers"),
        ({"path": "nowhere.sdf", "tension": [5, 1]}, "tension: expected 0 <= MIN < MAX"),
        ({"path": "nowhere.sdf", "seconds": 0}, "seconds: expected a number above 0"),
        ({"path": "nowhere.sdf", "seconds": "x"}, "seconds: expected a number above 0"),
        ({"files": {"a": 1}}, "at most 100 files"),
        ({"files": [{}] * 101}, "at most 100 files"),
        ({"files": [1]}, "file name: expected a name without folders, of at most 255 bytes, got null"),
        ({"files": [{"name": "a.xml", "size": 1}]}, "a.xml: the received size differs from the announced one"),
        ({"files": [{"name": "a.xml", "size": -1}]}, "a.xml: the received size differs from the announced one"),
        ({"files": [{"name": "a.xml", "size": 0}, {"name": "a.xml", "size": 0}]}, "two files are named 'a.xml'"),
        ({"files": [{"name": "a.xml", "size": 0}], "trajectory": "../b"}, "'../b' is not among the files"),
        ({"files": [{"name": "a.xml", "size": 0}], "trajectory": "a.xml"}, "expected a robot with the trajectory"),
    ],
)
def test_invalid_input_is_reported(looker, words, said):
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
    assert "expected a name without folders, of at most 255 bytes" in failed(looker, "import")


def test_excess_bytes_are_rejected(looker):
    looker.socket.send(b'{"do": "import", "files": [{"name": "a.xml", "size": 1}]}\nab')
    assert "received more data than announced" in failed(looker, "import")
    looker.socket.send(b'{"do": "undo"}\nab')
    assert "unknown argument 'body'" in looker.get("message")["text"]


@pytest.mark.slow
@pytest.mark.parametrize("message", [b" " * (MOST_BYTES + 1), b" " * (MOST_BYTES + 1) + b"\n{}"])
def test_file_messages_are_short(window, message):
    with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
        opened.send(message)
        with pytest.raises(ConnectionClosedError, match="1009"):
            FakeWindow(opened).get("nothing")


@pytest.mark.slow
def test_exports_of_the_window_equal_those_of_the_command(looker, tmp_path):
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


def test_exports_use_unsaved_form_values(looker):
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
        ({}, "to: expected one of mjcf, sdf, urdf, ros2, got ''"),
        ({"to": "sfd"}, "did you mean 'sdf'"),
        ({"to": ["sdf"]}, "mjcf, sdf, urdf, ros2, got a list of 1"),
        ({"to": "urdf", "style": "legs"}, "urdf: style: not an option of this format"),
        ({"to": "sdf", "style": "wheels"}, "style: expected one of platform, legs, got 'wheels'"),
        ({"to": "sdf", "version": 2}, "version: expected one of 1.9, 1.6, got 2"),
        ({"to": "sdf", "out": "/tmp/a"}, "export: unknown argument 'out'"),
    ],
)
def test_invalid_exports_are_reported(looker, words, said):
    looker.send(do="export", **words)
    assert said in failed(looker, "export")


def test_omitted_and_unsupported_content_is_reported(looker):
    looker.send(do="open", name=str(CAROCA.with_name("winch.yaml")))
    looker.send(do="export", to="urdf")
    name = answer(looker, "export")["name"]
    told = answer(looker, "export")
    assert told["level"] == "warning"
    assert told["text"].startswith(f"{name}: left out: winches and elasticity of cable_1")
    answer(looker, "export")
    looker.send(do="export", to="mjcf")
    assert "MJCF does not support winches and elastic cables" in failed(looker, "export")


@pytest.mark.slow
def test_imports_can_be_cancelled_and_run_one_at_a_time(looker, window, tmp_path, monkeypatch):
    stuck = tmp_path / "stuck"
    stuck.write_text("#!/bin/sh\nexec sleep 600\n")
    stuck.chmod(0o755)
    with monkeypatch.context() as patch:
        patch.setattr("cdpr.ui.gui.incoming.sys.executable", str(stuck))
        upload(looker, {"crane.yaml": ROBOT})
        looker.send(do="export", to="urdf")
        assert "another import or export is in progress" in failed(looker, "export")
        with connect(window.address.replace("http:", "ws:"), max_size=None) as opened:
            FakeWindow(opened).send(do="give_up")  # another's
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
        ("kill -SEGV $$", "crane.yaml: the process that reads it was ended by SIGSEGV; nothing"),
        ("exit 3", "ended with exit code 3"),
    ],
)
def test_crashes_do_not_end_the_window(looker, tmp_path, monkeypatch, script, said):
    broken = tmp_path / "broken"
    broken.write_text(f"#!/bin/sh\n{script}\n")
    broken.chmod(0o755)
    monkeypatch.setattr("cdpr.ui.gui.incoming.sys.executable", str(broken))
    upload(looker, {"crane.yaml": ROBOT})
    assert said in failed(looker, "import")


def test_slow_requests_are_abandoned(looker, monkeypatch):
    monkeypatch.setattr("cdpr.ui.gui.incoming.SECONDS", 0.01)
    upload(looker, {"crane.yaml": ROBOT})
    assert failed(looker, "import") == "crane.yaml: reading it takes more than 0.01 s, and was stopped"


@pytest.mark.slow
def test_a_trajectory_that_comes_with_one_robot_is_its(looker):
    upload(looker, FILES)
    (source,) = answer(looker, "import")["sources"]
    assert [each["name"] for each in source["files"]] == ["crane.yaml", "crane_way.yaml"]


def test_internal_errors_are_reported_with_details_in_the_terminal(tmp_path, monkeypatch):
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
def test_invalid_input_gives_one_clear_error(looker):
    looker.send(do="export", to="sdf", style=["legs"])
    assert "style: expected one of platform, legs, got a list of 1" in failed(looker, "export")
    looker.send(do="import", path="x" * 5000)
    assert "name too long" in failed(looker, "import")


@pytest.mark.slow
def test_the_longest_name_that_a_file_may_have(looker):
    name = "r" * 250 + ".yaml"
    upload(looker, {name: ROBOT})
    assert answer(looker, "import")["sources"][0]["source"] == name
