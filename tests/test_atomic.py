"""The writer of every file: complete or not there, on the disk before it has its name."""

import os
import stat
from functools import partial
from pathlib import Path

import pytest

from agrik_fast._atomic import AtomicFile, write_bytes
from agrik_fast.errors import GainFileError
from agrik_fast.io import ResultFileError


def refusal(path: Path) -> partial[GainFileError]:
    return partial(GainFileError, path.name)


def test_the_bytes_are_on_the_disk_before_the_file_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "a.toml"
    target.write_bytes(b"old")
    seen: list[tuple[str, bytes]] = []
    real = os.fsync

    def fsync(descriptor: int) -> None:
        kind = os.fstat(descriptor).st_mode
        if stat.S_ISREG(kind):
            # What the disk is told to keep is whole, and the old file still there.
            whole = Path(f"/proc/self/fd/{descriptor}").read_bytes()
            seen.append(("file", whole))
            assert target.read_bytes() == b"old"
        else:
            seen.append(("folder", target.read_bytes()))
        real(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    write_bytes(target, b"new", refusal(target), force=True)
    assert seen == [("file", b"new"), ("folder", b"new")]
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


@pytest.mark.parametrize("force", [False, True])
def test_a_disk_that_refuses_leaves_everything_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, force: bool
) -> None:
    target = tmp_path / "a.toml"
    if force:
        target.write_bytes(b"old")

    def fsync(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(GainFileError, match=r"a\.toml: cannot be written: no space left"):
        write_bytes(target, b"new", refusal(target), force=force)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == (
        [("a.toml", b"old")] if force else []
    )


def test_links_are_followed_and_permissions_kept(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "a.toml", tmp_path / "link.toml"
    link.symlink_to(real)
    write_bytes(link, b"one", refusal(link), force=False)
    real.chmod(0o640)
    write_bytes(link, b"two", refusal(link), force=True)
    assert link.is_symlink() and real.read_bytes() == b"two"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert [path.name for path in real.parent.iterdir()] == ["a.toml"]


def test_what_is_not_to_be_replaced_stays(tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    target.write_bytes(b"old")
    refuse = partial(ResultFileError, target)
    with pytest.raises(ResultFileError, match="exists already"):
        AtomicFile(target, refuse, force=False)
    target.chmod(0o444)
    with pytest.raises(ResultFileError, match="the file is read-only"):
        AtomicFile(target, refuse, force=True)
    with pytest.raises(ResultFileError, match="is a folder"):
        AtomicFile(tmp_path, refuse, force=True)
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    with pytest.raises(ResultFileError, match="is no regular file"):
        AtomicFile(pipe, refuse, force=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "pipe.csv"]


def test_a_file_made_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    file = AtomicFile(target, refusal(target), force=False)
    target.write_bytes(b"another's")
    with pytest.raises(GainFileError, match="exists already"):
        file.commit()
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"another's"]


def test_two_runs_with_one_destination_do_not_meet(tmp_path: Path) -> None:
    target = tmp_path / f"{'n' * 250}.csv"
    files = [AtomicFile(target, refusal(target), force=True) for _ in range(5)]
    assert len({file.temporary for file in files}) == 5
    for k, file in enumerate(files):
        file.stream.write(str(k).encode())
        file.commit()
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"4"]
