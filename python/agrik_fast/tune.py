"""The former name of `agrik_fast.tuning`, with the same classes and functions."""

from .tuning import Report, Tuning, template, tune

__all__ = ["Report", "Tuning", "template", "tune"]
