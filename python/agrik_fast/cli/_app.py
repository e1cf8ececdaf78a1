"""Commands, options and exit codes of ``agrik-fast``.

Only typer is imported here: ``--help`` must stay fast, so NumPy, the compiled module and rich
load inside the command that needs them.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ..papers import PAPERS
from . import _harvest_options, _options
from ._cluster_app import app as cluster_app
from ._exits import NOT_ALL_SOLVED, exit_codes, run, say, telling
from ._usage import OneLineGroup, refuses

app = typer.Typer(
    name="agrik-fast",
    cls=OneLineGroup,
    help="Fast, verified inverse kinematics for serial robot arms.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.add_typer(cluster_app, name="cluster")


def main() -> None:
    """Run the command line and exit with its status.

    Examples
    --------
    >>> import subprocess, sys
    >>> command = [sys.executable, "-m", "agrik_fast.cli", "robots"]
    >>> "ur5" in subprocess.run(command, capture_output=True, text=True).stdout
    True
    """
    run(lambda: app(prog_name="agrik-fast"))


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        with telling():
            typer.echo(f"agrik-fast {version('agrik_fast')}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    del version


class _SolveCommand(TyperCommand):
    """`solve`, whose help names the solvers that the core knows when it is asked for."""

    def get_help(self, ctx: Any) -> str:
        """Return the help."""
        from .._names import solver_names

        (option,) = (each for each in self.params if each.name == "solver")
        *first, last = solver_names()
        vars(option)["help"] = f"{', '.join(first)} or {last}; or a gain file (.toml, .json)."
        return super().get_help(ctx)


@app.command(cls=_SolveCommand)
def solve(
    robot: _options.Robot,
    targets: Annotated[Path, typer.Argument(help="Targets: .csv, .npy, .npz or .parquet.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Results: .csv, .npy, .npz or .parquet.")
    ],
    task: Annotated[
        str | None,
        typer.Option(
            help="position, pose, axis, masked or position-first; by default masked with --mask, "
            "else pose if there are orientations."
        ),
    ] = None,
    solver: Annotated[
        str | None,
        typer.Option(  # its help is in _SolveCommand
            help="Name of the solver.", show_default="lm", autocompletion=_options.solver_names
        ),
    ] = None,
    tol: Annotated[
        str,
        typer.Option(
            help="Position tolerance in metres; or three, along x, y, z, such as 1e-3,1e-3,inf, "
            "where inf leaves an axis free."
        ),
    ] = "1e-6",
    tol_rad: Annotated[
        str,
        typer.Option(help="Orientation tolerance in radians; or three, about x, y, z."),
    ] = "1e-6",
    tol_frame: Annotated[
        str | None,
        typer.Option(help="Whose axes three tolerances are for: base or tool; by default base."),
    ] = None,
    tool_axis: Annotated[
        str, typer.Option(help="Axis task: tool axis, such as z, -x or 0,0.6,0.8.")
    ] = "z",
    direction: Annotated[
        str | None,
        typer.Option(
            help="Axis task: where the tool axis points in the base frame, such as -z or 0,0,-1; "
            "by default along the targets' own tool axis."
        ),
    ] = None,
    mask: Annotated[
        str | None,
        typer.Option(
            help="Weights of the errors along x,y,z and about x,y,z, 0 where it is free, such as "
            "1,1,1,0,0,1."
        ),
    ] = None,
    mask_frame: Annotated[
        str, typer.Option(help="Frame in which --mask counts: base or tool.")
    ] = "base",
    q0: Annotated[
        str | None,
        typer.Option("--q0", help="Start values in radians and metres, such as 0,-1.57,0."),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the restarts.")] = 0,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads; by default all cores.")
    ] = None,
    scene: Annotated[
        Path | None,
        typer.Option(help="Scene that answers must not hit: a .json or .toml scene file."),
    ] = None,
    clear: Annotated[
        float, typer.Option(help="Scene: distance in metres that answers keep from it.")
    ] = 0.0,
    prefer: Annotated[
        str, typer.Option(help="Scene: which of several free postures: first, near or clearance.")
    ] = "first",
    aim: Annotated[
        str | None,
        typer.Option(help="Scene: name of the target in it that the gripper may touch."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing result.")] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 3 unless every row is solved.")
    ] = False,
    all_branches: Annotated[
        bool,
        typer.Option(
            "--all-branches",
            help="Write a row for each branch of a target within the limits; no solver then.",
        ),
    ] = False,
) -> None:
    """Solve every target of a file and write the joint values to another.

    Lengths are metres and angles radians unless a column says otherwise (x_mm, roll_deg).
    Exit status: 0 every row was processed, 2 bad arguments or files, 3 some rows are not
    solved (with --strict), 4 out of memory, 5 done but standard output is full, 129 hung up,
    130 interrupted, 143 terminated. The result appears only when it is complete.
    """
    with exit_codes() as kept:
        from ..jobs import SolveRequest
        from ._solve import (
            AXES,
            load_scene,
            other_faults,
            parse_axis,
            parse_frame,
            parse_preference,
            parse_solver,
            parse_tolerance,
            solve_words,
            unused,
        )
        from .progress import for_stream
        from .summary import print_summaries

        faults = _options.Faults()
        request = SolveRequest(
            robot=robot,
            targets=targets,
            output=output,
            task=task,
            solver=faults.of("--solver", solver, parse_solver) or "lm",
            position_tolerance=faults.of("--tol", tol, parse_tolerance) or 1e-6,
            orientation_tolerance=faults.of("--tol-rad", tol_rad, parse_tolerance) or 1e-6,
            tolerance_frame=faults.of("--tol-frame", tol_frame, parse_frame),
            tool_axis=faults.of("--tool-axis", tool_axis, parse_axis) or AXES["z"],
            direction=faults.of("--direction", direction, parse_axis),
            seed=seed,
            threads=threads,
            force=force,
            base_link=base_link,
            tip_link=tip_link,
            tool=faults.of("--tool", tool, _options.tool_numbers),
            frame=frame,
            q0=faults.of("--q0", q0, _options.values),
            mask=faults.of("--mask", mask, _options.weights),
            mask_frame=faults.of("--mask-frame", mask_frame, parse_frame) or "base",
            scene=faults.of("--scene", "", lambda option, text: load_scene(scene, aim)),
            scene_name="" if scene is None else scene.name,
            clear=clear,
            prefer=faults.of("--prefer", prefer, parse_preference) or "first",
            all_branches=all_branches,
        )
        faults.tell(lambda: other_faults(request))
        for line in unused(solver=solver, seed=seed, all_branches=all_branches):
            say(f"agrik-fast: {line}")
        summary = solve_words(request, for_stream(sys.stderr))
        kept.what = lambda: f"results: {output}"
        with telling(f"results: {output}"):
            print_summaries([summary], sys.stdout)
            typer.echo(f"results: {output}")
    if strict and summary.solved < summary.rows:
        raise typer.Exit(NOT_ALL_SOLVED)


@app.command()
@refuses(mask=_options.NO_SOLVING, solver=_options.NO_SOLVING)
def info(
    robot: Annotated[
        str | None,
        typer.Argument(
            help="A robot's name or file, as for `solve`; all names if none.",
            autocompletion=_options.robot_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    q0: Annotated[
        str | None,
        typer.Option(
            "--q0", help="Print the tool's pose at these joint values, in radians and metres."
        ),
    ] = None,
    body: Annotated[
        bool, typer.Option("--body", help="Print its bodies for collisions instead.")
    ] = False,
    self_pairs: Annotated[
        bool,
        typer.Option(
            "--self-pairs",
            help="Print which bodies may hit each other, and why others are left out.",
        ),
    ] = False,
) -> None:
    """Print a robot's joints, limits, reach, DH rows and source."""
    with exit_codes():
        from ..jobs import RobotChoice
        from ._info import about_collisions, describe, list_robots, no_robot

        asked = [base_link, tip_link, tool, frame, q0, body or None, self_pairs or None]
        if robot is None and any(each is not None for each in asked):
            raise no_robot()
        if robot is None:
            text = list_robots()
        else:
            arm = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame).load()
            if body or self_pairs:
                text = about_collisions(arm, body=body, self_pairs=self_pairs)
            else:
                text = describe(arm, None if q0 is None else _options.values("--q0", q0))
        with telling():
            typer.echo(text)


@app.command()
def robots() -> None:
    """Print the robots that can be loaded by name, with a line on each."""
    with exit_codes():
        from ._info import list_robots

        with telling():
            typer.echo(list_robots())


@app.command()
def solvers() -> None:
    """Print the solvers, with a line on each."""
    with exit_codes():
        from ._info import list_solvers

        with telling():
            typer.echo(list_solvers())


@app.command()
@refuses(
    q0="a robot file holds no start; its home posture is in the keys home_deg, home_m, ...",
    mask=_options.NO_SOLVING,
    solver=_options.NO_SOLVING,
)
def convert(
    robot: _options.Robot,
    output: Annotated[Path, typer.Argument(help="The robot file to write: .toml.")],
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write a robot, such as one from a URDF, to a robot file."""
    with exit_codes():
        from ..jobs import RobotChoice

        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        arm = choice.load()
        for note in arm.notes:
            say(f"{arm.name}: {note}")
        arm.save(output, force=force)
        with telling(f"robot: {output}"):
            typer.echo(f"robot: {output}")


@app.command()
def schema(
    kind: Annotated[str, typer.Argument(help="robot, gains, scene or calibration.")],
) -> None:
    """Print the JSON Schema of a kind of file, for editors."""
    with exit_codes():
        from ._schema import json_schema

        text = json_schema(kind)
        with telling():
            typer.echo(text)


@app.command()
@refuses(
    q0="attempts start at --start zero or middle",
    mask="gains are for whole positions or poses, --task position or pose",
)
def tune(
    robot: _options.Robot,
    output: Annotated[Path, typer.Option("--output", "-o", help="Gain file: .toml or .json.")],
    solver: Annotated[
        str, typer.Option(help="state-space, static-gain or ik-pid.")
    ] = "state-space",
    shape: Annotated[
        str, typer.Option(help="State space: input (B alone), diagonal (of A, and B) or full.")
    ] = "input",
    method: Annotated[
        str | None,
        typer.Option(help="pso (particle swarm, the default) or cma (CMA-ES, that of ik-pid)."),
    ] = None,
    start: Annotated[str, typer.Option(help="Where attempts start: zero or middle.")] = "zero",
    task: Annotated[
        str, typer.Option(help="What the gains are for: position or pose.")
    ] = "position",
    goals: Annotated[
        int | None, typer.Option(min=1, help="Training goals: 3000, or 600 for ik-pid.")
    ] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(min=1, help="Gain sets to judge in a search: 4840, or 400 for ik-pid."),
    ] = None,
    runs: Annotated[int, typer.Option(min=1, help="Searches, of which the best is kept.")] = 3,
    refinement: Annotated[
        int | None,
        typer.Option(min=0, help="Gain sets to judge in the refinement, 0 for none: 2400, or 200."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search and its goals.")] = 0,
    tol: Annotated[float, typer.Option(help="Position tolerance in metres.")] = 1e-3,
    tol_rad: Annotated[
        float, typer.Option(help="Orientation tolerance in radians, for poses.")
    ] = 1e-2,
    rotation_length: Annotated[
        float | None,
        typer.Option(
            help="Poses: metres that a radian of error counts as; 0.3 of the reach if not given."
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads; by default all cores.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on from the checkpoint of a run that was killed.")
    ] = False,
) -> None:
    """Find the gains of a feedback solver and write them with how well they do.

    A checkpoint beside the output keeps the search, every few seconds, until the gains are
    written.
    """
    with exit_codes() as kept:
        from ..jobs import RobotChoice
        from ..tuning import Tuning
        from ._tune import comparison, tune_to_file, what_is_kept

        given = {
            "method": method,
            "goals": goals,
            "evaluations": evaluations,
            "refinement": refinement,
        }
        tuning = Tuning.usual(
            solver,
            shape=shape,
            start=start,
            runs=runs,
            seed=seed,
            task=task,
            tolerance=tol,
            orientation_tolerance=tol_rad,
            rotation_length=rotation_length,
            threads=threads,
            **{name: value for name, value in given.items() if value is not None},
        )
        kept.what = lambda: what_is_kept(output)
        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        content = tune_to_file(choice, tuning, output, force=force, resume=resume)
        kept.what = lambda: f"gains: {output}"
        success = content.success
        with telling(f"gains: {output}"):
            if success is not None:
                typer.echo(
                    f"{success.solved} of {success.goals} goals kept apart are reached "
                    f"(training: {content.training.solved} of {content.training.goals})"
                )
            for line in comparison(content, choice, tuning):
                typer.echo(line)
            typer.echo(f"gains: {output}")


@app.command()
@refuses(**_options.BY_HARVEST)
def harvest(
    scene: Annotated[Path, typer.Argument(help="Scene with targets: .json or .toml.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    robot: Annotated[
        str,
        typer.Option(
            help="An arm on a slide with bodies: a name, .toml or .urdf.",
            autocompletion=_options.robot_names,
        ),
    ] = "cucumber",
    distance: _harvest_options.DistanceOption = "exact",
    refine: _harvest_options.Refine = True,
    recovery: _harvest_options.Recovery = True,
    blockers: _harvest_options.BlockersOption = True,
    pictures: Annotated[bool, typer.Option(help="Draw pictures; needs Matplotlib.")] = True,
    tilt_deg: _harvest_options.Tilt = 0.0,
    shift: _harvest_options.Shift = 0.0,
    min_distance: _harvest_options.MinDistance = 0.005,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    paths: Annotated[
        bool, typer.Option("--path", help="Plan the ways into the postures as well.")
    ] = False,
    start: _options.Start = None,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads; by default all cores.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
) -> None:
    """Decide for every fruit of a scene whether and how it can be picked.

    Writes harvest.csv (one row a fruit), harvest.json and pictures: the share that can be
    picked, why not the rest, and which leaves block it. With --path also paths.json: for each
    fruit the way into its posture, proven free, or why there is none.
    """
    with exit_codes() as kept:
        from ..errors import ArgumentError
        from ..jobs import RobotChoice
        from ._harvest import check_folder, evaluate, lines, settings_of
        from .progress import for_stream

        if start is not None and not paths:
            raise ArgumentError("--start", repr(start), "--path as well: ways start there")
        check_folder(output, force=force)
        arm = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        kept.what = lambda: f"files that were finished are in {output}"
        with for_stream(sys.stderr) as bar:
            done = 0

            def advance(now: int, total: int) -> None:
                nonlocal done
                if done == 0:
                    bar.start("fruits", total)
                bar.advance(now - done)
                done = now

            settings = settings_of(
                refine=refine,
                recovery=recovery,
                tilt_deg=tilt_deg,
                shift=shift,
                min_distance=min_distance,
            )
            found = evaluate(
                scene,
                arm,
                distance,
                settings=settings,
                blockers=blockers,
                threads=threads,
                progress=advance,
            )
        from ..harvest import write_report

        files = write_report(found, output, pictures=pictures, report=say)
        for line in lines(found):
            say(line)
        if paths:
            from ._harvest import write_paths

            file, said = write_paths(found, output, start=start, threads=threads)
            files.append(file)
            say(said)
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))


@app.command()
@refuses(mask="its panel has the tasks pose, axis and position")
def view(
    robot: _options.Robot,
    scene: Annotated[
        Path | None, typer.Option(help="What stands round it: a .json or .toml scene file.")
    ] = None,
    targets: Annotated[
        Path | None, typer.Option(help="Targets to step through, as for `solve`.")
    ] = None,
    path: Annotated[
        Path | None,
        typer.Option(help="Targets to follow, or postures that `solve` wrote, to be played."),
    ] = None,
    show: Annotated[
        str, typer.Option(help="What the arm is shown as: auto, chain, bodies or visuals.")
    ] = "auto",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.")] = 8080,
    host: Annotated[
        str, typer.Option(help="Address to listen to; by default this machine alone.")
    ] = "127.0.0.1",
    export: Annotated[
        Path | None,
        typer.Option(help="Write a page that needs no server instead: a .html file."),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing page.")] = False,
    q0: Annotated[
        str | None,
        typer.Option("--q0", help="Posture at first, radians and metres, such as 0,-1.57,0."),
    ] = None,
    solver: Annotated[
        str | None,
        typer.Option(
            help="Solver that the panel begins with: a name, or a gain file (.toml, .json).",
            show_default="lm",
            autocompletion=_options.solver_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
) -> None:
    """Show an arm in the browser: drag its target, look at branches, limits and collisions.

    Ctrl-C ends it. Needs the extra `viewer`.
    """
    with exit_codes() as kept:
        from ..jobs import RobotChoice
        from ._view import ViewRequest, write_page

        kept.what = lambda: "the viewer has ended"
        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        request = ViewRequest(choice, scene, targets, path, show, host, port, q0, solver)
        if export is not None:
            kept.what = lambda: "nothing was written"
            file = write_page(request, export, force=force)
            with telling(f"page: {file}"):
                typer.echo(f"page: {file}")
            return
        with request.open(browser=browser) as viewer:
            with telling():
                typer.echo(f"{viewer.robot.name}: {viewer.url} (Ctrl-C ends it)")
            viewer.wait()


@app.command()
@refuses(mask="a way ends at a point, in a whole pose or in joint values")
def plan(
    robot: _options.Robot,
    target: Annotated[
        str,
        typer.Option(
            "--target",
            help="A target of the scene by name, x,y,z in metres, x,y,z,roll,pitch,yaw with "
            "radians, or q= and joint values.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Trajectory: .csv, .json, .npz, ...")
    ],
    scene: Annotated[
        Path | None, typer.Option("--scene", help="What stands round it: .json or .toml.")
    ] = None,
    start: _options.Start = None,
    solver: Annotated[
        str | None,
        typer.Option(
            help="Solver of the searches for postures at a point x,y,z.",
            show_default="lm",
            autocompletion=_options.solver_names,
        ),
    ] = None,
    base_link: _options.BaseLink = None,
    tip_link: _options.TipLink = None,
    tool: _options.Tool = None,
    frame: _options.Frame = None,
    clear: Annotated[float, typer.Option(help="Distance kept from the scene, m.")] = 0.002,
    blend: Annotated[
        float, typer.Option(help="How much of a segment corners are rounded on, 0 to 0.5.")
    ] = 0.4,
    seed: Annotated[int, typer.Option(min=0, help="Which random numbers are drawn.")] = 0,
    force: Annotated[
        bool, typer.Option("--force", help="Write over a file that is there.")
    ] = False,
) -> None:
    """Plan a path that is proven free, and write it as a trajectory.

    Corners are rounded as far as that is proven too. Exit status 3 where there is no path; the
    reason is said.
    """
    with exit_codes():
        from ..jobs import RobotChoice
        from ._motion import lines, trajectory
        from ._motion import plan as planned

        choice = RobotChoice(robot, base_link, tip_link, _options.tool(tool), frame)
        arm, around, found = planned(
            choice, scene, start, target, clear=clear, seed=seed, solver=solver
        )
        for note in arm.notes:
            say(f"{arm.name}: {note}")
        for line in lines(found):
            say(line)
        if not found.ok:
            raise typer.Exit(NOT_ALL_SOLVED)
        made = trajectory(arm, around, found, blend=blend, clear=clear)
        made.save(output, force=force)
        say(f"{len(made.times)} points, {made.duration:.3f} s: {output}")


@app.command()
def paper(
    name: Annotated[
        str, typer.Argument(help=f"Whose paper: {', '.join(PAPERS)}, or all of them: all.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
    experiments: Annotated[
        str | None,
        typer.Option(
            help="Strawberry: its 24 experiments by a model of their times (model, the default), "
            "or also on the board's program in a simulator (firmware)."
        ),
    ] = None,
) -> None:
    """Compute a paper's tables and figures anew and write them to a folder.

    Published values, where there are any, stand beside ours. `all` gives each paper a folder,
    and one page, index.html, with every table and picture. Needs the extra `papers`.
    """
    with exit_codes() as kept:
        from ._paper import ALL, check, reproduce
        from .progress import for_stream

        check(name, output, force=force, experiments=experiments)
        kept.what = lambda: f"files that were finished are in {output}"
        if name == ALL:
            with for_stream(sys.stderr) as bar:
                bar.start("papers", len(PAPERS))
                files = reproduce(
                    name,
                    output,
                    bar.note,
                    done=lambda _: bar.advance(1),
                )
        else:
            files = reproduce(
                name,
                output,
                lambda line: say(f"{name}: {line}"),
                experiments=experiments,
            )
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))


@app.command()
def detect(
    images: Annotated[list[Path], typer.Argument(help="Pictures, or folders of them.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")],
    calibration: Annotated[
        Path | None,
        typer.Option("--calibration", help="The camera's file (.json); for pictures of its size."),
    ] = None,
    view_deg: Annotated[
        float,
        typer.Option(
            help="Without a calibration: how wide the camera sees, degrees.", min=1, max=170
        ),
    ] = 60.0,
    radius_mm: Annotated[
        float | None, typer.Option(help="The fruits' radius, mm: places then are in the table.")
    ] = None,
    boxes: Annotated[
        Path | None,
        typer.Option(
            help="Boxes that you marked (.csv: image,left,top,right,bottom in pixels): says how "
            "many were found."
        ),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds files.")
    ] = False,
) -> None:
    """Find ripe tomatoes in pictures, draw them and write a table.

    Writes detections.csv (one row a fruit: status, place and half angle; not_found for a picture
    without any) and every picture with what was found. Only status ok is fit to be approached.
    Needs the extra `vision`.
    """
    with exit_codes() as kept:
        from ._detect import DetectRequest
        from ._detect import detect as look

        kept.what = lambda: f"pictures that were finished are in {output}"
        request = DetectRequest(images, output, calibration, view_deg, radius_mm, boxes, force)
        files = look(request, say)
        with telling(f"files: {output}"):
            for file in files:
                typer.echo(str(file))


@app.command()
def drive(
    rig: Annotated[str, typer.Argument(help="strawberry or tomato.")],
    targets: Annotated[
        Path | None,
        typer.Option(
            help="Points: .csv, .npy, .npz or .parquet; columns x,y,z without a unit are mm."
        ),
    ] = None,
    port: Annotated[
        str,
        typer.Option(
            help="simulated (the firmware in a simulator), or what pyserial takes: /dev/ttyACM0, "
            "COM3, socket://host:port."
        ),
    ] = "simulated",
    calibration: Annotated[
        Path | None, typer.Option(help="Calibration file; the bundled one by default.")
    ] = None,
    method: Annotated[
        str, typer.Option(help="Strawberry: exact, as, ssas or ncos, for the joint values.")
    ] = "exact",
    psi: Annotated[float, typer.Option(help="Strawberry: turn of the gripper in degrees.")] = 0.0,
    h_extra: Annotated[
        float | None,
        typer.Option(
            help="Strawberry: how far above its end the arm waits, in mm; by default 30, or as "
            "much more as keeps it clear of the plant."
        ),
    ] = None,
    near: Annotated[
        bool, typer.Option("--near", help="Tomato: slowly, 60 instead of 200 degrees/s.")
    ] = False,
    log: Annotated[
        Path | None, typer.Option(help="File that every frame on the line is written to.")
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            help="Tomato, instead of --targets: a camera that finds them. simulated (the renderer, "
            "with --port simulated), the number of a device, a video, or a folder of pictures."
        ),
    ] = None,
    camera_calibration: Annotated[
        Path | None, typer.Option(help="The camera's file (.json), as `vision.Camera.save` writes.")
    ] = None,
    camera_pose: Annotated[
        Path | None,
        typer.Option(help="The camera's pose in the arm's frame: .json, a matrix of 4 x 4, m."),
    ] = None,
    radius_mm: Annotated[float, typer.Option(help="With --camera: the fruits' radius.")] = 30.0,
    radius_sigma_mm: Annotated[
        float, typer.Option(help="Its standard deviation: the gap before the fruit grows with it.")
    ] = 0.0,
    seconds: Annotated[
        float | None, typer.Option(help="With --camera: how long; until Ctrl-C by default.")
    ] = None,
) -> None:
    """Drive the strawberry or the tomato rig from target to target, or to what a camera sees.

    A table shows where it is; with a camera, the numbers of the last picture. Ctrl-C stops the
    motors first. At the first target that cannot be driven to the motors stop, and the rest of the
    list is named. Needs the extra `drivers` (with a camera, `vision` too), and for the simulated
    rig a checkout with `make firmware`.
    """
    with exit_codes() as kept:
        from ._drive import DriveRequest, Row, count, drive_words, one_of

        one_of(targets, camera)
        if camera is not None:
            from ._point import PointRequest, Summary, point, said

            summary = Summary()
            kept.what = lambda: f"servos hold or are off; {said(summary)}"
            pointing = PointRequest(
                rig,
                port,
                camera,
                calibration,
                camera_calibration,
                camera_pose,
                radius_mm / 1000,
                radius_sigma_mm / 1000,
                seconds,
                log,
            )
            point(pointing, summary)
            with telling():
                typer.echo(said(summary))
            return
        assert targets is not None
        rows: list[Row] = []
        kept.what = lambda: f"motors are stopped; {count(rows)}" if rows else "nothing has moved"
        request = DriveRequest(
            rig=rig,
            port=port,
            targets=targets,
            calibration=calibration,
            method=method,
            psi_deg=psi,
            h_extra_mm=h_extra,
            near=near,
            log=log,
        )
        drive_words(request, rows)
        with telling():
            typer.echo(count(rows))
