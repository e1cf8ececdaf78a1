"""Damages files of every kind and gives them to the readers: `python tests/io/damaged_files.py`.

Every case is made from a seed. A reader may take a file or refuse it with an error of the
library on one line; anything else is a fault: another exception, more than `SECONDS`, more than
`BYTES` of memory. `test_damaged_files.py` tries a few, this script as many as it is told to.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import random
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow
from pyarrow import parquet

import agrik_fast as ik
from agrik_fast import AgrikError
from agrik_fast.io import read_results
from agrik_fast.jobs import SolveRequest, solve_file
from agrik_fast.solvers import gain_file
from agrik_fast.tuning import Tuning, tune

SECONDS = 5.0
BYTES = 500 << 20

QUICK = Tuning(goals=20, evaluations=40, runs=1, refinement=0)
URDF = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="tool"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.2 0 0" rpy="1.5707963 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
  <joint name="c" type="prismatic"><parent link="lower"/><child link="tool"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.4"/></joint>
</robot>
"""


class Seed(NamedTuple):
    """A sound file and what reads it."""

    name: str
    data: bytes
    read: Callable[[Path], object]


class Case(NamedTuple):
    """A damaged file."""

    name: str
    data: bytes
    read: Callable[[Path], object]


# ---- sound files -----------------------------------------------------------------------------


def _solve(path: Path) -> None:
    """Solve a target file as the command does, with results of a kind that shows all."""
    output = path.with_name("result.csv")
    solve_file(SolveRequest(robot="ur5", targets=path, output=output, solver="auto", force=True))
    with output.open(encoding="utf-8", newline="") as stream:
        rows = sum(1 for _ in csv.reader(stream)) - 1
    if rows < 1:
        raise AssertionError("a target file without targets was accepted")


def _robot(path: Path) -> None:
    arm = ik.Robot.load(path)
    if not np.isfinite(arm.fk(np.clip(np.zeros(arm.dof), arm.lower, arm.upper))).all():
        raise AssertionError("a robot whose tool is nowhere was accepted")


def _resume(path: Path) -> None:
    tune(ik.Robot.load("hydrolek"), QUICK, checkpoint=path, resume=True)


def _savez(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def _save(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _table(**columns: object) -> bytes:
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), stream)
    return stream.getvalue()


def _repeated(row_id: str, rows: int) -> bytes:
    """Return rows of one id, which is in the file once."""
    ids = pyarrow.DictionaryArray.from_arrays(np.zeros(rows, dtype=np.int32), [row_id])
    columns = {"id": ids, **{f"{axis}_m": np.zeros(rows) for axis in "xyz"}}
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), stream, store_schema=False)
    return stream.getvalue()


def _checkpoint(folder: Path) -> bytes:
    """Return the checkpoint of a search whose gains could not be stored."""
    path = folder / "kept.npz"

    def fail(_: object) -> None:
        raise AgrikError("no room")

    try:
        tune(ik.Robot.load("hydrolek"), QUICK, checkpoint=path, store=fail)
    except AgrikError:
        pass
    return path.read_bytes()


def seeds(folder: Path) -> list[Seed]:
    """Return a sound file of every kind."""
    arm = ik.Robot.load("ur5")
    poses = arm.fk(arm.random_q(40, seed=1))
    points = poses[:, :3, 3]
    ids = np.array([f"row {k}" for k in range(len(points))])
    lines = ["id,x_m,y_m,z_m,qx,qy,qz,qw"]
    lines += [
        f"{k},{x!r},{y!r},{z!r},0,0,0,1" for k, (x, y, z) in zip(ids, points.tolist(), strict=True)
    ]
    text = "\n".join(lines).encode()
    results = []
    for suffix in ("csv", "npy", "npz", "parquet"):
        source, target = folder / "sound.csv", folder / f"sound_result.{suffix}"
        source.write_bytes(text)
        solve_file(SolveRequest(robot="ur5", targets=source, output=target, force=True))
        results.append(Seed(f"result.{suffix}", target.read_bytes(), read_results))
    gains = gain_file.read("hydrolek_full90_pso")
    bundled = Path(ik.__file__).parent / "robot" / "bundled"
    return [
        Seed("targets.csv", text, _solve),
        Seed("points.npy", _save(points), _solve),
        Seed("poses.npy", _save(np.asfortranarray(poses)), _solve),
        Seed("points.npz", _savez(position_m=points, rpy_deg=points * 100, id=ids), _solve),
        Seed("poses.npz", _savez(T=poses, id=np.arange(40)), _solve),
        Seed(
            "targets.parquet",
            _table(id=ids, **{f"{axis}_m": points[:, k] for k, axis in enumerate("xyz")}),
            _solve,
        ),
        *results,
        *(
            Seed(f"{name}.toml", (bundled / f"{name}.toml").read_bytes(), _robot)
            for name in ("ur5", "strawberry", "redundant7")
        ),
        Seed("gains.toml", gain_file.text(Path("x.toml"), gains).encode(), gain_file.read),
        Seed("gains.json", gain_file.text(Path("x.json"), gains).encode(), gain_file.read),
        Seed("arm.urdf", URDF.encode(), _robot),
        Seed("kept.npz", _checkpoint(folder), _resume),
    ]


# ---- damages of any bytes ----------------------------------------------------------------------


def _cut(data: bytes, draw: random.Random) -> bytes:
    return data[: draw.randrange(len(data))]


def _flip(data: bytes, draw: random.Random) -> bytes:
    out = bytearray(data)
    # Half of them near the ends, where headers and footers are.
    for _ in range(draw.choice((1, 1, 3, 20))):
        place = draw.choice((draw.randrange(len(out)), draw.randrange(min(400, len(out)))))
        place = draw.choice((place, len(out) - 1 - place))
        out[place] ^= 1 << draw.randrange(8)
    return bytes(out)


def _overwrite(data: bytes, draw: random.Random) -> bytes:
    at, count = draw.randrange(len(data)), draw.choice((1, 4, 64, 1000))
    filler = draw.choice((b"\xff", b"\x00", b"\x80", b"[", b'"', b"9", b"\n"))
    return data[:at] + filler * count + data[at + count :]


def _remove(data: bytes, draw: random.Random) -> bytes:
    at = draw.randrange(len(data))
    return data[:at] + data[at + draw.choice((1, 7, 100)) :]


def _repeat(data: bytes, draw: random.Random) -> bytes:
    at = draw.randrange(len(data))
    part = data[at : at + draw.choice((10, 1000))]
    return data[:at] + part * draw.choice((2, 50)) + data[at:]


def _encode(data: bytes, draw: random.Random) -> bytes:
    text = data.decode("latin1")
    return text.encode(draw.choice(("utf-16", "utf-32", "utf-7", "utf-8-sig", "utf-8")))


def _swap_word(data: bytes, draw: random.Random) -> bytes:
    """Put another word in the place of one: mostly another number, or another type."""
    words = data.split(b" ") if b" " in data else data.split(b",")
    words[draw.randrange(len(words))] = draw.choice(
        (
            b"nan",
            b"-inf",
            b"1e400",
            b"1" * 5000,
            b"true",
            b"",
            b"[]",
            b"{}",
            b'"x"',
            b"-1",
            b"1e308",
        )
        + ("९".encode(), b"\x00", b"0x10", b"'" * 3, b"a" * 200_000, b"1_0")
    )
    return b" ".join(words) if b" " in data else b",".join(words)


DAMAGES = (_cut, _flip, _flip, _flip, _overwrite, _remove, _repeat, _encode, _swap_word)


# ---- damages that need to know the kind -----------------------------------------------------------


def _header(descr: str, shape: str, order: str = "False", version: int = 1) -> bytes:
    text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n".encode()
    form = "<H" if version == 1 else "<I"
    return b"\x93NUMPY" + bytes((version, 0)) + struct.pack(form, len(text)) + text


def _headers() -> Iterator[bytes]:
    for shape in ("(10**9, 3)", "(1000000000, 3)", "(3, 10000000000000000000000)", "(-1, 3)"):
        yield _header("'<f8'", shape) + bytes(96)
    for shape in (
        "(True, 3)",
        "(2.0, 3)",
        "'x'",
        "()",
        "(2,)",
        "(" + "1, " * 100 + ")",
        "3",
        "(0, 3)",
    ):
        yield _header("'<f8'", shape) + bytes(96)
    for descr in ("'|O'", "'<U3'", "'<f2'", "'|b1'", "'<c16'", "'>f8'", "'<m8[s]'", "'|V8'", "'x'"):
        yield _header(descr, "(2, 3)") + bytes(96)
    for descr in ("'<U999999999'", "[('id', '<i8')]", "('<f8', (3,))", "None", "[]", "'<f16'", "7"):
        yield _header(descr, "(2, 3)") + bytes(96)
    for deep in ("(" * 5000, "-" * 9000 + "1", "[" * 150, "{" * 90, "1" * 9000, "'\\x'"):
        yield _header("'<f8'", deep) + bytes(96)
    for version in (0, 2, 3, 9):
        yield _header("'<f8'", "(2, 3)", version=version) + bytes(48)
    yield _header("'<f8'", "(2, 3)", "None") + bytes(48)
    yield _header("'<f8'", "(4, 3)", "True") + np.full(12, 1e308).tobytes()
    yield b"\x93NUMPY\x02\x00\xff\xff\xff\xff{"
    yield b"PK\x03\x04"
    yield b"\x80\x04\x95"


def _archive(method: int = zipfile.ZIP_DEFLATED, **entries: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, data in entries.items():
            archive.writestr(f"{name}.npy", data)
    return stream.getvalue()


def _bomb(key: str, rows: int) -> bytes:
    """Return an archive of zeros, written piece by piece."""
    stream = io.BytesIO()
    with (
        zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open(f"{key}.npy", "w", force_zip64=True) as entry,
    ):
        entry.write(_header("'<f8'", f"({rows}, 3)"))
        for _ in range(rows * 24 // (1 << 20)):
            entry.write(bytes(1 << 20))
    return stream.getvalue()


def special(folder: Path) -> list[Case]:
    """Return files that claim, nest or hold what they should not."""
    by_kind: dict[str, list[bytes]] = {".npy": list(_headers())}
    good = _save(np.zeros((2, 3)))
    by_kind[".npz"] = [_archive(position_m=data) for data in by_kind[".npy"]]
    by_kind[".npz"] += [_archive(position_m=good, id=data) for data in by_kind[".npy"]]
    by_kind[".npz"] += [_archive(method, position_m=good) for method in (12, 14)]
    by_kind[".npz"] += [
        _bomb("position_m", 50_000_000),
        _archive(position_m=good, id=_save(np.array(["x" * 100_000, ""]))),
        _archive(position_m=good, id=_header("'<U1'", "(2,)") + b"\xff" * 8),
        _archive(position_m=good, id=_header("'<U1'", "(2,)") + b"\x00\xd8\x00\x00" * 2),
        _archive(position_m=good, id=_save(np.array([2**64 - 1, 1], dtype=np.uint64))),
        _archive(**{f"k{k}": b"" for k in range(5000)}),
        _save(np.zeros((2, 3))),
        _archive(),
    ]
    head = b"x_m,y_m,z_m\n"
    by_kind[".csv"] = [
        b"id," + head + b"a" * 100_000 + b",1,2,3\n" + b"b,1,2,3\n" * 3000,
        head + b"1,2,3" + b"," * 3_000_000,
        head + b'"' + b"1,2,3\n" * 300_000,
        b'"a\nb",' * 300_000 + b"\n1\n",
        b",".join(b"c%d" % k for k in range(100_000)) + b"\n" + b"," * 99_999 + b"\n",
        head + b"1e999,-1e999,nan\n",
        head + b"1,2,3\r4,5,6\r\n\x00,1,2\n",
        head + b"1,2,3\n" * 10 + b"\xff,2,3\n",
        b"\xef\xbb\xbf" + head,
        head + b"1;2;3\n",
        b"x_m\ty_m\tz_m\n1\t2\t3\n",
    ]
    xyz = {f"{axis}_m": [0.1, 0.2] for axis in "xyz"}
    whole = {f"{axis}_m": [1, 2] for axis in "xyz"}
    by_kind[".parquet"] = [
        _table(**(whole | {"x_m": [2**53 + 1, 2]})),
        _table(**(whole | {"x_m": np.array([2**64 - 1, 0], dtype=np.uint64)})),
        _table(**xyz, id=np.array([2**64 - 1, 0], dtype=np.uint64)),
        _table(**xyz, id=["x" * 131_000, "y"]),
        _repeated("x" * 131_000, 60_000),
        _table(**xyz, id=[None, "y"]),
        _table(**xyz, id=pyarrow.array(["a", "a"]).dictionary_encode()),
        _table(**xyz, id=[b"\xff", b"y"]),
        _table(**xyz, id=pyarrow.array(["a", "b"], pyarrow.large_string())),
        _table(**(xyz | {"z_m": [[1.0], [2.0]]})),
        _table(**(xyz | {"z_m": pyarrow.array([1, 2], pyarrow.decimal128(5))})),
        _table(**(xyz | {"z_m": np.array([1, 2], dtype=np.float16)})),
        _table(**{f"c{k}": [1] for k in range(2000)}),
        b"PAR1" + struct.pack("<I", 0xFFFFFFF0) + b"PAR1",
        b"PAR1PAR1",
    ]
    rows = "[[joint]]\nname = 'j'\n"
    unknown = "".join(
        f"[[joint]]\nname='j{k}'\ntype='revolute'\naxis=[0,0,1]\nlower_rad=0\nupper_rad=1\n"
        f"mimic={{joint='no{k}'}}\n"
        for k in range(900)
    )
    by_kind[".toml"] = [
        text.encode()
        for text in (
            "x = " + "[" * 5000,
            "x = " + "{a=" * 5000,
            "a." * 5000 + "a = 1",
            "[" + ".".join("a" * 3000) + "]",
            "x = " + "9" * 5000,
            "x = 0x" + "f" * 5000,
            "".join(f"k{k} = 1\n" for k in range(90_000)),
            rows * 20_000,
            "format = 1\nname = 'x'\n" + unknown,
            "name = '" + "n" * 900_000 + "'",
            "#" * 2_000_000,
            "dh = 1\njoint = {}\nbase = []\ntool = 3\nframes = 7\nq_order = 1\nsource = 2",
            "[base]\nrotation = [[1e300,0,0],[0,1e300,0],[0,0,1e300]]",
            "[base]\nxyz_mm = [" + "9" * 400 + ", 0, 0]",
            "x = 1979-05-27T07:32:00Z\ny = inf\nz = nan",
            "\x00",
        )
    ]
    by_kind[".json"] = [
        text.encode()
        for text in ("[" * 100_000, '{"a":' * 100_000, "9" * 5000, "null", "[]", '"x"', "NaN", "1")
    ]
    many = "".join(f'<link name="l{k}"/>' for k in range(100_000))
    chain = "".join(
        f'<joint name="j{k}" type="fixed"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
        for k in range(99_999)
    )
    by_kind[".urdf"] = [
        text.encode()
        for text in (
            f"<robot>{many}{chain}</robot>",
            f"<robot>{many}</robot>",
            "<robot>" + "<a>" * 200_000,
            "<robot><link " + " ".join(f'a{k}=""' for k in range(50_000)) + "/></robot>",
            URDF.replace("upper", "u" * 100_000, 1),
            URDF.replace('link="base"', f'link="{"b" * 100_000}"'),
            URDF.replace("0.3", "1e400").replace("0.2", "9" * 5000),
            URDF.replace("0.3", "1e300"),
            "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><robot name='&b;'/>",
            URDF.replace("</robot>", " " * (17 << 20) + "</robot>"),
            "<robot name='&#10;&#0;&#xD800;'><link name='&#10;'/></robot>",
        )
    ]
    readers = {".toml": (_robot, gain_file.read), ".json": (gain_file.read,), ".urdf": (_robot,)}
    cases = []
    for suffix, files in by_kind.items():
        for k, data in enumerate(files):
            for reader in readers.get(suffix, (_solve, read_results)):
                cases.append(Case(f"special {k} for {reader.__name__}{suffix}", data, reader))
    kept = dict(np.load(io.BytesIO(_checkpoint(folder))))
    cases += [
        Case(
            f"checkpoint {name} = {str(value)[:30]!r}.npz", _savez(**{**kept, name: value}), _resume
        )
        for name, values in _TAMPERED.items()
        for value in values
    ]
    return cases


_TAMPERED: dict[str, list[np.ndarray]] = {
    "identity": [np.array(text) for text in ("[1]", "null", "x", "[" * 100_000, "{}", "1")],
    "counts": [
        np.array(values)
        for values in ([-1, 0, 0], [99, 40, 1], [1, 10**12, 0], [1, 40, 10**6], [0.5, 1, 1], [1], 3)
    ],
    "cost": [np.array(value) for value in (np.nan, -1.0, np.inf, [0.0], "x", 1j)],
    "state": [
        np.zeros(3),
        np.array("x"),
        np.zeros((2, 2)),
        np.full(50, np.nan),
        np.zeros(3, complex),
    ],
    "gains": [
        np.array(json.dumps(value))
        for value in ({}, [], {"A": 1}, {"A": [[1]], "B": [[1]], "C": [[1]]}, {"B": None}, "x")
    ],
    "checksum": [np.array("0" * 64), np.array(1)],
}


# ---- the trial -----------------------------------------------------------------------------------


def cases(count: int, seed: int, folder: Path) -> Iterator[Case]:
    """Yield the special files and random damages, `count` in all."""
    made = special(folder)
    sound = seeds(folder)
    draw = random.Random(seed)
    if count < len(made):
        made = draw.sample(made, count // 2)
    special_count = len(made)
    while made:
        yield made.pop()
    for k in range(count - special_count):
        one = sound[k % len(sound)]
        damage = draw.choice(DAMAGES)
        stem, _, suffix = one.name.rpartition(".")
        yield Case(f"{stem} {k}{damage.__name__}.{suffix}", damage(one.data, draw), one.read)


def fault_of(case: Case, folder: Path) -> tuple[str, str]:
    """Return what became of a file, and what is wrong with that or nothing."""
    path = folder / f"case.{case.name.rpartition('.')[2]}"
    path.write_bytes(case.data)
    start = time.perf_counter()
    outcome, fault = "read", ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # An unstable A is warned of, and may be read.
            warnings.simplefilter("ignore", RuntimeWarning)
            case.read(path)
    except AgrikError as error:
        outcome = "refused"
        if "\n" in str(error) and not isinstance(error, ik.errors.RobotFileError):
            fault = f"more than a line: {error}"
        elif path.name not in str(error):
            fault = f"no file in the message: {error}"
        elif len(str(error)) > 100_000:
            fault = f"{len(str(error))} letters"
    except BaseException:
        outcome, fault = "fault", traceback.format_exc()
    took = time.perf_counter() - start
    if took > SECONDS:
        fault = fault or f"{took:.1f} s"
    return outcome, fault


def peak_bytes() -> int:
    """Return the most memory that this process has had since `forget_peak`."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.partition("VmHWM:")[2].split()[0]) << 10


def forget_peak() -> None:
    """Let the peak of memory begin anew."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--files", type=int, default=2000)
    arguments.add_argument("--seed", type=int, default=0)
    given = arguments.parse_args()
    outcomes: Counter[str] = Counter()
    slowest, largest = (0.0, ""), (0, "")
    faults = count = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in cases(given.files, given.seed, folder):
            count += 1
            forget_peak()
            start = time.perf_counter()
            outcome, fault = fault_of(case, folder)
            slowest = max(slowest, (time.perf_counter() - start, case.name))
            largest = max(largest, (peak_bytes(), case.name))
            outcomes[outcome] += 1
            if peak_bytes() > BYTES:
                fault = fault or f"{peak_bytes() >> 20} MiB of memory"
            if fault:
                faults += 1
                print(f"{case.name}: {fault}", file=sys.stderr, flush=True)
    counts = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    print(
        f"{count} damaged files: {counts}; {faults} faults; slowest {slowest[0]:.2f} s "
        f"({slowest[1]}); most memory {largest[0] >> 20} MiB ({largest[1]})"
    )
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
