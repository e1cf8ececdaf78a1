"""Bad input: each kind has its message, and bad rows leave the others unharmed."""

import numpy as np
import pytest

import agrik_fast as ik
from agrik_fast import _native, solvers, tasks
from agrik_fast.errors import ArgumentError, UnknownNameError, UrdfError


@pytest.fixture
def arm(load_robot):
    return load_robot("puma560")


@pytest.fixture
def pose(arm):
    return arm.fk(arm.random_q(seed=1))


@pytest.fixture(params=["Robot", "Chain"])
def call(request, arm):
    """Return `Robot.ik`, and the compiled method below it, which checks as well."""
    return arm.ik if request.param == "Robot" else arm._chain.ik


def message(error):
    return str(error.value)


# -- targets ----------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (4,), (4, 3, 4), (2, 2), (0,), (3, 1)])
def test_wrong_shape_of_targets(call, shape):
    with pytest.raises(ArgumentError) as error:
        call(np.zeros(shape))
    assert message(error) == (
        "`targets`: expected shape (..., 4, 4) for poses or (..., 3) for positions, "
        f"got shape {shape}"
    )
    assert error.value.argument == "targets"
    assert error.value.received == f"shape {shape}"


@pytest.mark.parametrize(
    ("targets", "received"),
    [
        ("abc", "an array of <U3"),
        ([1.0, None, 2.0], "an array of object"),
        ([True, False, True], "an array of bool"),
        ([1j, 0, 0], "an array of complex128"),
        ([[1.0, 2.0, 3.0], [1.0]], "rows of unequal length"),
    ],
)
def test_targets_that_are_no_numbers(call, targets, received):
    with pytest.raises(ArgumentError) as error:
        call(targets)
    assert message(error) == f"`targets`: expected an array of numbers, got {received}"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("kind", ["pose", "position"])
def test_rows_that_are_not_finite_leave_the_others_unharmed(arm, kind, value):
    targets = arm.fk(arm.random_q(600, seed=2))
    if kind == "position":
        targets = targets[:, :3, 3].copy()
    clean = arm.ik(targets)
    bad = np.zeros(600, dtype=bool)
    bad[[0, 17, 255, 256, 599]] = True
    targets[bad, 1] = value
    result = arm.ik(targets)
    assert (result.status[bad] == ik.Status.BAD_INPUT).all()
    assert not result.success[bad].any()
    assert np.isinf(result.position_error[bad]).all()
    assert np.isfinite(result.q).all()
    assert (result.q >= arm.lower).all()
    assert (result.q <= arm.upper).all()
    for field in ("q", "status", "position_error", "orientation_error", "iterations"):
        kept = getattr(result, field)[~bad]
        assert kept.tobytes() == getattr(clean, field)[~bad].tobytes()


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda m: m[:3, :3].__imul__(1.001), "|R^T R - 1| = 2.0e-3"),
        (lambda m: m[:3, 0].__imul__(-1), "a reflection, det R = -1"),
        (lambda m: m[3].__setitem__(2, 0.5), "last row [0.0, 0.0, 0.5, 1.0]"),
        (lambda m: m[3].__setitem__(3, 2.0), "last row [0.0, 0.0, 0.0, 2.0]"),
        (lambda m: m.__setitem__(..., 0.0), "last row [0.0, 0.0, 0.0, 0.0]"),
    ],
)
def test_poses_that_are_not_rigid(call, pose, change, fault):
    expected = "a rigid transform, [R t; 0 0 0 1] with R^T R = 1 and det R = 1"
    change(pose)
    with pytest.raises(ArgumentError) as error:
        call(pose, invalid="raise")
    assert message(error) == f"`targets`: expected {expected}, got {fault}"
    batch = np.tile(np.eye(4), (3, 5, 1, 1))
    batch[1, 2] = pose
    with pytest.raises(ArgumentError) as error:
        call(batch, invalid="raise")
    assert message(error) == f"`targets[1, 2]`: expected {expected}, got {fault}"
    with pytest.raises(ArgumentError) as error:
        call(batch.reshape(15, 4, 4), invalid="raise")
    assert error.value.argument == "targets[7]"


def test_poses_that_are_rigid_but_for_rounding(call, pose):
    assert call(pose.astype(np.float32)).success


def test_no_targets(call):
    assert call(np.empty((0, 4, 4))).q.shape == (0, 6)
    assert call(np.empty((0, 3))).status.shape == (0,)


# -- the other arguments ----------------------------------------------------------------


@pytest.mark.parametrize("name", ["position_tolerance", "orientation_tolerance"])
@pytest.mark.parametrize("value", [-1e-6, 0.0, np.nan, np.inf, "1", True])
def test_tolerances(call, pose, name, value):
    with pytest.raises(ArgumentError, match=rf"^`{name}`: expected a .*number") as error:
        call(pose, **{name: value})
    assert error.value.argument == name


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("seed", -1),
        ("seed", 2**64),
        ("seed", 1.5),
        ("seed", True),
        ("first_index", -1),
        ("threads", 0),
        ("threads", -2),
        ("threads", 1.0),
    ],
)
def test_whole_numbers(call, pose, name, value):
    with pytest.raises(ArgumentError, match=rf"^`{name}`: expected a whole number") as error:
        call(pose, **{name: value})
    assert error.value.received == repr(value)


def test_integers_of_numpy_are_whole_numbers(call, pose):
    call(pose, seed=np.uint64(2**64 - 1), threads=np.int8(1), first_index=np.int64(3))


@pytest.mark.parametrize("shape", [(), (5,), (1,), (4, 6), (2, 3, 6), (3, 1)])
def test_wrong_shape_of_q0(call, pose, shape):
    with pytest.raises(ArgumentError, match=r"^`q0`: expected shape \(6,\), or one that") as error:
        call(np.tile(pose, (2, 1, 1)), q0=np.zeros(shape))
    assert "broadcasts to (2, 6)" in message(error)
    assert error.value.received == f"shape {shape}"


def test_q0_that_is_not_finite_is_bad_input(arm):
    q = arm.random_q(3, seed=1)
    targets = arm.fk(q)
    q0 = q.copy()
    q0[1, 4] = np.nan
    result = arm.ik(targets, q0=q0)
    assert result.status.tolist() == [0, ik.Status.BAD_INPUT, 0]
    result = arm.ik(targets, q0=q0[1])
    assert (result.status == ik.Status.BAD_INPUT).all()


def test_unknown_solver(call, pose):
    with pytest.raises(UnknownNameError) as error:
        call(pose, solver="transpoze")
    assert message(error).startswith(
        "unknown solver 'transpoze'; did you mean 'transpose'? Known: lm, dls, pinv"
    )
    assert error.value.nearest == ("transpose",)
    with pytest.raises(ArgumentError, match=r"a solver of agrik_fast.solvers or one of lm, dls"):
        call(pose, solver=3)


def test_unknown_task(call, pose):
    with pytest.raises(UnknownNameError) as error:
        call(pose, task="positon")
    assert message(error) == (
        "unknown task 'positon'; did you mean 'position'? Known: position, pose, axis"
    )
    with pytest.raises(ArgumentError, match=r"a task of agrik_fast.tasks or one of position, pose"):
        call(pose, task=3)


def test_task_that_needs_more_than_points(call):
    with pytest.raises(ArgumentError, match=r"^`targets`: expected poses .*, got points"):
        call(np.zeros(3), task="pose")
    with pytest.raises(ArgumentError, match=r"^`direction`: expected a direction for the tool"):
        call(np.zeros((2, 3)), task=tasks.Axis())


def test_wrong_tool(call, pose):
    with pytest.raises(
        ArgumentError, match=r"^`tool`: expected shape \(4, 4\).*, got shape \(5,\)"
    ):
        call(pose, tool=np.zeros(5))
    with pytest.raises(ArgumentError, match=r"^`tool`: expected a rigid transform.*got last row"):
        call(pose, tool=np.zeros((4, 4)))
    with pytest.raises(ArgumentError, match=r"^`tool`: expected a rigid transform.*, got NaN"):
        call(pose, tool=np.full((4, 4), np.nan))


@pytest.mark.parametrize(
    ("cls", "field", "value"),
    [
        (solvers.LevenbergMarquardt, "damping", 0.0),
        (solvers.DampedLeastSquares, "damping", np.inf),
        (solvers.PseudoInverse, "cutoff", 1.0),
        (solvers.Transpose, "max_iterations", 0),
        (solvers.Transpose, "max_restarts", -1),
        (solvers.LevenbergMarquardt, "max_restarts", 2**32),
        (solvers.LevenbergMarquardt, "max_step", 0.0),
    ],
)
def test_options_of_solvers(arm, pose, cls, field, value):
    with pytest.raises(ArgumentError, match=rf"^`{cls.__name__}\.{field}`"):
        cls(**{field: value})

    class Forged:
        """Passes by the checks of the dataclass."""

    forged = Forged()
    forged.name = cls.name
    for name, default in _native.default_settings()[cls.name].items():
        setattr(forged, name, default)
    setattr(forged, field, value)
    with pytest.raises(ArgumentError, match=rf"^`{field}`"):
        arm._chain.ik(pose, solver=forged)


@pytest.mark.parametrize("value", [0, -1, 1.5, True, "2"])
def test_number_of_threads(value):
    with pytest.raises(ArgumentError, match=r"^`n`: expected a whole number"):
        ik.set_num_threads(value)


# -- joint values -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["fk", "fk_links", "jacobian"])
def test_wrong_joint_values(arm, name):
    for function in (getattr(arm, name), getattr(arm._chain, name)):
        with pytest.raises(ArgumentError) as error:
            function(np.zeros((2, 5)))
        assert message(error) == "`q`: expected shape (..., 6), got shape (2, 5)"
        with pytest.raises(ArgumentError, match=r"^`q`: expected shape .*, got shape \(\)"):
            function(0.0)
        with pytest.raises(ArgumentError, match=r"^`q`: expected an array of numbers, got"):
            function(["a"] * 6)
        assert function(np.empty((0, 6))).shape[0] == 0
        assert np.isnan(function(np.full((2, 6), np.nan))).any()


# -- robots -----------------------------------------------------------------------------


def joint(**changes):
    spec = {
        "name": "a",
        "type": "revolute",
        "origin": np.eye(4),
        "axis": np.array([0.0, 0.0, 1.0]),
        "lower": -1.0,
        "upper": 1.0,
        "mimic": None,
    }
    return {**spec, **changes}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"lower": 2.0}, "`joint 'a' limits`: expected lower <= upper, got lower 2 > upper 1"),
        ({"lower": np.nan}, "`joint 'a' limits`: expected numbers"),
        ({"axis": np.zeros(3)}, '`joints[0]["axis"]`: expected a finite direction of non-zero'),
        ({"axis": np.full(3, np.nan)}, '`joints[0]["axis"]`: expected a finite direction'),
        ({"axis": np.zeros(2)}, '`joints[0]["axis"]`: expected shape (3,), got shape (2,)'),
        ({"origin": np.zeros((4, 4))}, '`joints[0]["origin"]`: expected a rigid transform'),
        ({"type": "revolut"}, "unknown joint type 'revolut'; did you mean 'revolute'?"),
        ({"name": 3}, '`joints[0]["name"]`: expected a string, got 3'),
        ({"mimic": ("b", 1.0, 0.0)}, "`joint 'a' mimic`: expected a known joint, got b"),
        ({"mimic": "b"}, '`joints[0]["mimic"]`: expected None or (joint, multiplier, offset)'),
        ({"type": "fixed"}, "`joints`: expected at least one movable joint, got none"),
    ],
)
def test_joints(change, text):
    with pytest.raises(ArgumentError) as error:
        _native.Chain.from_joints("robot", [joint(**change)])
    assert text in message(error)


def test_joints_with_something_missing_or_double():
    incomplete = joint()
    del incomplete["lower"]
    with pytest.raises(
        ArgumentError, match=r'`joints\[0\]\["lower"\]`: expected a value, got noth'
    ):
        _native.Chain.from_joints("robot", [incomplete])
    with pytest.raises(ArgumentError, match="expected a unique name"):
        _native.Chain.from_joints("robot", [joint(), joint()])
    with pytest.raises(ArgumentError, match="expected at least one movable joint, got none"):
        _native.Chain.from_joints("robot", [])
    with pytest.raises(ArgumentError, match="`variable_order`: expected each of a once, got a, b"):
        _native.Chain.from_joints("robot", [joint()], variable_order=["a", "b"])


def from_dh(**changes):
    arguments = {
        "name": "robot",
        "convention": "standard",
        "rows": np.zeros((2, 4)),
        "joint_types": ["revolute", "fixed"],
        "joint_names": ["a", "b"],
        "lower": np.zeros(2),
        "upper": np.ones(2),
    }
    return _native.Chain.from_dh(**{**arguments, **changes})


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"convention": "modifid"}, "unknown convention 'modifid'; did you mean 'modified'?"),
        ({"rows": np.zeros((2, 3))}, "`rows`: expected shape (n, 4), columns a, alpha, d, theta"),
        ({"rows": np.full((2, 4), np.nan)}, "expected finite numbers, got NaN or infinity"),
        ({"joint_types": ["revolute"]}, "`joint_types`: expected 2, one a row, got 1 names"),
        ({"joint_names": ["a"] * 3}, "`joint_names`: expected 2, one a row, got 3 names"),
        ({"lower": np.zeros(3)}, "`lower`: expected shape (2,), got shape (3,)"),
        ({"upper": np.full(2, -1.0)}, "expected lower <= upper, got lower 0 > upper -1"),
        ({"joint_types": ["fixed", "fixed"]}, "expected at least one movable joint, got none"),
        ({"base": np.ones((4, 4))}, "`base`: expected a rigid transform"),
        ({"tool": np.ones((4, 3))}, "`tool`: expected shape (4, 4), got shape (4, 3)"),
    ],
)
def test_rows(change, text):
    assert from_dh().dof == 1
    with pytest.raises(ArgumentError) as error:
        from_dh(**change)
    assert text in message(error)


def urdf(*joints):
    links = sorted({link for pair in joints for link in pair})
    parts = [f'<link name="{link}"/>' for link in links]
    parts += [
        f'<joint name="{a}{b}" type="continuous"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in joints
    ]
    return f'<robot name="r">{"".join(parts)}</robot>'


@pytest.mark.parametrize(
    ("text", "links", "named"),
    [
        (urdf(("a", "b"), ("b", "c"), ("c", "a")), (), "a"),
        (urdf(("a", "b"), ("c", "d")), (), "c"),
        (urdf(("a", "b"), ("a", "c")), (), "c"),
        (urdf(("a", "b")), ("x", None), "x"),
        (urdf(("a", "b")), (None, "y"), "y"),
        ("<robot", (), ""),
        ("no xml", (), ""),
        ("", (), ""),
    ],
    ids=["cyclic", "disconnected", "two tips", "base", "tip", "cut off", "text", "empty"],
)
def test_urdf(text, links, named):
    assert _native.Chain.from_urdf(urdf(("a", "b")))[0].dof == 1
    with pytest.raises(UrdfError) as error:
        _native.Chain.from_urdf(text, *links)
    assert named in message(error)
    assert len(message(error)) > 10
