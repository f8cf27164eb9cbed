"""Exports hold the same numbers; the commands `export` and `repair`."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from log_cases import make_header, make_rows, same_bits, write_log

from cdpr.base.columns import FIRST
from cdpr.base.errors import ExitCode, OutputError, PluginError
from cdpr.log.export import EXPORTS, column_names, export
from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.ui.cli.export import command as export_command
from cdpr.ui.cli.repair import command as repair_command

pytestmark = pytest.mark.core

HEADER = make_header(3)


@pytest.fixture
def run() -> Run:
    rows = make_rows(HEADER, 1500)
    rows[7, 5] = -0.0
    rows[8, 5] = 5e-324
    rows[9, 5] = np.nan
    rows[9, 6] = -np.inf
    return Run(HEADER, rows, "infeasible", "no tensions")


def test_column_names() -> None:
    names = column_names(HEADER)
    assert len(set(names)) == len(names) == HEADER.layout.width
    assert names[:5] == ["t", "position_x_m", "position_y_m", "position_z_m", "orientation_w"]
    columns = HEADER.layout.columns
    assert names[columns["tension"]] == ["tension_Seil α_N", "tension_cable_2_N", "tension_cable_3_N"]
    assert names[columns["wrench"]][2:4] == ["wrench_force_z_N", "wrench_moment_x_Nm"]
    assert names[columns["rate"]][2] == "rate_cable_3_m_per_s"
    assert names[columns["status"].start :][:4] == ["status", "residual_N", "margin_N", "at_limit"]
    assert names[columns["external"]][2:4] == ["external_force_z_N", "external_moment_x_Nm"]
    assert names[-4:] == ["kinetic_J", "potential_J", "cable_work_J", "external_work_J"]


def test_csv(run: Run, tmp_path: Path) -> None:
    export(run, "csv", tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8", newline="") as file:
        names, *lines = csv.reader(file)
    assert names == column_names(HEADER)
    assert same_bits(np.array([[float(text) for text in line] for line in lines]), run.rows)


def test_the_folder_of_the_file_is_made(run: Run, tmp_path: Path) -> None:
    export(run, "csv", tmp_path / "a" / "b" / "c.csv")
    assert (tmp_path / "a" / "b" / "c.csv").read_text().startswith("t,")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/b: cannot be written: Not a directory"):
        export(run, "csv", tmp_path / "file" / "b" / "c.csv")


def test_csv_quotes_names(tmp_path: Path) -> None:
    header = make_header(2, cables=('a "b", c', "d"))
    export(Run(header, make_rows(header, 1)), "csv", tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8", newline="") as file:
        names, *_ = csv.reader(file)
    assert names == column_names(header)


def test_npz(run: Run, tmp_path: Path) -> None:
    export(run, "npz", tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz", allow_pickle=False) as data:
        assert Header.from_dict(json.loads(str(data["header"]))) == HEADER
        assert data["cables"].tolist() == list(HEADER.cables)
        assert (str(data["status"]), str(data["message"])) == ("infeasible", "no tensions")
        for name in (column.name for column in FIRST):
            attribute = "solver_status" if name == "status" else name
            assert same_bits(data[attribute], np.ascontiguousarray(getattr(run, attribute)))


def test_mat(run: Run, tmp_path: Path) -> None:
    from scipy.io import loadmat

    export(run, "mat", tmp_path / "run.mat")
    struct = loadmat(tmp_path / "run.mat", simplify_cells=True)["run"]
    assert struct["cables"].tolist() == list(HEADER.cables)
    assert struct["status"] == "infeasible"
    assert Header.from_dict(json.loads(struct["header"])) == HEADER
    np.testing.assert_array_equal(struct["time"], run.time)
    np.testing.assert_array_equal(struct["desired_angular_acceleration"], run.desired_angular_acceleration)
    np.testing.assert_array_equal(struct["position"], run.position)


def test_parquet(run: Run, tmp_path: Path) -> None:
    from pyarrow import parquet

    export(run, "parquet", tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet")
    assert table.column_names == column_names(HEADER)
    assert same_bits(np.column_stack([column.to_numpy() for column in table.columns]), run.rows)
    assert Header.from_dict(json.loads(table.schema.metadata[b"cdpr"])) == HEADER


@pytest.mark.parametrize("to", EXPORTS)
def test_without_rows_and_with_one_cable(to: str, tmp_path: Path) -> None:
    header = make_header(1)
    export(Run(header, make_rows(header, 0)), to, tmp_path / "run")
    assert (tmp_path / "run").stat().st_size > 0


@pytest.mark.parametrize(("to", "package"), [("mat", "scipy"), ("parquet", "pyarrow")])
def test_a_missing_package_has_a_remedy(
    run: Run, tmp_path: Path, to: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(PluginError, match=rf"needs {package}.*pip install 'cdpr\[data\]'") as caught:
        export(run, to, tmp_path / "run")
    assert caught.value.exit_code == ExitCode.PLUGIN
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_kept(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    out.write_text("mine")
    with pytest.raises(OutputError, match=r"run\.csv' already exists and is not overwritten; choose another name"):
        export(run, "csv", out)
    assert out.read_text() == "mine"
    export(run, "csv", out, force=True)
    assert out.read_text(encoding="utf-8").startswith("t,position_x_m")


def test_the_command_export(run: Run, tmp_path: Path) -> None:
    write_log(tmp_path / "log.mcap", HEADER, run.rows)
    result = CliRunner().invoke(export_command, [str(tmp_path), "--to", "csv"], catch_exceptions=False)
    assert result.stdout == f"{tmp_path}/run.csv: 1500 rows\n"
    arguments = [str(tmp_path / "log.mcap"), "--to", "npz", "--out", str(tmp_path / "x"), "--json"]
    result = CliRunner().invoke(export_command, arguments, catch_exceptions=False)
    assert json.loads(result.stdout) == {"file": str(tmp_path / "x"), "format": "npz", "rows": 1500}
    result = CliRunner().invoke(export_command, [str(tmp_path), "--to", "csv"])
    assert isinstance(result.exception, OutputError)
    result = CliRunner().invoke(export_command, [str(tmp_path), "--to", "csv", "--force"])
    assert result.exit_code == 0


def test_the_command_repair(run: Run, tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.mcap", HEADER, run.rows)
    result = CliRunner().invoke(repair_command, [str(tmp_path)], catch_exceptions=False)
    assert result.stdout == f"{log}: complete, 1500 rows\n"
    log.write_bytes(log.read_bytes()[:-3])
    result = CliRunner().invoke(repair_command, [str(tmp_path), "--json"], catch_exceptions=False)
    told = json.loads(result.stdout)
    assert (told["rows"], told["torn"]) == (1500, f"{log}.torn")
    log.write_bytes(log.read_bytes()[:-3])
    result = CliRunner().invoke(repair_command, [str(tmp_path)], catch_exceptions=False)
    assert "cut off at byte" in result.stdout
    assert f"stored as {log}.torn-2" in result.stdout
