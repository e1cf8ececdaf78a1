"""Who takes from whom: the code keeps the tables in the record of decisions on the layout."""

import re
from pathlib import Path

import pytest

import layout

FILES = layout.modules()
IMPORTS = list(layout.imports(FILES))
PYTHON = layout.rules("python")


def test_every_room_has_its_place_and_planned_ones_are_yet_to_come() -> None:
    here = {layout.room(name) for name in FILES} - {layout.PACKAGE, "_lazy"}
    assert here == PYTHON.names - PYTHON.planned


def test_rooms_take_only_from_those_that_the_table_allows() -> None:
    arrows = layout.rooms(IMPORTS)
    # The package's own names are everybody's, loaded when they are first used.
    for name in (layout.PACKAGE, "_lazy"):
        arrows.pop(name, None)
    assert sum(map(len, arrows.values())) > 50
    assert layout.forbidden(arrows, PYTHON) == []


def test_nobody_takes_from_the_package_itself() -> None:
    wrong = [
        each
        for each in IMPORTS
        if each.target in (layout.PACKAGE, f"{layout.PACKAGE}._lazy")
        and layout.room(each.source) not in (layout.PACKAGE, "_lazy")
    ]
    assert wrong == []


def test_no_room_takes_from_what_another_keeps_to_itself() -> None:
    wrong = [
        each
        for each in IMPORTS
        if layout.room(each.source) != layout.room(each.target)
        and any(part.startswith("_") for part in each.target.split(".")[2:])
    ]
    assert wrong == []


def test_no_circles_but_of_packages_with_their_parts() -> None:
    arrows: layout.Arrows = {}
    for each in IMPORTS:
        if each.source != each.target and not layout.is_part_of(each.source, each.target):
            arrows.setdefault(each.source, set()).add(each.target)
    assert layout.circles(arrows) == []


def test_public_modules_have_a_place_in_the_api_pages(repo_root: Path) -> None:
    pages = "\n".join(
        page.read_text(encoding="utf-8") for page in sorted((repo_root / "docs/api").glob("*.md"))
    )
    public = [name for name in FILES if not re.search(r"\._", name)]
    assert "agrik_fast.io" in public
    missing = [name for name in public if not re.search(rf"\b{re.escape(name)}\b", pages)]
    assert missing == []


def test_folders_of_tests_are_named_as_rooms(repo_root: Path) -> None:
    folders = {path.parent.name for path in (repo_root / "tests").glob("*/test_*.py")}
    # The oracles, and what tests `torch` and `jax`, have environments of their own; `native` tests
    # the compiled module, `firmware` the boards' programs.
    assert folders - {"oracle", "gradients", "native", "firmware"} <= PYTHON.names - PYTHON.planned


# ---- Rust --------------------------------------------------------------------------------------


def test_crates_depend_on_those_below_them() -> None:
    arrows = layout.crates()
    assert {"agrik", "agrik-py"} <= set(arrows)
    assert layout.circles(arrows) == []
    assert not any("agrik-py" in needs for needs in arrows.values())


def test_modules_of_the_core_take_only_from_those_below_them() -> None:
    arrows, table = layout.rust_modules("agrik"), layout.rules("rust")
    assert set(arrows) == table.names - table.planned
    assert layout.forbidden(arrows, table) == []
    assert layout.circles(arrows) == []


# ---- the reading itself ------------------------------------------------------------------------


def read(tmp_path: Path, **texts: str) -> list[layout.Import]:
    """Return the imports of a small package of that name."""
    sources = tmp_path / layout.PACKAGE
    for name, text in {"__init__": "", **texts}.items():
        path = sources / f"{name.replace('__of__', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return list(layout.imports(layout.modules(sources)))


def test_all_ways_of_importing_are_seen(tmp_path: Path) -> None:
    found = read(
        tmp_path,
        a="import agrik_fast.b.c\nfrom agrik_fast import b\nimport numpy\nimport agrik_fast_x\n",
        b__of____init__="from . import c\nfrom .c import x\nfrom .. import version\n",
        b__of__c=(
            "from typing import TYPE_CHECKING\n"
            "if TYPE_CHECKING:\n    from ..a import y\n"
            "def f():\n    from . import g\n    from .d import z\n"
        ),
        b__of__d="",
    )
    arrows = {(each.source.removeprefix("agrik_fast."), each.target) for each in found}
    assert arrows == {
        ("a", "agrik_fast.b.c"),
        ("a", "agrik_fast.b"),
        ("b", "agrik_fast.b.c"),
        ("b", "agrik_fast"),
        ("b.c", "agrik_fast.a"),
        ("b.c", "agrik_fast.b"),
        ("b.c", "agrik_fast.b.d"),
    }
    assert layout.rooms(found) == {"a": {"b"}, "b": {"agrik_fast", "a"}}


def test_forbidden_arrows_and_circles_are_found(tmp_path: Path) -> None:
    record = tmp_path / "record.md"
    record.write_text(
        "<!-- layers: toy -->\n\n| layer | rooms | takes from |\n|---|---|---|\n"
        "| 1 | `ground` | layers below |\n| 2 | `left`, `right`, (`later`) | layers below |\n"
        "| 2 | `shy` | nothing |\n| 3 | `top` | layers below |\n\nText.\n"
    )
    table = layout.rules("toy", record)
    assert table.planned == {"later"}
    arrows = {
        "ground": {"top"},
        "left": {"ground", "right"},
        "shy": {"ground"},
        "top": {"left", "shy", "ground"},
        "unknown": {"ground"},
    }
    wrong = [("ground", "top"), ("left", "right"), ("shy", "ground"), ("unknown", "ground")]
    assert layout.forbidden(arrows, table) == wrong
    assert layout.circles(arrows) == [["ground", "left", "shy", "top"]]
    assert layout.circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert layout.circles({"a": {"a"}}) == [["a"]]
    stairs = layout.floors({"a": {"b", "c"}, "b": {"c"}, "d": {"d", "c"}})
    assert stairs == [["c"], ["b", "d"], ["a"]]
    assert layout.direct({"a": {"b", "c"}, "b": {"c"}}) == [("a", "b"), ("b", "c")]
    with pytest.raises(ValueError, match="no table of layers for rust"):
        layout.rules("rust", record)


def test_paths_of_a_crate_are_seen(tmp_path: Path) -> None:
    folder = tmp_path / "rust" / "toy" / "src"
    folder.mkdir(parents=True)
    (folder / "lib.rs").write_text("pub mod a;\npub mod b;\n")
    (folder / "a.rs").write_text(
        "use crate::{b::{X, Y}, c::Z};\n// crate::e\nfn f() { crate::d::g() }\n"
        "#[cfg(test)]\nmod tests {\n    use crate::e;\n}\n"
    )
    for name in "bcde":
        (folder / name).mkdir()
        (folder / name / "mod.rs").write_text("use crate::error::E;\n")
    (folder / "b" / "tests.rs").write_text("use crate::e;\n")
    found = layout.rust_modules("toy", tmp_path)
    assert found == {"a": {"b", "c", "d"}, "b": set(), "c": set(), "d": set(), "e": set()}
