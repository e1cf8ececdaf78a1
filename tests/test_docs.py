"""The examples in the documentation run as they stand."""

import re
from pathlib import Path

import pytest

from cli_runner import run_command
from urdf_text import joint, urdf

DOCS = Path(__file__).resolve().parents[1] / "docs"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if BLOCK.search(page.read_text("utf-8"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_python_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Files are written beside others that a reader has.
    monkeypatch.chdir(tmp_path)
    joints = [
        joint(f"j{i}", f"l{i}" if i else "base_link", f"l{i + 1}", xyz="0 0 0.3", axis="0 1 0")
        for i in range(6)
    ]
    links = ["base_link", *(f"l{i + 1}" for i in range(6)), "tool0", "camera"]
    ends = [joint(f"to_{end}", "l6", end, kind="fixed") for end in ("tool0", "camera")]
    Path("arm.urdf").write_text(urdf(links, [*joints, *ends]), encoding="utf-8")
    # The blocks of a page build on one another, as they do for its reader.
    names: dict[str, object] = {}
    for block in BLOCK.findall(page.read_text("utf-8")):
        exec(compile(block, page.name, "exec"), names)


def test_each_recipe_stands_alone_after_the_first() -> None:
    first, *others = BLOCK.findall((DOCS / "recipes.md").read_text("utf-8"))
    assert len(others) > 5
    for block in others:
        exec(compile(first + block, "recipes.md", "exec"), {})


@pytest.mark.parametrize("page", ["README.md", "docs/getting-started.md", "docs/collision.md"])
def test_commands_run_as_they_stand(
    page: str, repo_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = re.findall(r"^agrik-fast ((?:info|solve) .*)$", (repo_root / page).read_text(), re.M)
    assert lines
    for line in lines:
        words = line.replace("examples/", f"{repo_root.as_posix()}/examples/").split()
        result = run_command(*words)
        assert result.exit_code == 0, (line, result.output)


def test_there_are_examples() -> None:
    assert "getting-started" in [page.stem for page in PAGES]


def test_scripts_named_in_pages_exist(repo_root: Path) -> None:
    pages = [repo_root / "README.md", repo_root / "CONTRIBUTING.md", *DOCS.rglob("*.md")]
    script = re.compile(r"(?:tests|python|examples|benches|tools)/[\w/]+\.py\b")
    named = {
        path
        for page in pages
        if not {"_build", "_generated"} & set(page.parts)
        for path in script.findall(page.read_text("utf-8"))
        if "xyz" not in path  # stands for the format that a recipe adds
    }
    assert len(named) > 10
    assert [path for path in sorted(named) if not (repo_root / path).exists()] == []
