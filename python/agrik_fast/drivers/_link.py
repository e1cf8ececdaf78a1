"""Requests and answers over a line that may lose and garble bytes."""

from __future__ import annotations

import logging
import logging.handlers
import struct
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, Self, TypeVar

from .._checks import real_number, shown, text, whole_number
from ..errors import ArgumentError
from ._errors import CommandRefusedError, LinkError, WrongDeviceError
from ._frames import Frame, FrameReader, encode
from ._messages import PAYLOAD_MAX, REPLIES, VERSION, Ack, Board, Code, Identity, Report, Type
from ._transport import SerialTransport, Transport

_LOG_BYTES = 4 << 20
_LOG_FILES = 3
# A board that a port's opening resets talks after its boot loader.
_PATIENCE_S = 4.0
_RIGS = {Board.MEGA2560: "strawberry", Board.MEGA8: "tomato"}


class _Payload(Protocol):
    @classmethod
    def unpack(cls, payload: bytes) -> Self: ...


_PayloadT = TypeVar("_PayloadT", bound=_Payload)


@dataclass
class LinkStatistics:
    """What a link has seen.

    Attributes
    ----------
    requests, answered : int
        Requests made, and those that were answered.
    retries, timeouts : int
        Frames sent again, and requests that were given up.
    stray : int
        Good frames that were no answer to what was asked.
    crc_errors, frame_errors : int
        Damaged frames from the board.
    slowest, total : float, s
        Longest and added times from request to answer.

    Examples
    --------
    >>> from agrik_fast.drivers import Link, Simulator
    >>> link = Link(Simulator("strawberry"))
    >>> _ = link.hello()
    >>> link.statistics.answered >= 1
    True
    >>> link.close()
    """

    requests: int = 0
    answered: int = 0
    retries: int = 0
    timeouts: int = 0
    stray: int = 0
    crc_errors: int = 0
    frame_errors: int = 0
    slowest: float = 0.0
    total: float = 0.0

    @property
    def mean(self) -> float:
        """Mean time from request to answer, s."""
        return self.total / self.answered if self.answered else 0.0


@dataclass
class Link:
    """A line to a board: one request at a time, repeated until it is answered.

    A repeated request has the same sequence number, by which the board knows that it has
    carried it out already. Threads may share a link.

    Parameters
    ----------
    port : str or Transport
        What pyserial takes (``/dev/ttyACM0``, ``COM3``, ``socket://host:port``, ``loop://``), or
        a `Simulator`.
    timeout : float, default 0.08, s
        How long to wait for an answer before the request is sent again.
    tries : int, default 5
        How often a request is sent; all of them together end before the board gives up.
    log : path, optional
        File that every frame is written to; at 4 MiB it is renamed and begun anew, three are kept.

    Attributes
    ----------
    statistics : LinkStatistics
        What was sent and what became of it.

    Raises
    ------
    LinkError
        The port cannot be opened.
    ArgumentError
        A number is out of its range.

    Examples
    --------
    >>> from agrik_fast.drivers import Link, LinkError
    >>> with Link("loop://", tries=1) as link:
    ...     try:
    ...         link.ping(b"hello")
    ...     except LinkError as error:
    ...         print(error)
    loop://: no answer to PING after 1 try (1 frame came that was no answer)
    """

    port: str | Transport
    timeout: float = 0.08
    tries: int = 5
    log: Path | str | None = None
    statistics: LinkStatistics = field(default_factory=LinkStatistics, init=False)

    def __post_init__(self) -> None:
        link_options(self.timeout, self.tries, self.log)
        self._lock = threading.RLock()
        self._reader = FrameReader()
        self._sequence = 0
        given = self.port
        if not isinstance(given, str) and not callable(getattr(given, "read", None)):
            raise ArgumentError("port", shown(given), "a port's name or a Transport")
        self.transport: Transport = SerialTransport(given) if isinstance(given, str) else given
        try:
            self._logger = _frame_log(self.log)
        except BaseException:
            self.transport.close()
            raise

    @property
    def name(self) -> str:
        """The port's name."""
        return self.transport.name

    def request(self, kind: Type, payload: bytes = b"", *, tries: int | None = None) -> bytes:
        """Ask, and return the payload of the answer.

        Parameters
        ----------
        kind : Type
            What is asked.
        payload : bytes
            Its content.
        tries : int, optional
            Instead of the link's own.

        Raises
        ------
        LinkError
            No answer after all tries, or the line broke.
        ArgumentError
            The payload is too long, or no bytes.

        Examples
        --------
        >>> from agrik_fast.drivers import Link, Simulator
        >>> from agrik_fast.drivers._messages import Type
        >>> link = Link(Simulator("strawberry"))
        >>> _ = link.hello()
        >>> link.request(Type.PING, b"abc")
        b'abc'
        >>> link.close()
        """
        given: tuple[object, object] = kind, payload
        if not isinstance(given[0], Type) or kind not in REPLIES:
            raise ArgumentError("kind", shown(kind), "a type of request")
        if not isinstance(given[1], bytes):
            raise ArgumentError("payload", shown(payload), f"at most {PAYLOAD_MAX} bytes")
        if len(payload) > PAYLOAD_MAX:
            raise ArgumentError("payload", f"{len(payload)} bytes", f"at most {PAYLOAD_MAX} bytes")
        tries = self.tries if tries is None else whole_number("tries", tries, 1, 1000)
        with self._lock:
            self._sequence = (self._sequence + 1) & 0xFF
            sent = Frame(kind, self._sequence, payload)
            stats, clock = self.statistics, self.transport.now
            stats.requests += 1
            start, before = clock(), stats.stray
            for attempt in range(tries):
                stats.retries += attempt > 0
                self._note(">", sent)
                self.transport.write(encode(sent))
                answer = self._answer(sent, clock() + self.timeout)
                if answer is not None:
                    stats.answered += 1
                    stats.total += clock() - start
                    stats.slowest = max(stats.slowest, clock() - start)
                    return answer
            stats.timeouts += 1
            stray = stats.stray - before
            more = ""
            if stray:
                frames = "1 frame" if stray == 1 else f"{stray} frames"
                more = f" ({frames} came that {'was' if stray == 1 else 'were'} no answer)"
            after = "1 try" if tries == 1 else f"{tries} tries"
            raise LinkError(self.name, f"no answer to {kind.name} after {after}{more}")

    def _answer(self, sent: Frame, deadline: float) -> bytes | None:
        """Wait for the answer to a frame; None if it does not come in time."""
        expected = REPLIES[Type(sent.type)]
        stats, reader = self.statistics, self._reader
        found = None
        while found is None and (left := deadline - self.transport.now()) > 0:
            for frame in reader.feed(self.transport.read(left)):
                self._note("<", frame)
                if (frame.type, frame.sequence) == (expected, sent.sequence) and found is None:
                    found = frame.payload
                else:
                    stats.stray += 1
        stats.crc_errors, stats.frame_errors = reader.crc_errors, reader.frame_errors
        return found

    def _read(self, kind: Type, form: type[_PayloadT], payload: bytes) -> _PayloadT:
        try:
            return form.unpack(payload)
        except struct.error:
            reason = f"the answer to {kind.name} has {len(payload)} bytes: another protocol"
            raise WrongDeviceError(self.name, reason) from None

    def ping(self, payload: bytes = b"") -> None:
        """Ask for an echo.

        Raises
        ------
        LinkError
            No answer, or another echo.

        Examples
        --------
        >>> from agrik_fast.drivers import Link, Simulator
        >>> link = Link(Simulator("strawberry"))
        >>> _ = link.hello()
        >>> link.ping(b"hello")
        >>> link.close()
        """
        if self.request(Type.PING, payload) != payload:
            raise LinkError(self.name, "the echo of PING is another one")

    def hello(self, board: Board | None = None, *, patience: float = _PATIENCE_S) -> Identity:
        """Ask who is there; the board also forgets which command it carried out last.

        Parameters
        ----------
        board : Board, optional
            Who should be there.
        patience : float, default 4.0, s
            How long to ask: opening a port resets some boards.

        Returns
        -------
        Identity
            Version of the protocol, board, build, cause of the last reset.

        Raises
        ------
        WrongDeviceError
            Another device, another version of the protocol or another board.
        LinkError
            Nobody answers.

        Examples
        --------
        >>> from agrik_fast.drivers import Link, Simulator
        >>> link = Link(Simulator("strawberry"))
        >>> link.hello().board
        1
        >>> link.close()
        """
        if board is not None and not isinstance(board, Board):
            raise ArgumentError("board", shown(board), "a Board or None")
        patience = real_number("patience", patience, 0, 60, unit="s")
        with self._lock:
            end = self.transport.now() + patience
            before, heard = self.statistics.stray, self._damaged()
            while True:
                try:
                    payload = self.request(Type.HELLO, tries=1)
                    break
                except WrongDeviceError:
                    raise
                except LinkError as error:
                    if "no answer" not in error.reason:
                        raise
                    if self.transport.now() >= end:
                        raise self._stranger(before, heard, patience) from None
            identity = self._read(Type.HELLO, Identity, payload)
        if identity.version != VERSION:
            raise WrongDeviceError(
                self.name,
                f"the board speaks version {identity.version} of the protocol, "
                f"this program version {VERSION}: load the firmware that belongs to it",
            )
        if board is not None and identity.board != board:
            known = set(Board)
            other = Board(identity.board) if identity.board in known else None
            what = f"number {identity.board}" if other is None else _board(other)
            raise WrongDeviceError(self.name, f"the board is {what}, expected {_board(board)}")
        return identity

    def _damaged(self) -> int:
        return self._reader.crc_errors + self._reader.frame_errors

    def _stranger(self, stray: int, damaged: int, patience: float) -> LinkError:
        """Say what answered instead of a board."""
        if self.statistics.stray > stray:
            reason = "what is there sends back what it gets: no board of this project"
            return WrongDeviceError(self.name, reason)
        if self._damaged() > damaged:
            reason = "what is there does not speak this protocol: another device, or another speed"
            return WrongDeviceError(self.name, reason)
        return LinkError(
            self.name,
            f"nobody answers HELLO in {patience:g} s: is the board on, and its firmware loaded?",
        )

    def report(self) -> Report:
        """Ask for the board's state.

        Examples
        --------
        >>> from agrik_fast.drivers import Link, Simulator
        >>> link = Link(Simulator("strawberry"))
        >>> _ = link.hello()
        >>> link.report().state
        0
        >>> link.close()
        """
        return self._read(Type.STATUS, Report, self.request(Type.STATUS))

    def command(self, kind: Type, payload: bytes = b"", what: str = "") -> None:
        """Have a command carried out, once.

        Raises
        ------
        CommandRefusedError
            The board refuses.
        LinkError
            No answer.

        Examples
        --------
        >>> from agrik_fast.drivers import Link, Simulator
        >>> from agrik_fast.drivers._messages import Type
        >>> link = Link(Simulator("strawberry"))
        >>> _ = link.hello()
        >>> link.command(Type.STOP)
        >>> link.close()
        """
        what = text("what", what)
        ack = self._read(kind, Ack, self.request(kind, payload))
        if ack.code != Code.OK:
            known = set(Code)
            name = Code(ack.code).name.lower() if ack.code in known else f"code {ack.code}"
            raise CommandRefusedError(what or kind.name, name)

    def close(self) -> None:
        """Give the port and the log up.

        Examples
        --------
        >>> from agrik_fast.drivers import Link
        >>> link = Link("loop://", tries=1)
        >>> link.close()
        """
        self.transport.close()
        if self._logger:
            for handler in list(self._logger.handlers):
                handler.close()
                self._logger.removeHandler(handler)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _note(self, way: str, frame: Frame) -> None:
        if self._logger:
            known = set(Type)
            name = Type(frame.type).name if frame.type in known else f"{frame.type:#04x}"
            self._logger.info(
                "%.6f %s %s %d %s",
                self.transport.now(),
                way,
                name,
                frame.sequence,
                frame.payload.hex() or "-",
            )


def link_options(timeout: float, tries: int, log: Path | str | None) -> dict[str, Any]:
    """Return options of a link that are in order.

    Raises
    ------
    ArgumentError
        One is not.
    """
    if log is not None and not isinstance(log, str | Path):
        raise ArgumentError("log", shown(log), "a path or None")
    return {
        "timeout": real_number("timeout", timeout, 0, 60, open_low=True, unit="s"),
        "tries": whole_number("tries", tries, 1, 1000),
        "log": log,
    }


def _board(board: Board) -> str:
    return f"{board.name.lower()} (the {_RIGS[board]} rig)"


def _frame_log(file: Path | str | None) -> Any:
    if file is None:
        return None
    logger = logging.Logger("agrik_fast.drivers.frames")
    try:
        handler = logging.handlers.RotatingFileHandler(
            file, maxBytes=_LOG_BYTES, backupCount=_LOG_FILES - 1, encoding="utf-8"
        )
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or "no name of a file"
        raise ArgumentError("log", f"{shown(file)}: {why}", "a file that can be written") from None
    handler.setFormatter(logging.Formatter("%(message)s"))
    logger.addHandler(handler)
    return logger
