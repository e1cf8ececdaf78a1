"""Fruits from picture to picture: alpha-beta filters with a gate."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .._checks import FloatArray, float_array, real_number, whole_number
from ..errors import ArgumentError

__all__ = ["Track", "Tracker"]

_MEDIAN = 5
# A target that moves less than this stands still, and the median of five places is better.
_STILL_M_S = 0.012


@dataclass
class Track:
    """A fruit that was seen more than once.

    Attributes
    ----------
    number : int
        Its name, counted from 0.
    position : ndarray, shape (3,), m
        At `time`.
    velocity : ndarray, shape (3,), m/s
        Filtered.
    time : float, s
        Of the last picture that was looked at.
    hits, misses : int
        Pictures in which it was found, and those since.
    confirmed : bool
        It was found three times within the gate: only then is it worth a motion.

    Examples
    --------
    >>> from agrik_fast.vision import Tracker
    >>> tracker = Tracker()
    >>> (track,) = tracker.update(0.0, [[0.2, 0.0, 0.1]])
    >>> track.position.tolist()
    [0.2, 0.0, 0.1]
    """

    number: int
    position: FloatArray
    velocity: FloatArray
    time: float
    hits: int = 1
    misses: int = 0
    confirmed: bool = False
    _places: deque[FloatArray] = field(default_factory=lambda: deque(maxlen=_MEDIAN))

    @property
    def still(self) -> bool:
        """Whether it stands still, by its filtered velocity."""
        return len(self._places) == _MEDIAN and (
            float(np.linalg.norm(self._places[-1] - self._places[0])) < 0.003
            or float(np.linalg.norm(self.velocity)) < _STILL_M_S
        )

    def at(self, time: float) -> FloatArray:
        """Return where it is at a time, shape (3,), m: predicted, or the median while still.

        Examples
        --------
        >>> from agrik_fast.vision import Tracker
        >>> tracker = Tracker()
        >>> (track,) = tracker.update(0.0, [[0.2, 0.0, 0.1]])
        >>> track.at(0.1).shape
        (3,)
        """
        if self.still:
            return np.asarray(np.median(np.array(self._places), axis=0))
        return np.asarray(self.position + (time - self.time) * self.velocity)


class Tracker:
    """Matches the places found in a picture to fruits by the smallest distance.

    Parameters
    ----------
    alpha, beta : float, default 0.5 and 0.12
        Shares of the innovation that go into place and velocity.
    gate : float, default 0.015, m
        How far from its prediction a fruit may be found.
    gate_growth : float, default 0.05, m
        How much more for each picture in which it was not found.
    confirm : int, default 3
        Hits that a motion needs: the first wild detection has one.
    drop : int, default 10
        Misses after which a fruit is forgotten.

    Examples
    --------
    >>> from agrik_fast.vision import Tracker
    >>> tracker = Tracker()
    >>> for k in range(4):
    ...     tracks = tracker.update(k / 30, [[0.3, 0.001 * k, 0.1]])
    >>> tracks[0].confirmed, tracks[0].hits
    (True, 4)
    """

    def __init__(
        self,
        *,
        alpha: float = 0.5,
        beta: float = 0.12,
        gate: float = 0.015,
        gate_growth: float = 0.05,
        confirm: int = 3,
        drop: int = 10,
    ) -> None:
        self.alpha = real_number("alpha", alpha, 0, 1, open_low=True)
        self.beta = real_number("beta", beta, 0, 2)
        self.gate = real_number("gate", gate, 0, open_low=True, unit="m")
        self.gate_growth = real_number("gate_growth", gate_growth, 0, unit="m")
        self.confirm = whole_number("confirm", confirm, 1)
        self.drop = whole_number("drop", drop, 1)
        self.tracks: list[Track] = []
        self._next = 0
        self._time = -np.inf

    def update(self, time: float, points: ArrayLike) -> list[Track]:
        """Take the places found in a picture.

        Parameters
        ----------
        time : float, s
            When the picture was taken, later than the one before.
        points : array_like, shape (n, 3), m
            Places; rows that are not finite are no places.

        Returns
        -------
        list of Track
            All fruits that are not forgotten, longest known first.

        Raises
        ------
        ArgumentError
            The time does not grow, or the shape is another.

        Examples
        --------
        >>> from agrik_fast.vision import Tracker
        >>> tracker = Tracker()
        >>> _ = tracker.update(0.0, [[0.2, 0.0, 0.1]])
        >>> [track.hits for track in tracker.update(0.1, [[0.2, 0.0, 0.1]])]
        [2]
        """
        time = real_number("time", time, unit="s")
        places = float_array("points", points)
        if places.size == 0:
            places = places.reshape(0, 3)
        if places.ndim != 2 or places.shape[1] != 3:
            raise ArgumentError("points", f"shape {places.shape}", "shape (n, 3)")
        if time <= self._time:
            raise ArgumentError("time", f"{time!r}", f"later than the last picture, {self._time!r}")
        self._time = time
        places = places[np.isfinite(places).all(axis=1)]
        expected = [t.position + (time - t.time) * t.velocity for t in self.tracks]
        pairs = self._matched(expected, places)
        for number, track in enumerate(self.tracks):
            self._advance(track, time, expected[number], places, pairs.get(number))
        taken = set(pairs.values())
        for number, place in enumerate(places):
            if number not in taken:
                self.tracks.append(Track(self._next, place.copy(), np.zeros(3), time))
                self.tracks[-1]._places.append(place.copy())
                self._next += 1
        # What was never confirmed is forgotten at once.
        self.tracks = [
            t for t in self.tracks if t.misses < (self.drop if t.confirmed else self.confirm)
        ]
        for track in self.tracks:
            track.confirmed |= track.hits >= self.confirm
        return list(self.tracks)

    def _matched(self, expected: list[FloatArray], places: FloatArray) -> dict[int, int]:
        """Return which place belongs to which track: the nearest pair first."""
        far = np.array([np.linalg.norm(places - each, axis=1) for each in expected]).reshape(
            len(expected), len(places)
        )
        gates = np.array([self.gate + self.gate_growth * t.misses for t in self.tracks])
        far[far > gates[:, None] if len(gates) else far < 0] = np.inf
        pairs: dict[int, int] = {}
        while far.size and np.isfinite(far).any():
            track, place = np.unravel_index(int(far.argmin()), far.shape)
            pairs[int(track)] = int(place)
            far[track, :], far[:, place] = np.inf, np.inf
        return pairs

    def _advance(
        self, track: Track, time: float, expected: FloatArray, places: FloatArray, hit: int | None
    ) -> None:
        step = time - track.time
        track.time = time
        if hit is None:
            track.misses += 1
            if not track.confirmed:
                track.hits = 0
            # A fruit that is hidden is expected where it was, not where it would have got to.
            track.velocity = 0.8 * track.velocity
            track.position = expected
            return
        off = places[hit] - expected
        track.position = expected + self.alpha * off
        track.velocity = track.velocity + self.beta / step * off
        track.hits += 1
        track.misses = 0
        track._places.append(places[hit].copy())
