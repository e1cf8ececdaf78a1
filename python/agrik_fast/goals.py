"""The former name of `agrik_fast.tuning.goals`, with the same functions."""

from .tuning.goals import joint_uniform, joint_uniform_q, splitmix64, volume_uniform

__all__ = ["joint_uniform", "joint_uniform_q", "splitmix64", "volume_uniform"]
