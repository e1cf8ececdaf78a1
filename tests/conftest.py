"""What every test file shares: settings of hypothesis, the checkout's folder, loaded robots."""

import functools
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import pytest

import agrik_fast

# A deadline would make the tests depend on how busy the machine is. The continuous
# integration always draws the same examples; a developer's runs draw new ones.
hypothesis.settings.register_profile(
    "agrik_fast", deadline=None, derandomize=bool(os.environ.get("CI"))
)
hypothesis.settings.load_profile("agrik_fast")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let `make rigs-full` ask for more than the tests usually do."""
    parser.addoption("--requests", type=int, default=500, help="requests on noisy lines")


@pytest.fixture(autouse=True)
def _threads_of_the_process() -> Iterator[None]:
    """Let no test change how many threads the next ones use."""
    before = agrik_fast.get_num_threads()
    yield
    left = agrik_fast.get_num_threads()
    agrik_fast.set_num_threads(None)
    assert left == before, f"{left} threads are left to the next test, not {before}"


@pytest.fixture(scope="session")
def requests_count(request: pytest.FixtureRequest) -> int:
    """Return how many requests go over a noisy line."""
    return int(request.config.getoption("--requests"))


@pytest.fixture(scope="session")
def repo_root() -> Path:
    """Return the folder that holds pyproject.toml."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def load_robot() -> Callable[[str], agrik_fast.Robot]:
    """Return `Robot.load` that reads each robot once."""
    return functools.cache(agrik_fast.Robot.load)
