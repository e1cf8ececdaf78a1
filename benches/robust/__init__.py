"""Arms, postures, requests and an independent judge: what `fuzz_arms.py` and `robustness.py` share.

Nothing here takes the library's word for where an arm stands: `chain` has forward kinematics and
errors of its own, and `judge` holds every answer against them.
"""
