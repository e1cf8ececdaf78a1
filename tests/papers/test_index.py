"""The page with all papers: what it shows of the files that are there, and the command for it."""

import re
from pathlib import Path

import pytest

from agrik_fast import papers
from agrik_fast.papers._index import write_index
from cli_runner import one_line, run_command


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two papers' folders, with what is a test of the page: long tables, marks, pictures."""
    first, second = tmp_path / "tomato", tmp_path / "hydrolek"
    for each in (first, second):
        each.mkdir()
    (first / "report.md").write_text("# What holds\n\n| a | b |\n|---|---|\n| 1 | <b> |\n")
    rows = "\n".join(f"{k},{k / 7!r},<i>{k}</i>" for k in range(60))
    (first / "table1.csv").write_text(f"method,time_published_us,words\n{rows}\n")
    (first / "arm.png").write_bytes(b"")
    (first / "arm.svg").write_text("")
    (second / "success.csv").write_text("method,published\nlm,\n")
    return tmp_path


def test_every_table_and_picture_is_on_the_page(folder: Path) -> None:
    text = write_index(folder, ["tomato", "hydrolek"]).read_text(encoding="utf-8")
    assert re.findall(r'<h2 id="(\w+)">', text) == ["tomato", "hydrolek"]
    assert "<h3>What holds</h3>" in text and "<td>1</td>" in text
    assert "<h3>table1</h3>" in text and "<h3>success</h3>" in text
    assert '<img src="tomato/arm.png"' in text and 'href="tomato/arm.svg"' in text
    # Published columns are marked, numbers short, letters of HTML not taken for such.
    assert '<th class="published">time_published_us</th>' in text
    assert "0.14286" in text and "0.14285714" not in text
    assert "&lt;i&gt;3&lt;/i&gt;" in text and "<i>" not in text and "<b>" not in text
    assert '20 more rows in <a href="tomato/table1.csv">' in text
    # All that it names is in its folder.
    for place in re.findall(r'(?:src|href)="([^"#]+)"', text):
        assert (folder / place).exists(), place


def test_all_papers_by_one_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # One of the five: the others take minutes, and are run by tests of their own.
    monkeypatch.setattr(papers, "PAPERS", ("tomato",))
    done: list[str] = []
    said: list[str] = []
    files = papers.reproduce_all(tmp_path / "new", said.append, done=done.append)
    assert done == ["tomato"] and all(line.startswith("tomato: ") for line in said) and said
    assert files[-1] == tmp_path / "new" / "index.html"
    text = files[-1].read_text(encoding="utf-8")
    for file in files[:-1]:
        assert file.parent == tmp_path / "new" / "tomato"
        assert f"tomato/{file.name}" in text or file.name == "report.md", file
    assert text.count("<img ") == len(list((tmp_path / "new/tomato").glob("*.png"))) >= 8
    assert 'class="published"' in text


def test_what_the_command_refuses(tmp_path: Path) -> None:
    (tmp_path / "there").write_text("")
    assert "--force" in one_line(run_command("paper", "all", "-o", tmp_path))
    new = tmp_path / "new"
    words = one_line(run_command("paper", "all", "-o", new, "--experiments", "model"))
    assert "strawberry alone" in words
    assert "all" in one_line(run_command("paper", "al", "-o", new))
