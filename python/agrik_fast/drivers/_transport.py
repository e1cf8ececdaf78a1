"""Where the bytes of a link go, and whose time they take."""

from __future__ import annotations

import os
import time
from typing import Any, Protocol

from .._checks import text
from ._errors import LinkError
from ._messages import BAUD


class Transport(Protocol):
    """A line to a board, with the clock that its time-outs count by."""

    name: str

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read(self, timeout: float) -> bytes:
        """Return what has come, waiting up to `timeout` seconds for the first byte."""

    def now(self) -> float:
        """Return the time, s."""

    def sleep(self, seconds: float) -> None:
        """Let time pass."""

    def close(self) -> None:
        """Give the line up."""


class SerialTransport:
    """A port, by whatever address pyserial takes: a device, ``socket://``, ``loop://``, a pty.

    Parameters
    ----------
    url : str
        The address.

    Raises
    ------
    LinkError
        There is no such port, or it cannot be opened.

    Examples
    --------
    >>> from agrik_fast.drivers import SerialTransport
    >>> port = SerialTransport("loop://")
    >>> port.close()
    """

    def __init__(self, url: str) -> None:
        url = text("url", url)
        try:
            import serial
        except ImportError:
            reason = "serial ports need pyserial; install the extra: agrik_fast[drivers]"
            raise LinkError(url, reason) from None
        self.name = url
        self._failures: Any = (serial.SerialException, OSError)
        try:
            self._port: Any = serial.serial_for_url(url, baudrate=BAUD, timeout=0, write_timeout=1)
        except (*self._failures, ValueError) as error:
            raise LinkError(url, f"cannot be opened: {_brief(error)}") from None

    def write(self, data: bytes) -> None:
        """Send bytes.

        Examples
        --------
        >>> from agrik_fast.drivers import SerialTransport
        >>> port = SerialTransport("loop://")
        >>> port.write(b"echo")
        >>> port.close()
        """
        try:
            self._port.write(data)
        except self._failures as error:
            raise LinkError(self.name, f"the line broke: {_brief(error)}") from None

    def read(self, timeout: float) -> bytes:
        """Return what has come, waiting up to `timeout` seconds for the first byte.

        Examples
        --------
        >>> from agrik_fast.drivers import SerialTransport
        >>> port = SerialTransport("loop://")
        >>> port.write(b"echo")
        >>> port.read(timeout=0.5)
        b'echo'
        >>> port.close()
        """
        try:
            self._port.timeout = timeout
            data: bytes = self._port.read(1)
            if data and (more := self._port.in_waiting):
                data += self._port.read(more)
        except (*self._failures, TypeError) as error:
            # pyserial has a TypeError for a port that another thread closed.
            raise LinkError(self.name, f"the line broke: {_brief(error)}") from None
        return data

    def now(self) -> float:
        """Return the time, s.

        Examples
        --------
        >>> from agrik_fast.drivers import SerialTransport
        >>> port = SerialTransport("loop://")
        >>> port.now() > 0
        True
        >>> port.close()
        """
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Let time pass.

        Examples
        --------
        >>> from agrik_fast.drivers import SerialTransport
        >>> port = SerialTransport("loop://")
        >>> port.sleep(0.001)
        >>> port.close()
        """
        time.sleep(seconds)

    def close(self) -> None:
        """Give the line up.

        Examples
        --------
        >>> from agrik_fast.drivers import SerialTransport
        >>> port = SerialTransport("loop://")
        >>> port.close()
        """
        # pyserial leaves a socket open whose other end has gone.
        connection = getattr(self._port, "_socket", None)
        self._port.close()
        if connection is not None:
            connection.close()


def _brief(error: BaseException) -> str:
    """Return a message on one line, without what repeats the port's name."""
    number = getattr(error, "errno", None)
    if isinstance(number, int):
        return os.strerror(number).lower()
    return " ".join(str(error).split()) or type(error).__name__
