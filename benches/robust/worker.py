"""A process that does cases, one after the other, and tells the watchdog what it is about to do.

Lines in: the number of a case. Lines out, as JSON: what is being called, and what a case found.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from . import cases


def main(seed: int, noise: Path) -> None:
    """Serve until the input ends; what Rust writes to stderr when it panics goes to `noise`."""
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)

    def reply(**what: object) -> None:
        replies.write(json.dumps(what) + "\n")

    for line in sys.stdin:
        number = int(line)
        reply(doing="start", case=number)
        outcome = cases.run(seed, number, lambda doing, n=number: reply(doing=doing, case=n))
        if noise.exists() and (text := noise.read_text(errors="replace")):
            os.truncate(noise, 0)
            if "panicked at" in text:
                outcome.add("panic", text[:600], number, "", "")
        reply(done=number, counts=outcome.counts, tally=outcome.tally, faults=outcome.faults)
