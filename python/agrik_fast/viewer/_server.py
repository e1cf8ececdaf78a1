"""A server of one's own, on a port that is free, which says nothing by itself."""

from __future__ import annotations

import contextlib
import io
import socket
from typing import Any

from ..errors import AgrikError, ArgumentError, MissingExtraError


def open_server(host: str, port: int) -> Any:
    """Return a viser server.

    Parameters
    ----------
    host : str
        What it listens to.
    port : int
        0 takes one that is free.

    Raises
    ------
    MissingExtraError
        viser is not installed.
    ArgumentError
        The port is taken, or the host is no address of this machine; names both.
    """
    try:
        import viser
    except ImportError:
        raise MissingExtraError("the viewer (viser)", "viewer") from None
    port = _free(host, port)
    # It greets on standard output, which belongs to whoever runs us.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label="agrik_fast", verbose=False)
    if server.get_port() != port:
        stop_server(server)
        raise ArgumentError("port", f"{port}, which another program uses", "a free port")
    return server


def stop_server(server: Any) -> None:
    """End a server without a word."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def _free(host: str, port: int) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            if port:
                reason = (error.strerror or str(error)).lower()
                received = f"{port} at {host}: {reason}"
                raise ArgumentError("port", received, "a free port (--port)") from None
            raise AgrikError(f"no port is free at {host}") from None
        found: int = probe.getsockname()[1]
    return found
