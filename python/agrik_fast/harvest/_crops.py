"""Many crops, a row each: which share of their fruits can be picked, as a job for clusters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np

from .._checks import truth_value
from .._files import Refusal, listing
from .._native import __version__
from ..collision import Scene, greenhouse
from ..errors import AgrikError, ArgumentError
from ..io import check_number_columns, import_pyarrow, number_columns
from ..jobs import Done, JobError
from ..robot import Robot
from ._decisions import Status
from ._evaluate import evaluate
from ._plan import checked_settings
from ._settings import Distance, Settings, checked_distance

__all__ = ["CropsJob"]

SCENE = "scene"
_COUNTS = ("seed", "plants", "leaves", "points", "fruits")
_LENGTHS = ("radius", "y0", "y1", "stem_x")
_BAND = ("clear_from_m", "clear_to_m")
# Leaves that are named in a row, the worst first.
_WORST = 5


def _refuse(reason: str) -> JobError:
    return JobError("partition", reason)


@dataclass(frozen=True)
class CropsJob:
    """Harvest evaluations of crops, a row each.

    The columns read are ``scene``, the path of a scene file, or arguments of
    `agrik_fast.collision.greenhouse`: ``seed``, ``plants``, ``leaves``, ``points``, ``fruits``,
    ``radius_m``, ``y0_m``, ``y1_m``, ``stem_x_m``, and ``clear_from_m`` with ``clear_to_m``. Those
    written are ``id``, ``fruits``, ``share_ok``, how many fruits ended with each
    `agrik_fast.harvest.Status`, ``in_the_way`` (the leaves that block most, with how many fruits)
    and ``error``, which says why a crop could not be evaluated. Scene files must be there for all
    workers and stay as they are: results are known by their names.

    Parameters
    ----------
    robot : Robot, str or path, default "cucumber"
        An arm with bodies on a slide.
    settings : Settings, optional
        As for `agrik_fast.harvest.evaluate`.
    distance : {"exact", "tree"}, default "exact"
        Between bodies and crop.
    blockers : bool, default True
        Name the leaves in the way.

    Raises
    ------
    ArgumentError
        A wrong setting; one with a time limit, on which results would depend.

    Examples
    --------
    >>> from agrik_fast.harvest import CropsJob
    >>> from agrik_fast.jobs import Job
    >>> job: Job = CropsJob(blockers=False)
    >>> job.name, job.success
    ('harvest', 'evaluated')
    """

    robot: Robot | str | PathLike[str] = "cucumber"
    settings: Settings | None = None
    distance: Distance | str = "exact"
    blockers: bool = True

    name: str = field(default="harvest", init=False)
    success: str = field(default="evaluated", init=False)

    def __post_init__(self) -> None:
        truth_value("blockers", self.blockers)
        checked_distance(self.distance)
        settings = checked_settings(self.settings)
        if settings.time_limit is not None:
            received = f"a time limit of {settings.time_limit} s"
            raise ArgumentError("settings", received, "none: results would depend on it")
        robot = self.robot if isinstance(self.robot, Robot) else Robot.load(self.robot)
        object.__setattr__(self, "settings", settings)
        object.__setattr__(self, "robot", robot)

    @property
    def _robot(self) -> Robot:
        return cast("Robot", self.robot)

    def identity(self) -> Mapping[str, Any]:
        """Return all that decides the results."""
        return {
            "robot": f"{self._robot.name} {self._robot.fingerprint}",
            "bodies": [repr(body) for body in self._robot.bodies],
            "settings": asdict(cast("Settings", self.settings)),
            "distance": self.distance,
            "blockers": self.blockers,
        }

    def columns(self, schema: Any, refuse: Refusal) -> tuple[str, ...]:
        """Return the columns that say what the crops are, and that of the id."""
        pyarrow = import_pyarrow(refuse)
        names = list(schema.names)
        lengths = [f"{name}_m" for name in _LENGTHS]
        used = [name for name in names if name in (*_COUNTS, *lengths, *_BAND)]
        if SCENE in names:
            if used:
                raise refuse(f"columns 'scene' and '{used[0]}', expected one way to say the crop")
            kind = schema.field(SCENE).type
            if not (pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind)):
                raise refuse(f"column 'scene' holds {kind}, expected paths")
            used = [SCENE]
        elif not used:
            expected = listing([SCENE, *_COUNTS, *lengths, *_BAND])
            found = listing(names) or "nothing"
            raise refuse(
                f"no column that says what the crops are; expected {expected}; found {found}"
            )
        else:
            check_number_columns(schema, tuple(used), refuse)
            if len(set(_BAND) & set(used)) == 1:
                raise refuse("one of 'clear_from_m' and 'clear_to_m', expected both or none")
        # What the arm lacks is said before a thousand machines begin.
        self._evaluated(greenhouse(plants=1, leaves=1))
        whole = "id" in names and pyarrow.types.is_integer(schema.field("id").type)
        return (*used, *(["id"] if whole else []))

    def schema(self, source: Any) -> Any:
        """Return the schema of results."""
        pyarrow = import_pyarrow(_refuse)
        fields = [("id", pyarrow.int64()), ("fruits", pyarrow.int32())]
        fields += [("share_ok", pyarrow.float64())]
        fields += [(status.name.lower(), pyarrow.int32()) for status in Status]
        fields += [("in_the_way", pyarrow.string()), ("error", pyarrow.string())]
        words = {"agrik_fast.version": __version__, "agrik_fast.robot": self._robot.name}
        return pyarrow.schema(fields, metadata=words)

    def work(self, batch: Any, first: int) -> Done:
        """Evaluate the crops of rows."""
        pyarrow = import_pyarrow(_refuse)
        rows = [self._row(crop) for crop in _crops(first, batch)]
        if "id" in batch.schema.names:
            ids = batch.column(batch.schema.get_field_index("id")).to_pylist()
        else:
            ids = range(first + 1, first + batch.num_rows + 1)
        records = [{"id": number, **row} for number, row in zip(ids, rows, strict=True)]
        table = pyarrow.Table.from_pylist(records, schema=self.schema(batch.schema))
        failed = sum(bool(row["error"]) for row in rows)
        counts = {"evaluated": len(rows) - failed, "bad_crop": failed}
        return Done(table, {name: count for name, count in counts.items() if count})

    def _row(self, crop: str | dict[str, Any]) -> dict[str, Any]:
        none = dict.fromkeys((status.name.lower() for status in Status), 0)
        try:
            scene = Scene.load(Path(crop)) if isinstance(crop, str) else greenhouse(**crop)
            found = self._evaluated(scene)
        except (AgrikError, OSError) as error:
            words = " ".join(str(error).split())
            return {"fruits": 0, "share_ok": 0.0, **none, "in_the_way": "", "error": words}
        codes = np.bincount(found.decisions.columns["status"], minlength=len(Status))
        return {
            "fruits": len(found.decisions),
            "share_ok": found.share,
            **{status.name.lower(): int(codes[status]) for status in Status},
            "in_the_way": ", ".join(f"{name} ({n})" for name, n in found.leaves()[:_WORST]),
            "error": "",
        }

    def _evaluated(self, scene: Scene) -> Any:
        return evaluate(
            scene,
            self._robot,
            settings=self.settings,
            distance=cast("Distance", self.distance),
            blockers=self.blockers,
        )


def _crops(first: int, batch: Any) -> list[str | dict[str, Any]]:
    """Return what each row says of its crop."""
    if SCENE in batch.schema.names:
        paths = batch.column(batch.schema.get_field_index(SCENE)).to_pylist()
        return ["" if path is None else path for path in paths]
    names = tuple(name for name in batch.schema.names if name != "id")
    crops: list[str | dict[str, Any]] = []
    for row in number_columns(first, batch, names, _refuse).tolist():
        said = dict(zip(names, row, strict=True))
        crop: dict[str, Any] = {
            # A formula has no whole numbers; what is none is refused by the greenhouse.
            name: int(said[name]) if said[name].is_integer() else said[name]
            for name in _COUNTS
            if name in said
        }
        crop |= {name: said[f"{name}_m"] for name in _LENGTHS if f"{name}_m" in said}
        if _BAND[0] in said:
            crop["clear_band"] = (said[_BAND[0]], said[_BAND[1]])
        crops.append(crop)
    return crops
