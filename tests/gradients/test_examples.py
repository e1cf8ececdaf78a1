"""The examples of the modules that need torch or JAX run."""

import doctest
import importlib

import numpy as np
import pytest

import agrik_fast as ik


@pytest.mark.parametrize("module", ["agrik_fast.torch", "agrik_fast.jax"])
def test_examples_run(module: str) -> None:
    names = {"np": np, "ik": ik}
    outcome = doctest.testmod(importlib.import_module(module), extraglobs=names)
    assert outcome.attempted and not outcome.failed
