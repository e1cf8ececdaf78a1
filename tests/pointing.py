"""The tomato loop in lockstep: fruits before a simulated rig, and how near its tip comes."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agrik_fast.arms import TomatoArm
from agrik_fast.drivers import LockstepCamera, PointingLoop, PointingStep, Simulator, TomatoRig
from agrik_fast.vision import (
    Camera,
    Detector,
    Fruit,
    Leaf,
    Look,
    Scene,
    Wall,
    looking_at,
    paper_camera,
    render,
)

CAMERA = paper_camera()
POSE = looking_at([-0.10, 0.0, 0.14], [0.25, 0.0, 0.06])
RADIUS = 0.03
WALL = Wall(point=(0.55, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
# Light from above and behind the camera.
LOOK = Look(light=(-0.6, 0.2, 0.75))
ARM = TomatoArm()
# Degrees that servos yield: twice their torque over the one that stalls them.
NOISE = {f"servo{i}.noise": 0.1 for i in range(3)} | {"droop0": 1.14, "droop1": 0.36}


def calibrated(camera: Camera = CAMERA) -> Detector:
    """Return a detector whose outlines a ball of known size and place has set right."""
    far = 0.35
    ball = Scene((Fruit((0.0, 0.0, far), RADIUS),), wall=Wall(), look=Look())
    plain = Detector(camera)
    bias = plain.bias(render(ball, camera).image, RADIUS, far)
    return Detector(camera, edge_bias_px=bias)


def fruits(count: int, seed: int = 0) -> list[np.ndarray[Any, Any]]:
    """Return centres that the arm can point at and the camera sees whole."""
    rng = np.random.default_rng([8, seed])
    found: list[np.ndarray[Any, Any]] = []
    rig = TomatoRig()
    while len(found) < count:
        turn, lift = np.radians([rng.uniform(-35, 35), rng.uniform(-20, 35)])
        way = np.array([np.cos(turn) * np.cos(lift), np.sin(turn) * np.cos(lift), np.sin(lift)])
        centre = rng.uniform(0.24, 0.34) * way
        uv = CAMERA.project(POSE[:3, :3].T @ (centre - POSE[:3, 3]))
        inside = (uv > 45).all() and (uv < [275, 195]).all()
        final = centre - (RADIUS + 0.010) * way
        first = centre - (RADIUS + 0.040) * way
        reachable = all(within(rig, point) for point in (final, first, 0.14 * way))
        if inside and reachable:
            found.append(centre)
    return found


def within(rig: TomatoRig, point: np.ndarray[Any, Any]) -> bool:
    """Whether the arm gets to a point from its home."""
    return bool(ARM.solve(point).success) and bool(
        ((ARM.solve(point).q >= rig.lower) & (ARM.solve(point).q <= rig.upper)).all()
    )


def hidden_for_ten(centre: np.ndarray[Any, Any]) -> Callable[[float], tuple[Leaf, ...]]:
    """Return the leaves at a time: one before the fruit for ten pictures, from 1.5 s on."""
    to_camera = POSE[:3, 3] - centre
    to_camera /= np.linalg.norm(to_camera)
    place = tuple((centre + 0.08 * to_camera).tolist())
    leaf = Leaf(place, (0.0, 1.0, 0.2), tuple(to_camera.tolist()), 0.2, 0.16)
    return lambda time: (leaf,) if 45 / 30 < time < 55 / 30 else ()


@dataclass
class Seen:
    """Steps of the loop, with where the tip and the fruit truly were."""

    steps: list[PointingStep] = field(default_factory=list)
    time: list[float] = field(default_factory=list)
    tip: list[np.ndarray[Any, Any]] = field(default_factory=list)
    centre: list[np.ndarray[Any, Any]] = field(default_factory=list)

    def to_stand_off(self) -> np.ndarray[Any, Any]:
        """Return how far the tip was from the true stand-off point, m, each step."""
        gaps = np.array([step.gap for step in self.steps])
        centre = np.array(self.centre)
        way = centre / np.linalg.norm(centre, axis=1)[:, None]
        goal = centre - (RADIUS + np.nan_to_num(gaps, nan=0.010))[:, None] * way
        return np.asarray(np.linalg.norm(np.array(self.tip) - goal, axis=1))

    def to_surface(self) -> np.ndarray[Any, Any]:
        """Return how far the tip was from the fruit's surface, m."""
        off = np.array(self.tip) - np.array(self.centre)
        return np.asarray(np.linalg.norm(off, axis=1) - RADIUS)


def tip_of(simulator: Simulator) -> np.ndarray[Any, Any]:
    """Return where the simulated arm's tip truly is, m."""
    state = simulator.state()
    return np.asarray(ARM.fk(np.radians([state[f"angle{i}"] for i in range(3)])))


@contextmanager
def pointing(
    place: Callable[[float], np.ndarray[Any, Any]],
    numbers: Mapping[str, float] | None = None,
    *,
    leaves: Callable[[float], tuple[Leaf, ...]] = lambda time: (),
    wild: float = 0.0,
    seed: int = 0,
    **options: Any,
) -> Iterator[tuple[Simulator, TomatoRig, Callable[[int], Seen]]]:
    """Yield a rig at home before a fruit, and a function that works through so many frames."""
    simulator = Simulator("tomato", numbers=numbers)
    rng = np.random.default_rng([9, seed])
    with TomatoRig(simulator) as rig:
        rig.home()
        begin = simulator.now()

        def scene(time: float) -> Scene:
            centre = tuple(place(time - begin).tolist())
            return Scene((Fruit(centre, RADIUS),), leaves(time - begin), WALL, LOOK, seed)

        detector = calibrated()
        if wild:
            detector = Wild(detector, wild, rng)  # type: ignore[assignment]
        loop = PointingLoop(rig, detector, POSE, RADIUS, **options)
        camera = LockstepCamera(simulator, scene, CAMERA, POSE)

        def frames(count: int) -> Seen:
            seen = Seen()

            def note(step: PointingStep) -> None:
                seen.steps.append(step)
                seen.time.append(simulator.now() - begin)
                seen.tip.append(tip_of(simulator))
                seen.centre.append(place(simulator.now() - begin))

            loop.run(camera, frames=count, progress=note)
            return seen

        yield simulator, rig, frames


class Wild(Detector):
    """A detector that at times sees the fruit where it is not."""

    def __init__(self, plain: Detector, share: float, rng: np.random.Generator) -> None:
        super().__init__(plain.camera, edge_bias_px=plain.edge_bias_px)
        self.share, self.rng = share, rng

    def detect(self, image: Any) -> Any:
        """Return what is there, or something at a place by chance."""
        from dataclasses import replace

        found = super().detect(image)
        if found and self.rng.random() < self.share:
            axis = self.camera.rays(self.rng.uniform([40, 40], [280, 200]))
            alpha = found[0].alpha * float(self.rng.uniform(0.6, 1.6))
            found[0] = replace(found[0], axis=axis, uv=self.camera.project(axis), alpha=alpha)
        return found
