"""Runs `agrik-fast` in the test's own process, in a folder of its own."""

from collections.abc import Callable

from typer.testing import CliRunner, Result

from agrik_fast.cli import _app as app_module

RunCommand = Callable[..., Result]


def run_command(*words: object) -> Result:
    """Run `agrik-fast` with these words."""
    return CliRunner().invoke(app_module.app, [str(word) for word in words])


def one_line(result: Result, code: int = 2) -> str:
    """Return the only line on stderr of a command that failed as it should."""
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    return lines[0]
