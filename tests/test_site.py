"""The check of the built documentation finds what it is for, and the files that belong to it."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

import check_site


def site(folder: Path, **pages: str) -> Path:
    for name, body in pages.items():
        (folder / f"{name}.html").write_text(f"<html><body>{body}</body></html>", "utf-8")
    return folder


def test_a_sound_site_has_no_faults(tmp_path: Path) -> None:
    (tmp_path / "style.css").write_text("@font-face { src: url(data:font/woff2;base64,AA) }")
    site(
        tmp_path,
        index='<link rel="stylesheet" href="style.css?digest=1"><a href="other.html#here">x</a>'
        '<a href="#top">x</a><p id="top"><a href="https://example.org/paper">by hand</a>',
        other='<h2 id="here">x</h2><a href="./">x</a><pre>a |\n| b</pre>',
    )
    assert list(check_site.faults(tmp_path)) == []


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('<a href="gone.html">x</a>', "dead link to 'gone.html'"),
        ('<a href="other.html#gone">x</a>', "no place 'gone'"),
        ('<a href="#gone">x</a>', "no place 'gone'"),
        ('<script src="https://cdn.example.org/x.js"></script>', "from elsewhere"),
        ('<link rel="stylesheet" href="//fonts.example.org/x.css">', "from elsewhere"),
        ('<img src="gone.png">', "which is not there"),
        ('<img srcset="gone.png 2x">', "which is not there"),
        ("<style>p { background: url('https://example.org/x.png') }</style>", "from elsewhere"),
        ('<p style="background: url(https://example.org/x.png)">', "from elsewhere"),
        ("<p>What it writes. | a | b |\n|—|—|\n| x | y |</p>", "shown as text: 'What it writes."),
    ],
)
def test_each_kind_of_fault_is_found(tmp_path: Path, body: str, fault: str) -> None:
    site(tmp_path, index=body, other="")
    (found,) = check_site.faults(tmp_path)
    assert found.startswith("index.html: ") and fault in found


def test_a_style_sheet_may_not_load_from_elsewhere(tmp_path: Path) -> None:
    site(tmp_path, index="")
    (tmp_path / "style.css").write_text('@import "https://fonts.example.org/x.css";')
    (found,) = check_site.faults(tmp_path)
    assert "from elsewhere" in found


def test_an_empty_folder_is_no_site(tmp_path: Path) -> None:
    assert list(check_site.faults(tmp_path)) == [f"{tmp_path}: holds no pages"]


def test_attributes_that_share_a_line_get_one_each(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[1] / "docs")
    import docstrings

    text = """What became of it, a, b : no attribute.

Parameters
----------
low, high : float
    Stays.

Attributes
----------
begin, end : float, s
    By the clock

    of the line.
name : str
a, b, c

Examples
--------
p, q : r
"""
    found = docstrings.attributes_apart(text.splitlines())
    start = found.index("Attributes") + 2
    about = ["    By the clock", "", "    of the line."]
    assert found[start : found.index("Examples") - 1] == [
        *("begin : float, s", *about),
        *("end : float, s", *about),
        *("name : str", "a", "b", "c"),
    ]
    assert "low, high : float" in found and "p, q : r" in found
    assert docstrings.short("collections.abc.Mapping[str, agrik_fast._checks.FloatArray]") == (
        "Mapping[str, FloatArray]"
    )
    assert docstrings.of_attribute("Annotated[list[float], Field(ge=0, le=3)]") == "list[float]"
    assert docstrings.of_attribute("pydantic.FiniteFloat | None") == "FiniteFloat | None"
    assert docstrings.of_attribute("list[_Positive]") is None


@pytest.mark.parametrize("what", ["attribute", "property"])
def test_a_colon_in_a_line_on_an_attribute_is_no_type(
    what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    napoleon = pytest.importorskip("sphinx.ext.napoleon")
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[1] / "docs")
    import docstrings

    lines = ["Neither was found: it grazes."]
    docstrings.put_right(None, what, "UNDECIDED", None, None, lines)
    made = str(napoleon.NumpyDocstring("\n".join(lines), what=what, name="UNDECIDED"))
    assert made.strip().removeprefix("..").strip() == "Neither was found: it grazes."


def test_the_reference_has_every_command_with_its_options(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[1] / "docs")
    import commands

    page = commands.page()
    found = dict(commands.commands())
    assert len(found) > 15 and ("agrik-fast", "cluster", "solve") in found
    for words, command in found.items():
        section = page.split(f"## {' '.join(words)}\n")[1].split("\n## ")[0]
        rows = [line for line in section.splitlines() if line.startswith("| `")]
        shown = [each for each in command.params if not getattr(each, "hidden", False)]
        assert len(rows) == len(shown), words
        for row in rows:
            _, name, about, _, _ = re.split(r"(?<!\\)\|", row)
            assert name.strip() and about.strip(), row
    assert "| `--output`, `-o` | Results: .csv, .npy, .npz or .parquet. | needed |" in page
    assert "lm, dls" in page.split("## agrik-fast solve\n")[1].split("\n## ")[0]


def test_every_tutorial_is_a_script_with_a_title(repo_root: Path) -> None:
    # sphinx-gallery runs these alone.
    scripts = sorted((repo_root / "docs" / "gallery").glob("*.py"))
    assert len(scripts) >= 8
    for script in scripts:
        assert re.fullmatch(r"tutorial_\d_\w+", script.stem)
        title, rule, *_ = (ast.get_docstring(ast.parse(script.read_text("utf-8"))) or "").split(
            "\n"
        )
        assert title and rule == "=" * len(title), script


def test_the_citation_names_this_version(repo_root: Path) -> None:
    text = (repo_root / "CITATION.cff").read_text("utf-8")
    cargo = tomllib.loads((repo_root / "Cargo.toml").read_text("utf-8"))
    assert f"\nversion: {cargo['workspace']['package']['version']}\n" in text
    for field in ("cff-version: 1.2.0", "message:", "title:", "authors:"):
        assert f"\n{field}" in f"\n{text}"


def test_what_a_repository_has_for_its_people_is_there(repo_root: Path) -> None:
    for name, words in (("SECURITY.md", "Report"), ("CODE_OF_CONDUCT.md", "When it is broken")):
        assert f"## {words}" in (repo_root / name).read_text("utf-8")


@pytest.mark.parametrize(
    ("target", "entry"),
    [
        ("agrik_fast.robot._path.Path", "agrik_fast.Path"),
        ("pathlib.Path", None),
        ("agrik_fast.vision._render.Scene", "agrik_fast.vision.Scene"),
        ("agrik_fast._bodies._shapes.Sphere", "agrik_fast.collision.Sphere"),
        ("agrik_fast._files.Place", None),
        ("Place", None),
    ],
)
def test_a_type_of_a_signature_is_linked_by_its_module(
    target: str, entry: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[1] / "docs")
    import docstrings
    import links

    names = ["Path", "vision.Scene", "collision.Scene", "collision.Sphere", "arms.Place"]
    assert links.of_type(target, [f"agrik_fast.{name}" for name in names]) == entry
    shown = docstrings.linked(f"Mapping[str, {target}]")
    assert shown == f"Mapping[str, {'~' * ('.' in target)}{target}]"
