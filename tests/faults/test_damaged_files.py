"""Damaged files that cdpr wrote: each gives one clear error, or is computed again; nothing of them is ever used.

CDPR_DAMAGE=302 multiplies the number of cases: 15 100 of rows, 22 952 of folders, 6 946 of NPZ files.
"""

from __future__ import annotations

import json
import random
import shutil
import warnings
from functools import partial

import numpy as np
import pytest
from conftest import ROOT
from damage import SCALE, damage_json, damaged, forge_json
from full_disk import file_size_limit

import cdpr
from cdpr import load_robot
from cdpr.analysis.compare import baseline, baseline_file
from cdpr.analysis.jobs.folder import JobFolder
from cdpr.analysis.rollouts.kept import RowsInFolder
from cdpr.analysis.workspace.chunks import workspace_in_chunks
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import CdprError, ExitCode, LogError, OutputError
from cdpr.log.reader import load_run
from cdpr.scenario import load_scenario

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.02}
CASES = 6


def copied(source, target):
    shutil.rmtree(target, ignore_errors=True)
    return shutil.copytree(source, target)


def read_or_refused(read, path):
    """Return what is read; None where it is refused, by one clear line that names the file or its folder."""
    try:
        return read()
    except CdprError as error:
        told = str(error)
    assert told.startswith(str(path))
    assert "\n" not in told
    return None


@pytest.fixture(scope="module")
def rollouts(tmp_path_factory):
    """Folders of two rollouts that differ in their values only."""
    place = tmp_path_factory.mktemp("rollouts")
    for name, low in (("one", 50.0), ("other", 60.0)):
        vary = {"controller.kp": np.linspace(low, 90.0, CASES)}
        cdpr.rollout(CAROCA, CASES, vary=vary, overrides=SHORT, out=place / name, every=5)
    return place


def described(folder):
    return json.loads((folder / "rollout.json").read_text())


def test_rows_of_rollouts(rollouts, tmp_path):
    rng, folder = random.Random(1), tmp_path / "ro"
    copied(rollouts / "one", folder)
    whole = (folder / "rows.npy").read_bytes()
    rows = np.load(folder / "rows.npy")
    ledger, other = (folder / "cases.jsonl").read_bytes(), (rollouts / "other" / "rows.npy").read_bytes()
    recomputed = 0
    for k in range(50 * SCALE):
        (folder / "rows.npy").write_bytes(other if k == 0 else damaged(rng, whole))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            opened = JobFolder(folder, "rollout", described(folder))
            kept = RowsInFolder(opened, rows.shape)
        found = kept.rows()
        assert found.shape == rows.shape
        assert all(np.array_equal(found[int(key)], rows[int(key)]) for key in kept.ended)
        assert len(told) == (len(kept.ended) < CASES)
        recomputed += CASES - len(kept.ended)
        kept.close()
        opened.close()
    assert recomputed
    assert (folder / "cases.jsonl").read_bytes() == ledger


def test_a_damaged_rollout_is_the_rollout(rollouts, tmp_path):
    """The experiment of the issue: the same call gives the same rows, whatever became of the file."""
    rng, folder = random.Random(2), tmp_path / "ro"
    vary = {"controller.kp": np.linspace(50.0, 90.0, CASES)}
    rows = np.load(rollouts / "one" / "rows.npy")
    whole = (rollouts / "one" / "rows.npy").read_bytes()
    cut = whole[: len(whole) // 2]
    for content in (cut, *(damaged(rng, whole) for _ in range(SCALE))):
        copied(rollouts / "one", folder)
        (folder / "rows.npy").write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = cdpr.rollout(CAROCA, CASES, vary=vary, overrides=SHORT, out=folder, every=5)
        assert np.array_equal(found.rows, rows)
        assert np.array_equal(np.load(folder / "rows.npy"), rows)


@pytest.mark.parametrize("name", ["rollout.json", "cases.jsonl"])
def test_descriptions_and_ledgers(rollouts, tmp_path, name):
    """Studies and designs have the same ones."""
    rng, folder = random.Random(3), tmp_path / "ro"
    copied(rollouts / "one", folder)
    content, path = described(folder), folder / name
    whole, known = path.read_bytes(), rows_of(folder)
    for k in range(50 * SCALE):
        if k == 0:
            path.write_bytes((rollouts / "other" / name).read_bytes())
        else:
            path.write_bytes(damaged(rng, whole))
        opened = read_or_refused(partial(JobFolder, folder, "rollout", content), folder)
        if opened is not None:  # lines at its end are missing, or only spaces were changed
            assert all(opened.rows[key] == known[key] for key in opened.rows)
            opened.close()
        path.write_bytes(whole)


def rows_of(folder):
    opened = JobFolder(folder, "rollout", described(folder))
    opened.close()
    return opened.rows


@pytest.fixture(scope="module")
def spaces(tmp_path_factory):
    """Folders of two workspaces in chunks, and the same in memory."""
    place, robot = tmp_path_factory.mktemp("spaces"), load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    for name, cells in (("one", 6), ("other", 7)):
        where = region(robot, cells=cells)
        workspace_in_chunks(robot, "static", where, place / name, jobs=1)
        workspace(robot, "static", where, jobs=1).save(place / f"{name}.npz")
    return place


FILES = ("workspace.json", "cases.jsonl", "summary.json", "chunks/000000.npz")


def same(one, other):
    return one.about == other.about and one.summary() == other.summary() and np.array_equal(one.value, other.value)


def test_folders_of_workspaces(spaces, tmp_path):
    rng, folder, whole = random.Random(4), tmp_path / "w", load_workspace(spaces / "one")
    copied(spaces / "one", folder)
    contents = {name: (folder / name).read_bytes() for name in FILES}
    refusals = 0
    for k in range(76 * SCALE):
        name = FILES[k % len(FILES)]
        path = folder / name
        if k < len(FILES):
            path.write_bytes((spaces / "other" / name).read_bytes())
        elif k < 2 * len(FILES):
            path.unlink()
        elif path.suffix == ".json":
            damage_json(rng, path)
        else:
            path.write_bytes(damaged(rng, contents[name]))
        found = read_or_refused(partial(load_workspace, folder), folder)
        assert found is None or same(found, whole)  # a space was changed, or a line that is not used
        refusals += found is None
        path.write_bytes(contents[name])
    assert refusals > 0.9 * 76 * SCALE


@pytest.mark.parametrize("name", ["workspace.json", "summary.json"])
def test_forged_folders_of_workspaces(spaces, tmp_path, name):
    """A file with a right checksum that cdpr did not write is validated, too."""
    rng, folder = random.Random(5), tmp_path / "w"
    copied(spaces / "one", folder)
    content = (folder / name).read_bytes()
    job = json.loads((folder / "workspace.json").read_text())["digest"] if name == "summary.json" else ""
    for _ in range(20 * SCALE):
        forge_json(rng, folder / name, job)
        found = read_or_refused(partial(load_workspace, folder), folder)
        assert found is None or found.summary()
        (folder / name).write_bytes(content)


def test_files_of_workspaces(spaces, tmp_path):
    rng, path = random.Random(6), tmp_path / "w.npz"
    content = (spaces / "one.npz").read_bytes()
    path.write_bytes(content)
    assert same(load_workspace(path), load_workspace(spaces / "one.npz"))
    for _ in range(23 * SCALE):
        path.write_bytes(damaged(rng, content))
        assert read_or_refused(partial(load_workspace, path), path) is None


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    place = tmp_path_factory.mktemp("runs")
    for name, mass in (("one", 25.0), ("other", 26.0)):
        cdpr.simulate(CAROCA, overrides={**SHORT, "robot.platform.mass": mass}, out=place / name)
    return place


def test_run_json(runs, tmp_path):
    rng, folder, whole = random.Random(7), tmp_path / "run", load_run(runs / "one")
    copied(runs / "one", folder)
    path, other = folder / "run.json", (runs / "other" / "run.json").read_bytes()
    content = path.read_bytes()
    for k in range(20 * SCALE):
        path.write_bytes(other) if k == 0 else damage_json(rng, path)
        found = read_or_refused(partial(load_run, folder), path)
        assert found is None or (found.summary(), found.events) == (whole.summary(), whole.events)
        path.write_bytes(content)


def test_a_run_json_and_a_log_of_two_runs(runs, tmp_path):
    folder = copied(runs / "one", tmp_path / "run")
    shutil.copy(runs / "other" / "log.mcap", folder / "log.mcap")
    with pytest.raises(LogError, match=r"run\.json: does not belong to the log in this folder"):
        load_run(folder)


def test_baselines(runs, tmp_path):
    rng = random.Random(8)
    kept = baseline.make(load_run(runs / "one"), load_scenario(CAROCA), (), tmp_path)
    path = tmp_path / kept.name
    path.write_text(baseline_file.text_of(kept))
    content, same_as = path.read_bytes(), (kept.digest, kept.bounds, kept.scenario_yaml)
    for _ in range(15 * SCALE):
        damage_json(rng, path)
        found = read_or_refused(partial(baseline_file.read, path), path)
        assert found is None or (found.digest, found.bounds, found.scenario_yaml) == same_as
        path.write_bytes(content)


def test_rows_have_their_room_on_the_disk_from_the_start(tmp_path):
    """In a file with holes, a full disk ends the process while it writes to mapped memory."""
    seen = []

    def progress(done, total):
        found = (tmp_path / "ro" / "rows.npy").stat()
        seen.append(512 * found.st_blocks >= found.st_size)

    vary = {"controller.kp": np.linspace(50.0, 90.0, CASES)}
    cdpr.rollout(CAROCA, CASES, vary=vary, overrides=SHORT, out=tmp_path / "ro", every=1, progress=progress)
    assert all(seen)


@pytest.mark.parametrize("name", ["rows.npy", "cases.jsonl"])
def test_a_full_disk_is_one_clear_error(tmp_path, name):
    vary = {"controller.kp": np.linspace(50.0, 90.0, CASES)}
    room = 1000 if name == "rows.npy" else 3500  # of any file; the rows take 3 kB, the ledger 4 kB
    with (
        pytest.raises(OutputError, match=f"{name}: .*(more than its disk has|cannot be written)") as caught,
        file_size_limit(room),
    ):
        cdpr.rollout(CAROCA, CASES, vary=vary, overrides=SHORT, out=tmp_path / "ro", every=10, threads=1)
    assert caught.value.exit_code == ExitCode.NOT_WRITABLE
