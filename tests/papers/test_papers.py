"""`agrik-fast paper`: every file is written, none is taken for granted."""

import csv
from pathlib import Path

import numpy as np
import pytest

from agrik_fast.arms import StrawberryArm
from agrik_fast.papers import PAPERS, strawberry, tomato
from cli_runner import one_line, run_command

FILES = {
    "strawberry": {
        *("table3.csv", "table4.csv", "experiments.csv", "report.md"),
        *(
            f"{name}.{kind}"
            for name in ("figure2", "figure4", "figure5", "figure6", "exact", "table4")
            for kind in ("png", "svg")
        ),
    },
    "tomato": {
        *("table1.csv", "figure8.csv", "torques.csv", "servos.csv", "report.md"),
        *(f"{name}.{kind}" for name in ("figure8", "arm") for kind in ("png", "svg")),
    },
}


def read(file: Path) -> list[dict[str, str]]:
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Run the command once for each paper, in a folder of its own."""
    made = {}
    for name, files in FILES.items():
        folder = tmp_path_factory.mktemp("papers") / name
        result = run_command("paper", name, "-o", str(folder))
        assert result.exit_code == 0, result.output
        assert {Path(line).name for line in result.stdout.split()} == files
        made[name] = folder
    return made


@pytest.mark.parametrize("name", FILES)
def test_command_writes_every_file(name: str, folders: dict[str, Path]) -> None:
    folder = folders[name]
    assert {file.name for file in folder.iterdir()} == FILES[name]
    assert all(file.stat().st_size > 100 for file in folder.iterdir())
    again = run_command("paper", name, "-o", str(folder))
    assert "--force" in one_line(again)


def test_unknown_paper(tmp_path: Path) -> None:
    result = run_command("paper", "strawbery", "-o", str(tmp_path / "out"))
    assert "did you mean 'strawberry'" in one_line(result)
    assert set(FILES) <= set(PAPERS)


def test_strawberry_table_percentages_recompute() -> None:
    rows = strawberry.published()
    assert len(rows) == 20
    for row in rows:
        for name in ("SSAS", "AS"):
            percent = 100 * (row[f"J_{name}"] / row["J_NCOS"] - 1)
            assert abs(percent - row[f"dJ_{name}_pct"]) < 0.006
            percent = 100 * (1 - row[f"t_{name}"] / row["t_NCOS"])
            assert abs(percent - row[f"dt_{name}_pct"]) < 0.006


def test_strawberry_tables_on_file(folders: dict[str, Path]) -> None:
    rows = read(folders["strawberry"] / "table3.csv")
    assert len(rows) == 80
    for row in rows:
        assert float(row["time_s"]) > 0
        above = float(row["above_ncos_percent"])
        if row["column"] == "exact":
            assert row["time_published_s"] == row["J_published_mJ"] == ""
            assert abs(above) < 1e-3
            continue
        printed = strawberry.published()[int(row["row"]) - 1]
        assert float(row["time_published_s"]) == printed[f"t_{row['column'].upper()}"]
        # AS but for its four rows: the percentages too are the published ones.
        if row["column"] == "as" and row["matches"] == "True":
            assert above == pytest.approx(float(row["above_ncos_published_percent"]), abs=0.006)
    poses = read(folders["strawberry"] / "table4.csv")
    times = [row["time_published_s"] for row in poses]
    assert times == ["6.0", "4.0", "4.0", "", "4.0", "6.0", "6.0", ""]
    arm = StrawberryArm()
    for row in poses:
        q = np.array([float(row[name]) for name in ("s10_mm", "s21_mm", "s32_mm")]) / 1000
        angles = np.radians([float(row["theta_deg"]), float(row["beta_deg"])])
        target = [float(row[name]) / 1000 for name in ("x_mm", "y_mm", "z_mm")]
        np.testing.assert_allclose(arm.fk([*q, *angles]), target, rtol=0, atol=1e-5)


def test_tomato_table_1(folders: dict[str, Path]) -> None:
    rows = {row.method: row for row in tomato.table1()}
    assert all(row.reached == row.of for row in rows.values())
    for method, published in tomato.PUBLISHED.items():
        # The settings are fitted to these counts.
        assert abs(rows[method].iterations / published.iterations - 1) < 0.02
    lines = read(folders["tomato"] / "table1.csv")
    assert [row["method"] for row in lines] == list(tomato.FITS)
    # A fit is called one, and only what was fitted to the published counts.
    called = {row["method"]: row["setting_is"] for row in lines}
    fitted = dict.fromkeys(("inverse", "transpose", "pinv"), "a fit")
    assert called == {**fitted, "dls": "our choice", "analytic": ""}
    torques = read(folders["tomato"] / "torques.csv")
    assert [float(row["shoulder_nm"]) for row in torques[:2]] == pytest.approx(
        [0.325, 0.437], abs=1e-3
    )


def test_tomato_error_is_calibration_not_kinematics() -> None:
    errors = tomato.monte_carlo()
    assert errors.shape == (4000,)
    assert 1.4 < errors.mean() < 2.1
    none = tomato.ErrorSizes(link=0.0, zero=0.0, deadband=0.0, image=0.0)
    assert np.abs(tomato.monte_carlo(sizes=none, draws=10)).max() < 1e-10
    assert tomato.monte_carlo("inverse", none, draws=10).max() < 0.3
