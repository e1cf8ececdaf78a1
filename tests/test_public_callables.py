"""Every public callable, found by a walk: bad input raises documented exceptions and nothing else.

What is public is discovered, so that what comes later is walked too: a new class with methods, or
a new name of a required argument, wants a line in the tables below, and the walk says so.
"""

import dataclasses
import functools
import importlib
import inspect
import pkgutil
import typing
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pydantic
import pytest

import agrik_fast as ik
from agrik_fast import _native
from agrik_fast.arms import PointMass, StrawberryArm, TomatoArm
from agrik_fast.collision import (
    Body,
    Box,
    Capsule,
    Cloud,
    Convex,
    Cover,
    HalfSpace,
    Scene,
    SceneObject,
    Sphere,
    Target,
)
from agrik_fast.drivers import (
    Link,
    LockstepCamera,
    PointingLoop,
    SerialTransport,
    Simulator,
    StrawberryRig,
    TomatoRig,
    Transport,
)
from agrik_fast.drivers._messages import Type
from agrik_fast.errors import AgrikError
from agrik_fast.tuning import Tuning
from agrik_fast.vision import (
    Camera,
    Detector,
    Device,
    Fruit,
    StereoPair,
    Tracker,
    paper_camera,
    random_scene,
    render,
)
from agrik_fast.vision import Scene as DrawnScene

# Files and the jobs over them have tests of their own, which damage them; papers and viewers write
# files and start servers, drawings are given axes, and torch and JAX are not installed everywhere.
ELSEWHERE = (
    "agrik_fast.cli",
    "agrik_fast.cluster",
    "agrik_fast.collision.drawing",
    "agrik_fast.harvest.drawing",
    "agrik_fast.io",
    "agrik_fast.jax",
    "agrik_fast.jobs",
    "agrik_fast.papers",
    "agrik_fast.plots",
    "agrik_fast.torch",
    "agrik_fast.viewer",
)
# Exceptions and codes hold what they are given; tables of files are checked by their readers,
# which turn the model's error into one of ours.
RECORDS = (BaseException, tuple, int, pydantic.BaseModel)
# Records that the library makes and nobody else.
ANSWERS = {
    "Agreement", "Arrival", "Attempt", "Blockers", "Branches", "Budget", "CameraCalibration",
    "CameraPose",
    "Checked", "Command", "Commands", "Cone", "Contact", "Cut", "CutProof", "Cycle", "Decision",
    "Decisions", "Detection", "DhRow", "Distances", "Evaluation", "ExcludedPair", "Family",
    "FruitTruth", "IkResult", "JointPath", "Leg", "LinkStatistics", "LongFruit", "Obstacle",
    "PacedResult", "Path", "PathBlockers", "PathSensitivity", "Plan", "Plane", "PointingStep",
    "Programme", "Rendering", "Report", "RigStatus", "Risks", "Run", "Runs", "SelfPairs",
    "Sensitivity", "Simulated", "Straightened", "StrawberryResult", "Surface", "Terms",
    "TomatoBranches", "TomatoResult", "Torques", "Track", "Trajectory",
}  # fmt: skip
# Objects and files, for which nothing but their own kind makes sense: what is none at all is the
# type checker's business, as it is for `Robot(definition)`, which users do not call.
OBJECTS = {
    "checkpoint", "chunks", "content", "definition", "directory", "found", "gain", "kind", "log",
    "path", "progress", "report", "resume", "robot", "source", "store", "tuning",
}  # fmt: skip
# Texts and paths: what is neither is a TypeError in Python's own words.
TEXTS = {"base_link", "name", "name_or_path", "path_or_text", "tip_link"}
# How many: huge numbers ask for more memory than there is.
COUNTS = {"count", "draws", "n"}

ARM = ik.Robot.load("redundant7")
POSES = ARM.fk(ARM.random_q(2, seed=1))
CUCUMBER = ik.Robot.load("cucumber")
DETECTOR = Detector(paper_camera())
IMAGE = np.zeros((240, 320, 3), np.uint8)
DETECTIONS = DETECTOR.detect(render(random_scene("clean")).image)
SCENE = Scene(
    [SceneObject.of("a name", Sphere((0.4, 0.4, 0.4), 0.1))],
    targets={"a name": Target((0.4, 0.4, 0.4))},
)


@functools.cache
def receivers() -> dict[type, Any]:
    """An object of each class whose methods are walked."""
    return {
        ik.Robot: ARM,
        _native.TargetSolver: ARM.solver(),
        StrawberryArm: StrawberryArm(),
        TomatoArm: TomatoArm(),
        Scene: SCENE,
        SceneObject: SCENE.objects[0],
        Sphere: Sphere((0, 0, 0), 1),
        Capsule: Capsule((0, 0, 0), (0, 0, 1), 1),
        Box: Box((0, 0, 0), (1, 1, 1)),
        Cover: Cover((0, 0, 0), (1, 1, 1)),
        Convex: Convex(((0, 0, 0),)),
        HalfSpace: HalfSpace((0, 0, 1), 0),
        # Not connected: rigs on simulators have tests of their own.
        StrawberryRig: StrawberryRig("loop://"),
        TomatoRig: TomatoRig("loop://"),
        Link: Link("loop://", timeout=0.001, tries=1),
        Camera: paper_camera(),
        Detector: Detector(paper_camera()),
        StereoPair: StereoPair(Camera.of_view(64, 48, 60), 0.06),
        Tracker: Tracker(),
        PointingLoop: PointingLoop(TomatoRig("loop://"), DETECTOR, np.eye(4), 0.03),
        # Walked by their constructors alone, as they are lines that something else uses.
        SerialTransport: None,
        Simulator: None,
        Device: None,
        LockstepCamera: None,
        Transport: None,
    }


# An argument of each name that is in order.
ARGUMENTS: dict[str, Any] = {
    "a": np.zeros(3),
    "along": (1.0, 0.0, 0.0),
    "base_from_camera": np.eye(4),
    "board": np.stack([np.eye(4)] * 3),
    "boxes": [[10, 10, 20, 20]],
    "camera": paper_camera(),
    "crate": np.zeros(7),
    "goals": np.zeros(7),
    "decisions": ik.harvest.plan("cucumber", ik.harvest.example_scene(), ["C1"]),
    "clock": Link("loop://").transport,
    "cx": 160.0,
    "cy": 120.0,
    "depth": np.full((240, 320), 0.5),
    "degrees": 60.0,
    "detection": DETECTIONS[0],
    "detector": DETECTOR,
    "distance": 0.3,
    "file": "none.png",
    "fx": 300.0,
    "fy": 300.0,
    "gripper": np.stack([np.eye(4)] * 3),
    "height": 240,
    "image": IMAGE,
    "images": [IMAGE],
    "left": IMAGE,
    "mask": np.zeros((240, 320), np.uint8),
    "masks": np.zeros((1, 240, 320), bool),
    "matches": np.ones((1, 4)),
    "matrix": paper_camera().matrix,
    "joints": {},
    "limits": {},
    "measure": "near",
    "robots": [ARM],
    "twist": np.zeros(6),
    "number": 0,
    "paths": ["none.png"],
    "pixels": np.ones((12, 2)),
    "rays": np.eye(3),
    "right": IMAGE,
    "right_pose": np.eye(4),
    "time": 1.0,
    "width": 320,
    "baseline": 0.06,
    "angles": np.zeros(3),
    "arm": ARM,
    "at_stem": np.ones(3),
    "bodies": [Body("a body", 1, Sphere((0, 0, 0), 0.01))],
    "centre": np.zeros(3),
    "crop": SCENE,
    "psi": 0.1,
    "cloud": Cloud(np.zeros((3, 3)), 0.1, [1, 1, 2]),
    "document": {"unit": "m"},
    "foot": np.zeros(3),
    "fruit_top": np.zeros(3),
    "half": np.ones(3),
    "length": 0.3,
    "normal": np.ones(3),
    "objects": [],
    "offset": 0.1,
    "pitch": np.ones(3),
    "plant": SCENE.objects,
    "point": np.zeros(3),
    "points": np.zeros((3, 3)),
    "radii": 0.1,
    "radius": 0.1,
    "scene": SCENE,
    "shape": Sphere((0, 0, 0), 0.01),
    "top": np.ones(3),
    "unit": "m",
    "vertices": np.eye(3),
    "axis_angle": np.zeros(3),
    "b": np.zeros(3),
    "beta": 1.0,
    "case": "fixed",
    "chunks": [POSES],
    "count": 3,
    "current": np.zeros(3),
    "frame": "base",
    "h_extra": 0.03,
    "here": StrawberryArm().reset_pose,
    "gain": ik.solvers.StaticGain(K=np.ones((7, 3))),
    "kind": ik.solvers.StaticGain,
    "max_joint_step": 0.1,
    "method": "transpose",
    "n": 1,
    "name": "a name",
    "link": "tool",
    "mass": 0.1,
    "masses": [PointMass(link="tool", mass=0.1)],
    "speed": 1.0,
    "torque": 1.0,
    "name_or_path": "ur5",
    "path_or_text": '<robot name="r"/>',
    "open": True,
    "port": "loop://",
    "pose": POSES[0],
    "poses": POSES,
    "position": np.zeros(3),
    "q": np.zeros(7),
    "robot": ARM,
    "rotation": np.eye(3),
    "rows": np.ones((3, 4)),
    "seed": 1,
    "solver": ik.solvers.DifferentialEvolution(generations=1, max_restarts=0),
    "source": "hydrolek-static-gain",
    "target": POSES[0],
    "targets": POSES,
    "theta": 0.1,
    "tool": np.eye(4),
    "base": np.eye(4),
    "tuning": Tuning(goals=10, evaluations=4, runs=1, refinement=0),
    "url": "loop://",
    "weights": (1, 1, 1, 0, 0, 0),
    "values": {},
    "start": np.zeros(7),
    "end": np.array([0.3, 0.2, 0.9]),
    "via": np.array([0.1, 0.2, 1.0]),
    "waypoints": np.zeros((2, 7)),
    "xyz": np.zeros(3),
}
# Pictures and cameras: words that mean something else elsewhere.
VISION: dict[str, Any] = {
    "LockstepCamera.scene": lambda time: random_scene("empty"),
    "PointingLoop.rig": TomatoRig("loop://"),
    "PointingLoop.run.camera": [],
    "StereoPair.camera": Camera.of_view(64, 48, 60),
    "agreement.found": [],
    "annotated.found": [],
    "detection_row.image": "a picture",
    "eye_to_hand.base": np.ones((6, 3)),
    "eye_to_hand.camera": np.ones((6, 3)),
    "long_fruit.mask": np.zeros((240, 320), bool),
    "looking_at.target": np.ones(3),
    "obstacles.masks": [np.zeros((240, 320), bool)],
    "photographs.boxes": "none.csv",
    "photographs.folder": "none",
    "render.scene": DrawnScene((Fruit((0, 0, 0.4), 0.03),)),
    "rendered.scene": random_scene("empty"),
    "triangulate.left": paper_camera(),
    "triangulate.right": paper_camera(),
}
# Those of one callable alone.
EXACTLY: dict[str, Any] = {
    **VISION,
    "StateSpace.A": np.zeros((3, 3)),
    "Link.command.kind": Type.STOP,
    "Link.request.kind": Type.PING,
    "StrawberryRig.check_ways.q": StrawberryArm().reset_pose,
    "StrawberryRig.way_back.q": StrawberryArm().reset_pose,
    "Tuning.solver": "state-space",
    "usual.solver": "state-space",
    "tune.robot": ik.Robot.load("hydrolek"),
    "Body.frame": 1,
    "aiming_at.target": "a name",
    **{
        f"{name}.robot": CUCUMBER
        for name in ("plan", "blockers", "sensitivity", "simulate", "approach_scan", "slide_table")
    },
    **{
        f"{name}.target": "a name"
        for name in ("sensitivity", "simulate", "approach_scan", "slide_table")
    },
    "row.pitch": np.ones(3),
    "stem.foot": np.zeros(3),
}


def bad_values() -> list[Any]:
    shapes = [(0,), (3,), (7,), (2, 3), (2, 7), (4, 4), (2, 4, 4), (0, 3), (0, 4, 4)]
    numbers = [np.nan, np.inf, -1.0, 1e300]
    return [
        None, True, -1, 0, 2**70, 10**400, 0.5, np.nan, -np.inf, 1e300, 5e-324, 1j, "", "x", "\0",
        "\ud800", b"x", [], [[1, 2], [3]], {}, {1}, object(), ik.Robot, lambda: 0,
        range(3), np.array(None), np.array(["a"]), np.zeros(3, dtype="M8[s]"), np.zeros(3, bool),
        np.zeros(3, complex), np.zeros((1,) * 40 + (3,)), [10**400] * 3,
        *(np.full(shape, x) for shape in shapes for x in numbers),
    ]  # fmt: skip


def values_for(argument: str) -> list[Any]:
    if argument in OBJECTS:
        return []
    if argument in TEXTS:
        return ["", "x", "\0", "<", "x" * 200]
    if argument in COUNTS:
        return [x for x in bad_values() if not (isinstance(x, int) and x > 10**6)]
    return bad_values()


def public_modules() -> Iterator[Any]:
    yield ik
    for found in pkgutil.walk_packages(ik.__path__, "agrik_fast."):
        private = any(part.startswith("_") for part in found.name.split("."))
        if not private and not found.name.startswith(ELSEWHERE):
            yield importlib.import_module(found.name)


def public_objects() -> list[tuple[str, Any]]:
    found = {}
    for module in public_modules():
        for name in module.__all__:
            thing = getattr(module, name)
            # Names of types are callable, too.
            if callable(thing) and typing.get_origin(thing) is None:
                found[id(thing)] = (f"{thing.__module__}.{thing.__qualname__}", thing)
    return sorted(found.values(), key=lambda pair: pair[0])


def methods(kind: type) -> Iterator[tuple[str, Callable[..., Any]]]:
    """The public methods of a class, bound."""
    for name in dir(kind):
        raw = inspect.getattr_static(kind, name)
        if name.startswith("_") or isinstance(raw, (property, type)):
            continue
        if isinstance(raw, (classmethod, staticmethod)):
            yield f"{kind.__qualname__}.{name}", getattr(kind, name)
        elif receivers().get(kind) is not None and callable(raw):
            yield f"{kind.__qualname__}.{name}", getattr(receivers()[kind], name)


def callables() -> dict[str, Callable[..., Any]]:
    found: dict[str, Callable[..., Any]] = {}
    for name, thing in [*public_objects(), ("TargetSolver", _native.TargetSolver)]:
        if not isinstance(thing, type):
            found[name] = thing
            continue
        if issubclass(thing, RECORDS) or thing.__name__ in ANSWERS:
            continue
        if thing.__module__ != "agrik_fast._native":
            found[name] = thing
        found |= dict(methods(thing))
    return found


CALLABLES = callables()


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """What is written to a file named "x" is written somewhere else."""
    monkeypatch.chdir(tmp_path)


def test_the_walk_finds_what_there_is():
    names = " ".join(CALLABLES)
    for one in (
        "Robot.ik", "Robot.from_dh", "TargetSolver.solve", "tasks.Masked", "rotations.",
        "StrawberryArm.solve", "TomatoArm.iterate", "set_num_threads", "tune",
    ):  # fmt: skip
        assert one in names, one


def test_the_walk_knows_an_object_of_every_class_with_methods():
    for name, thing in public_objects():
        if isinstance(thing, type) and not issubclass(thing, RECORDS):
            known = thing in receivers() or thing.__name__ in ANSWERS
            # All there is to settings is how they are made.
            assert known or dataclasses.is_dataclass(thing), f"{name}: wanted in `receivers`"


def taken(call: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    variable = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    parameters = inspect.signature(call).parameters.items()
    return {name: p for name, p in parameters if p.kind not in variable}


def example(name: str, argument: str) -> Any:
    for key in (f"{name}.{argument}", f"{name.rpartition('.')[2]}.{argument}"):
        if key in EXACTLY:
            return EXACTLY[key]
    assert argument in ARGUMENTS or argument in OBJECTS, (
        f"{name}({argument}=...): an example is wanted in `ARGUMENTS`"
    )
    return ARGUMENTS.get(argument)


def fault_of(call: Callable[..., Any], arguments: dict[str, Any]) -> str | None:
    """What a call raises that it should not."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer = call(**arguments)
            if inspect.isgenerator(answer):
                for _ in answer:
                    pass
    except AgrikError as error:
        return None if str(error) else "no words"
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:90]}"
    return None


@pytest.mark.parametrize("name", CALLABLES)
def test_bad_arguments_raise_what_is_documented(name):
    call = CALLABLES[name]
    parameters = taken(call)
    required = {
        k: example(name, k) for k, p in parameters.items() if p.default is inspect.Parameter.empty
    }
    faults = []
    for argument in parameters:
        for bad in values_for(argument):
            fault = fault_of(call, {**required, argument: bad})
            if fault is not None:
                kind = type(bad).__name__ + (str(bad.shape) if hasattr(bad, "shape") else "")
                faults.append(f"{argument}={kind}: {fault}")
    # The threads of other tests are not to be what a bad number made them.
    ik.set_num_threads(None)
    assert not faults, "\n".join([name, *faults])


@pytest.mark.parametrize("name", CALLABLES)
def test_an_unknown_argument_is_a_type_error(name):
    call = CALLABLES[name]
    if any(p.kind is p.VAR_KEYWORD for p in inspect.signature(call).parameters.values()):
        return
    with pytest.raises(TypeError, match="argument"):
        call(no_such_argument=1)
