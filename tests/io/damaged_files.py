"""Damages files of every kind and gives them to the readers: `python tests/io/damaged_files.py`.

Every case is made from a seed. A reader may take a file or refuse it with an error of the
library on one line, or on a line for each of the first twenty faults; anything else is a fault:
another exception, more than `SECONDS`, more than `BYTES` of memory. `test_damaged_files.py` tries
a few, this script as many as it is told to.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from hostile_files import hostile_files
from sound_files import Case, sound_files

import agrik_fast as ik
from agrik_fast import AgrikError
from agrik_fast.io import DataFileError

SECONDS = 5.0
BYTES = 500 << 20


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


_WORDS = (
    *(b"nan", b"-inf", b"1e400", b"1" * 5000, b"true", b"", b"[]", b"{}", b'"x"', b"-1"),
    *(b"1e308", "९".encode(), b"\x00", b"0x10", b"'" * 3, b"a" * 200_000, b"1_0"),
)


def _swap_word(data: bytes, draw: random.Random) -> bytes:
    """Put another word in the place of one: mostly another number, or another type."""
    words = data.split(b" ") if b" " in data else data.split(b",")
    words[draw.randrange(len(words))] = draw.choice(_WORDS)
    return b" ".join(words) if b" " in data else b",".join(words)


DAMAGES = (_cut, _flip, _flip, _flip, _overwrite, _remove, _repeat, _encode, _swap_word)


# ---- the trial -----------------------------------------------------------------------------------


def cases(count: int, seed: int, folder: Path) -> Iterator[Case]:
    """Yield the special files and random damages, `count` in all."""
    made = hostile_files(folder)
    sound = sound_files(folder)
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


def most_breaks(error: AgrikError) -> float:
    """Return how many lines may follow the first: faults have a line each."""
    if isinstance(error, ik.errors.RobotFileError | ik.errors.GainFileError):
        return math.inf
    if isinstance(error, DataFileError) and " rows are faulty\n" in str(error):
        return 21  # twenty, and how many more
    return 0


def fault_of(case: Case, folder: Path) -> tuple[str, str]:
    """Return what became of a file, and what is wrong with that or nothing."""
    path = folder / f"case.{case.name.rpartition('.')[2]}"
    path.write_bytes(case.data)
    start = time.perf_counter()
    outcome, fault = "read", ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # An unstable A is warned of, and read all the same.
            warnings.filterwarnings("ignore", message=".*spectral radius")
            case.read(path)
    except AgrikError as error:
        outcome = "refused"
        if str(error).count("\n") > most_breaks(error):
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
