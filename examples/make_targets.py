"""Make the target files in examples/targets from the papers' numbers and fixed seeds.

Run it again and the same files appear: joint values come from SplitMix64 streams, which do not
depend on a NumPy version, and coordinates are rounded to a nanometre (CSV) or to single
precision (arrays), far above the last digit of a forward kinematics.
"""

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from agrik_fast import Robot, rotations

Array = NDArray[np.float64]

TARGETS = Path(__file__).parent / "targets"
WORKSPACE_ROWS = 1_000
POSE_ROWS = 10_000

# Table 3 of the strawberry paper: x and y in mm. The sphere they lie on gives z: the table
# prints it to 0.1 mm only, and three of its entries are off by more than that rounding.
STRAWBERRY_XY_MM = (
    (426, 345), (450, 285), (489, 270), (445, 325), (410, 350),
    (520, 350), (568, 310), (520, 280), (580, 310), (525, 280),
    (535, 450), (510, 450), (565, 420), (536, 460), (580, 427),
    (450, 400), (410, 410), (475, 390), (435, 440), (482, 465),
)  # fmt: skip
SPHERE_CENTRE_MM = (500.0, 367.5, -395.0)
SPHERE_RADIUS_MM = 100.0

# Where fruits hang in front of the cucumber arm, in its world frame (X to the crop, Z up).
CROP_X_M = (0.35, 0.90)
CROP_Z_M = (0.50, 1.70)


def splitmix64(seed: int) -> Iterator[float]:
    """Yield the uniform numbers in [0, 1) of the hydrolek test sets."""
    mask = (1 << 64) - 1
    state = seed & mask
    while True:
        state = (state + 0x9E3779B97F4A7C15) & mask
        word = state
        word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & mask
        word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & mask
        word ^= word >> 31
        yield (word >> 11) * 2.0**-53


def joint_uniform(lower: Array, upper: Array, count: int, seed: int) -> Array:
    """Return joint vectors uniform within the limits, drawn row by row, joint by joint."""
    stream = splitmix64(seed)
    unit = np.array([next(stream) for _ in range(count * len(lower))])
    return np.asarray(lower + (upper - lower) * unit.reshape(count, len(lower)))


def strawberry_points_mm() -> Array:
    """Return the 20 targets of table 3, shape (20, 3), mm."""
    centre = SPHERE_CENTRE_MM
    return np.array(
        [
            (x, y, centre[2] + math.sqrt(SPHERE_RADIUS_MM**2 - math.dist((x, y), centre[:2]) ** 2))
            for x, y in STRAWBERRY_XY_MM
        ]
    )


def workspace_points(robot: Robot, seed: int) -> Array:
    """Return tool points of joint-uniform postures, shape (1000, 3), m."""
    q = joint_uniform(robot.lower, robot.upper, WORKSPACE_ROWS, seed)
    return np.asarray(robot.fk(q)[:, :3, 3])


def grip_postures(robot: Robot, seed: int) -> Array:
    """Return cucumber postures with the tool x axis straight down, shape (1000, 7), m and rad.

    The slide and the first four angles are uniform within their limits; the last two follow
    from the axis in closed form, so every target is reachable by construction. Kept are those
    within the limits whose gripper faces the crop (tool z has a part along X) and whose
    point lies in the crop's region.
    """
    down = np.array([0.0, 0.0, -1.0])
    kept: list[Array] = []
    batch = 0
    while sum(map(len, kept)) < WORKSPACE_ROWS:
        q = joint_uniform(robot.lower, robot.upper, 20 * WORKSPACE_ROWS, seed + batch)
        batch += 1
        q[:, 5:] = 0.0
        # The twists of the last two joints cancel: at zero angles the tool is frame 5, in
        # which the tool x axis is (cos 6 cos 7, sin 7, sin 6 cos 7).
        axis = np.einsum("nji,j->ni", robot.fk(q)[:, :3, :3], down)
        q[:, 6] = math.pi - np.arcsin(np.clip(axis[:, 1], -1.0, 1.0))
        q[:, 5] = np.arctan2(-axis[:, 2], -axis[:, 0])
        pose = robot.fk(q)
        inside = ((q >= robot.lower) & (q <= robot.upper)).all(axis=1)
        inside &= np.abs(pose[:, :3, 0] - down).max(axis=1) < 1e-12
        inside &= pose[:, 0, 2] > 0.0
        for column, (low, high) in ((0, CROP_X_M), (2, CROP_Z_M)):
            inside &= (pose[:, column, 3] >= low) & (pose[:, column, 3] <= high)
        kept.append(q[inside])
    return np.concatenate(kept)[:WORKSPACE_ROWS]


def random_poses(robot: Robot, seed: int) -> dict[str, NDArray[np.float32]]:
    """Return 10,000 poses of joint-uniform postures as position_m and quaternion_xyzw."""
    pose = robot.fk(joint_uniform(robot.lower, robot.upper, POSE_ROWS, seed))
    return {
        "position_m": pose[:, :3, 3].astype(np.float32),
        "quaternion_xyzw": rotations.quat_of(pose).astype(np.float32),
    }


def write_csv(path: Path, comment: str, columns: Sequence[str], rows: Sequence[Sequence[str]]):
    """Write a table of texts with row ids from 1 below a comment and a header."""
    lines = [f"# {comment}", ",".join(["id", *columns])]
    lines += [",".join([str(k), *row]) for k, row in enumerate(rows, start=1)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def write_points(path: Path, comment: str, unit: str, points: Array, digits: int) -> None:
    """Write points with so many digits after the point."""
    rows = [[f"{value:.{digits}f}" for value in point] for point in points]
    write_csv(path, comment, [f"{axis}_{unit}" for axis in "xyz"], rows)


def main(folder: Path = TARGETS) -> None:
    """Write every target file into a folder."""
    import pyarrow
    from pyarrow import parquet

    folder.mkdir(parents=True, exist_ok=True)
    write_points(
        folder / "strawberry_table3.csv",
        "strawberry: x and y of the paper's table 3; z on the sphere with centre "
        "(500; 367.5; -395) mm and radius 100 mm",
        "mm",
        strawberry_points_mm(),
        6,
    )
    write_csv(
        folder / "redundant7_pose.csv",
        "redundant7: the paper's target pose; ZYZ angles pi/2, pi/4, pi/6 in degrees",
        ["x_mm", "y_mm", "z_mm", "zyz_alpha_deg", "zyz_beta_deg", "zyz_gamma_deg"],
        [["334", "471", "539", "90", "45", "30"]],
    )
    write_points(
        folder / "hydrolek_workspace.csv",
        "hydrolek: tool points of joint-uniform postures (SplitMix64; seed 1); D-H base frame",
        "m",
        workspace_points(Robot.load("hydrolek"), seed=1),
        9,
    )
    np.save(folder / "tomato_points.npy", workspace_points(Robot.load("tomato"), seed=2))
    cucumber = Robot.load("cucumber")
    write_points(
        folder / "cucumber_grips.csv",
        "cucumber: grip points of postures with tool x straight down in the crop's region "
        "(SplitMix64; seed 3); world frame",
        "m",
        np.asarray(cucumber.fk(grip_postures(cucumber, seed=3))[:, :3, 3]),
        9,
    )
    np.savez_compressed(folder / "puma560_poses.npz", **random_poses(Robot.load("puma560"), 4))
    np.savez_compressed(folder / "panda_poses.npz", **random_poses(Robot.load("panda"), 6))
    poses = random_poses(Robot.load("ur5"), 5)
    names = ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"]
    values = np.concatenate([poses["position_m"], poses["quaternion_xyzw"]], axis=1)
    parquet.write_table(
        pyarrow.table({name: values[:, k].copy() for k, name in enumerate(names)}),
        folder / "ur5_poses.parquet",
        compression="zstd",
        use_dictionary=False,
    )


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
