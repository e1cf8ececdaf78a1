"""Files that claim, nest or hold what they should not."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow
from pyarrow import parquet
from sound_files import URDF, Case, checkpoint, load_robot, resume, save, savez, solve, table

from agrik_fast.io import read_results
from agrik_fast.solvers import gain_file


def _repeated(row_id: str, rows: int) -> bytes:
    """Return rows of one id, which is in the file once."""
    ids = pyarrow.DictionaryArray.from_arrays(np.zeros(rows, dtype=np.int32), [row_id])
    columns = {"id": ids, **{f"{axis}_m": np.zeros(rows) for axis in "xyz"}}
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), stream, store_schema=False)
    return stream.getvalue()


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


def hostile_files(folder: Path) -> list[Case]:
    """Return files that claim, nest or hold what they should not."""
    by_kind: dict[str, list[bytes]] = {".npy": list(_headers())}
    good = save(np.zeros((2, 3)))
    by_kind[".npz"] = [_archive(position_m=data) for data in by_kind[".npy"]]
    by_kind[".npz"] += [_archive(position_m=good, id=data) for data in by_kind[".npy"]]
    by_kind[".npz"] += [_archive(method, position_m=good) for method in (12, 14)]
    by_kind[".npz"] += [
        _bomb("position_m", 50_000_000),
        _archive(position_m=good, id=save(np.array(["x" * 100_000, ""]))),
        _archive(position_m=good, id=_header("'<U1'", "(2,)") + b"\xff" * 8),
        _archive(position_m=good, id=_header("'<U1'", "(2,)") + b"\x00\xd8\x00\x00" * 2),
        _archive(position_m=good, id=save(np.array([2**64 - 1, 1], dtype=np.uint64))),
        _archive(**{f"k{k}": b"" for k in range(5000)}),
        save(np.zeros((2, 3))),
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
        table(**(whole | {"x_m": [2**53 + 1, 2]})),
        table(**(whole | {"x_m": np.array([2**64 - 1, 0], dtype=np.uint64)})),
        table(**xyz, id=np.array([2**64 - 1, 0], dtype=np.uint64)),
        table(**xyz, id=["x" * 131_000, "y"]),
        _repeated("x" * 131_000, 60_000),
        table(**xyz, id=[None, "y"]),
        table(**xyz, id=pyarrow.array(["a", "a"]).dictionary_encode()),
        table(**xyz, id=[b"\xff", b"y"]),
        table(**xyz, id=pyarrow.array(["a", "b"], pyarrow.large_string())),
        table(**(xyz | {"z_m": [[1.0], [2.0]]})),
        table(**(xyz | {"z_m": pyarrow.array([1, 2], pyarrow.decimal128(5))})),
        table(**(xyz | {"z_m": np.array([1, 2], dtype=np.float16)})),
        table(**{f"c{k}": [1] for k in range(2000)}),
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
    readers = {
        ".toml": (load_robot, gain_file.read),
        ".json": (gain_file.read,),
        ".urdf": (load_robot,),
    }
    cases = [
        Case(f"special {k} for {reader.__name__}{suffix}", data, reader)
        for suffix, files in by_kind.items()
        for k, data in enumerate(files)
        for reader in readers.get(suffix, (solve, read_results))
    ]
    kept = dict(np.load(io.BytesIO(checkpoint(folder))))
    cases += [
        Case(f"checkpoint {name} = {str(value)[:30]!r}.npz", savez(**{**kept, name: value}), resume)
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
