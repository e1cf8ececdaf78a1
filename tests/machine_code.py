"""Finds vector instructions in a compiled module, without a disassembler."""

import platform
import re
import sys
from array import array

# A fused multiply-add of packed doubles, vfmadd{132,213,231}pd, as machine code: opcode 98,
# A8 or B8 of map 0F38 with W = 1 and prefix 66. In 512-bit registers it has the four-byte EVEX
# prefix 62, in 256-bit registers the three-byte VEX prefix C4; the masks below leave the bits
# open that number the registers. By chance a megabyte would hold a fraction of one match.
ZMM = re.compile(rb"\x62[\x02-\xf2][\x85-\xfd][\x40-\x5f\xc0-\xdf][\x98\xa8\xb8]", re.DOTALL)
YMM = re.compile(rb"\xc4[\x02\x22\x42\x62\x82\xa2\xc2\xe2][\x85-\xfd][\x98\xa8\xb8]", re.DOTALL)


def count_fused(code: bytes) -> tuple[int, int]:
    """Return how many packed fused multiply-adds use 512-bit and 256-bit registers."""
    zmm = sum(
        (match[0][1] & 0x0F) == 0x02 and (match[0][2] & 0x87) == 0x85
        for match in ZMM.finditer(code)
    )
    ymm = sum((match[0][2] & 0x87) == 0x85 for match in YMM.finditer(code))
    return zmm, ymm


def count_fused_neon(code: bytes) -> int:
    """Return how many fused multiply-adds take two doubles in a NEON register (aarch64).

    FMLA and FMLS of ``.2d`` vectors, by vector and by element, apart from the bits that number
    the registers and the element. All instructions are whole words at multiples of four bytes.
    """
    words = array("I", code[: len(code) // 4 * 4])
    if sys.byteorder == "big":
        words.byteswap()
    by_vector = sum(word & 0xFF60FC00 == 0x4E60CC00 for word in words)
    by_element = sum(word & 0xFFE0B400 == 0x4FC01000 for word in words)
    return by_vector + by_element


def assert_holds_fast_path(module: bytes) -> None:
    """Fail unless a module holds the solver for the vectors of this kind of processor.

    For x86-64 both for AVX2 and for AVX-512, whatever machine built it: the paths are chosen at
    run time.
    """
    machine = platform.machine().lower()
    if machine in {"x86_64", "amd64"}:
        zmm, ymm = count_fused(module)
        assert zmm > 500, zmm
        assert ymm > 500, ymm
    elif machine in {"aarch64", "arm64"}:
        assert count_fused_neon(module) > 500
