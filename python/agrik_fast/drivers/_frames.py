"""Frames on the line: ``COBS(type | sequence | payload | CRC-16) 0x00``.

The twin of ``firmware/link/frame.c``; a test feeds both the same bytes.
"""

from __future__ import annotations

import binascii
import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

from ._errors import RigError
from ._messages import PAYLOAD_MAX

HEAD, CRC = 2, 2
LONGEST = HEAD + PAYLOAD_MAX + CRC


@functools.cache
def _cobs() -> Any:
    try:
        from cobs import cobs
    except ImportError:
        raise RigError("drivers need cobs and pyserial: the extra agrik_fast[drivers]") from None
    return cobs


class Frame(NamedTuple):
    """A frame without its check.

    Attributes
    ----------
    type, sequence : int
        0 to 255.
    payload : bytes
        At most `PAYLOAD_MAX`.
    """

    type: int
    sequence: int
    payload: bytes = b""


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame on the line, delimiter included."""
    if len(frame.payload) > PAYLOAD_MAX:
        raise ValueError(f"a payload of {len(frame.payload)} bytes, at most {PAYLOAD_MAX} fit")
    body = bytes((frame.type, frame.sequence)) + frame.payload
    return (
        bytes(_cobs().encode(body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "little"))) + b"\0"
    )


class FrameReader:
    """Finds the frames in the bytes of a line, whatever else is between them.

    Attributes
    ----------
    crc_errors, frame_errors : int
        Frames that were dropped: their check failed; they were too short, too long or cut off.
    """

    def __init__(self) -> None:
        self.crc_errors = 0
        self.frame_errors = 0
        self._rest = bytearray()

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Take bytes from the line and yield the frames that they complete."""
        self._rest += data
        *complete, self._rest = self._rest.split(b"\0")
        # Noise without a delimiter must not pile up; what is cut is no frame any more.
        if len(self._rest) > 4 * LONGEST:
            del self._rest[: -2 * LONGEST]
        for piece in complete:
            if piece and (frame := self._decode(bytes(piece))):
                yield frame

    def _decode(self, piece: bytes) -> Frame | None:
        cobs = _cobs()
        try:
            body: bytes = cobs.decode(piece)
        except cobs.DecodeError:
            body = b""
        if not HEAD + CRC <= len(body) <= LONGEST:
            self.frame_errors += 1
            return None
        body, check = body[:-CRC], body[-CRC:]
        if binascii.crc_hqx(body, 0xFFFF) != int.from_bytes(check, "little"):
            self.crc_errors += 1
            return None
        return Frame(body[0], body[1], body[2:])
