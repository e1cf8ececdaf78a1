"""Make sin_cos.txt: sine and cosine with more digits than a double holds.

Needs mpmath (``pip install mpmath``), which no test does:

    python tests/data/make_sin_cos.py

Each line holds x, the sine and the cosine, the latter two as a sum of two doubles (together
106 bits), all as the 16 hexadecimal digits of their bits.
"""

import math
import random
import struct
from pathlib import Path

import mpmath

DIGITS = 60
LARGEST = 1e4
SEED = 20_240_501


def angles() -> list[float]:
    """Angles of every size, and those where rounding is hardest: next to quarter turns."""
    draw = random.Random(SEED)
    xs = [0.0, LARGEST, -LARGEST]
    xs += [draw.uniform(-LARGEST, LARGEST) for _ in range(500)]
    xs += [draw.uniform(-7.0, 7.0) for _ in range(200)]
    xs += [draw.choice((-1, 1)) * 10 ** draw.uniform(-300, 0) for _ in range(60)]
    # The doubles next to whole numbers of quarter turns: those with the least left over.
    quarters = [
        (abs(mpmath.mpf(float(k * mpmath.pi / 2)) - k * mpmath.pi / 2), float(k * mpmath.pi / 2))
        for k in range(1, 6367)
    ]
    hardest = [x for _, x in sorted(quarters)[:150]] + [x for _, x in quarters[:50]]
    for x in hardest:
        xs += [x, -x]
        xs += [math.nextafter(x, math.inf), -math.nextafter(x, 0.0)]
    # Odd eighths of a turn: where one quarter turn ends and the next begins.
    for k in [*range(1, 60, 2), *(2 * draw.randrange(6365) + 1 for _ in range(60))]:
        x = float(k * mpmath.pi / 4)
        xs += [x, -math.nextafter(x, math.inf), math.nextafter(x, 0.0)]
    return [x for x in xs if abs(x) <= LARGEST]


def digits(number: float) -> str:
    return struct.pack(">d", number).hex()


def two_doubles(value: mpmath.mpf) -> tuple[float, float]:
    high = float(value)
    return high, float(value - high)


def main() -> None:
    mpmath.mp.dps = DIGITS
    lines = ["# Made by make_sin_cos.py: x, sin high, sin low, cos high, cos low"]
    for x in angles():
        sin, cos = mpmath.sin(mpmath.mpf(x)), mpmath.cos(mpmath.mpf(x))
        lines.append(" ".join(map(digits, (x, *two_doubles(sin), *two_doubles(cos)))))
    path = Path(__file__).with_name("sin_cos.txt")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
