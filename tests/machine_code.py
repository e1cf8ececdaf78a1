"""Finds vector instructions in a compiled module, without a disassembler."""

import platform
import re

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


def assert_holds_fast_path(module: bytes) -> None:
    """Fail unless a module for x86-64 holds the solver for AVX2 and for AVX-512.

    Whatever machine built it: the paths are chosen at run time. Elsewhere the vectors are the
    baseline's own, and nothing tells them from the rest.
    """
    if platform.machine().lower() in {"x86_64", "amd64"}:
        zmm, ymm = count_fused(module)
        assert zmm > 500, zmm
        assert ymm > 500, ymm
