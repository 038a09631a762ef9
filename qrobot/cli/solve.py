"""``qrobot solve``: orders in, a checked plan out."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from qrobot.cli.options import (
    FILE,
    Question,
    ReadingCommand,
    Setting,
    objective,
    reading_options,
    settings_of,
)
from qrobot.cli.streams import say, say_json, show
from qrobot.errors import InfeasibleError, InputError, QRobotError

if TYPE_CHECKING:
    from qrobot.planning import Result
    from qrobot.problem import Instance

__all__ = ["command"]


@click.command("solve", cls=ReadingCommand)
@click.argument("instance", type=FILE)
@click.option(
    "--backend",
    "-b",
    default="auto",
    show_default=True,
    help="Who plans; `qrobot backends` lists them.",
)
@click.option(
    "--deadline",
    "-t",
    type=float,
    help="Seconds until the best plan so far is taken.  [default: 10]",
)
@click.option("--max-work", type=int, help="Limit of work units: repeatable plans on any machine.")
@objective
@click.option(
    "--routing",
    default="exact",
    show_default=True,
    help="How trips are walked: exact, or by a policy: s-shape, return, midpoint, largest-gap, "
    "combined or aisle-by-aisle.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of every random choice.")
@reading_options
@click.option("--encoding", help="Sampler: full, reduced, compact or batches.")
@click.option("--slack", help="Sampler: exact or paper.")
@click.option("--reads", type=int, help="Sampler: number of reads.")
@click.option(
    "--option",
    "-O",
    "settings",
    multiple=True,
    type=Setting(),
    help="Sampler: any of its options, such as device=aer or layers=2. Repeatable.",
)
@click.option(
    "--control", is_flag=True, help="Sampler: also report as many random reads and starts."
)
@click.option("--fallback", help="Local backend that plans when the first one fails.")
@click.option(
    "--each-robot",
    metavar="BACKEND",
    help="Let this backend plan the sequence of each trip alone, with half of the time; sampler "
    "options are its own then.",
)
@click.option("--max-cost", type=float, help="US dollars: refuse a remote job that may cost more.")
@click.option("--dry-run", is_flag=True, help="Estimate the cost of a remote job; submit nothing.")
@click.option("--no-wait", is_flag=True, help="Submit a remote job, print its id and exit.")
@click.option(
    "--output", "-o", multiple=True, type=FILE, help="Write the plan as JSON. Repeatable."
)
@click.option(
    "--picture",
    "-p",
    multiple=True,
    type=FILE,
    help="Draw the plan: .svg or .png, or .html with moving robots. Repeatable.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON, nothing else.")
@click.option("--quiet", "-q", is_flag=True, help="Only warnings and errors.")
def command(
    question: Question,
    backend: str,
    encoding: str | None,
    slack: str | None,
    reads: int | None,
    settings: tuple[tuple[str, Any], ...],
    dry_run: bool,
    no_wait: bool,
    each_robot: str | None,
    output: tuple[str, ...],
    picture: tuple[str, ...],
    as_json: bool,
    quiet: bool,
    **asked: Any,
) -> None:
    """Plan which robot collects which orders, in which sequence, by which way.

    INSTANCE is a file of a known format: {formats};
    "example" is the small warehouse that comes with qRobot (example:NAME for the others).
    Every plan is verified by an independent checker. Ctrl-C keeps the best plan so far.

    \b
    Examples:
      qrobot solve example
      qrobot solve examples/small-warehouse.json
      qrobot solve examples/small-warehouse.json -t 5 -o plan.json -p plan.svg -p plan.png
      qrobot solve examples/small-warehouse.json --objective time -p moving.html
      qrobot solve examples/orders.csv --layout examples/layout.json
      qrobot solve examples/paper-7-items.json --backend neal --control
      qrobot solve examples/small-warehouse.json --each-robot neal --reads 50
      qrobot solve X-n101-k25.vrp --robots free --deadline 30
      qrobot solve examples/paper-4-items-m45.json --robots 1 -b qiskit-vqe -O layers=1
      qrobot solve examples/paper-7-items.json -b dwave-qpu --dry-run
      qrobot solve examples/paper-7-items.json -b dwave-qpu --max-cost 0.50 --fallback auto
    """
    # OpenBLAS reads this when numpy is imported; with more threads it spins on small matrices.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from qrobot.backends.registry import require

    wanted = [backend if asked["fallback"] is None else None, each_robot]
    for name in filter(None, wanted):
        require(name)  # before numpy and dimod: a missing package is reported at once
    from qrobot.cli.progress import progress_line
    from qrobot.cli.signals import stop_on_signals
    from qrobot.planning import solve

    _check_files(output, picture, question.files)
    options = settings_of(
        {
            "encoding": ("--encoding", encoding),
            "slack": ("--slack", slack),
            "num_reads": ("--reads", reads),
        },
        settings,
    )
    with stop_on_signals() as stop:
        with progress_line(quiet or as_json) as line:
            instance = question.read()
            if dry_run or no_wait:
                useless: dict[str, Any] = {"--output": output, "--picture": picture}
                useless |= {
                    f"--{name}": asked[name] for name in ("control", "fallback", "deadline")
                }
                useless["--each-robot"] = each_robot
                useless["--routing"] = asked["routing"] != "exact"
                _refuse("--dry-run" if dry_run else "--no-wait", useless)
                part = _estimate if dry_run else _hand_over
                part(instance, backend, asked, options, as_json)
                return
            try:
                plan = solve if each_robot is None else partial(_decentral, each_robot, options)
                more = options if each_robot is None else {}
                result = plan(
                    instance, backend=backend, stop=stop, on_progress=line, **asked, **more
                )
            except InfeasibleError as error:
                if stop.requested and not error.proven:
                    raise click.Abort from None  # interrupted before there was a plan
                raise
        # The files first, and before a second signal of the same hangup can end the program: no
        # reader of the output that goes away must cost the plan.
        trouble = _write(result, output, picture)
    if result.answered_by != result.backend and (quiet or as_json):
        say(f"qrobot: warning: {result.notes[-1]}", err=True)
    # A disk that is full must not cost the plan either, so the output comes before its error.
    if as_json:
        say_json(result.to_dict())
    elif not quiet:
        from qrobot.report import table

        say(table(result))
        say(result.summary())
    if trouble is not None:
        raise trouble
    if not (quiet or as_json):
        for path in [*output, *picture]:
            say(f"written: {path}")


def _decentral(
    each_robot: str, options: dict[str, Any], instance: Instance, **asked: Any
) -> Result:
    """Plan centrally with half of the time, and let each robot plan its sequences in the other."""
    from qrobot.planning import route_each, solve

    deadline = None if asked["deadline"] is None else asked["deadline"] / 2
    central = {**asked, "deadline": deadline, "control": False, "max_cost": None}
    result = solve(instance, **central)
    names = ("max_work", "seed", "control", "max_cost", "stop", "on_progress")
    own = {name: asked[name] for name in names}
    return route_each(result, each_robot, deadline=deadline, **own, **options)


def _write(result: Result, output: tuple[str, ...], picture: tuple[str, ...]) -> Exception | None:
    """Write the plan and its pictures, all that can be; return the first error."""
    notes: dict[str, None] = {}

    def picture_to(path: str) -> None:
        from qrobot.report.picture import draw

        notes.update(dict.fromkeys(draw(result, path)))

    troubles: list[Exception] = []
    for paths, write in ((output, result.save), (picture, picture_to)):
        for path in paths:
            try:
                write(path)
            except QRobotError as error:
                troubles.append(error)
    for note in notes:  # with --quiet too: whoever reads the picture would miss it
        say(f"qrobot: note: {note}", err=True)
    return troubles[0] if troubles else None


def _check_files(output: Sequence[str], picture: Sequence[str], inputs: Sequence[str]) -> None:
    """Refuse files that could not be written, before the search."""
    from qrobot._files import check_outputs

    check_outputs([*output, *picture], inputs)
    if picture:
        from qrobot.report import check_picture_path

        for path in picture:
            check_picture_path(path, animated=True)


def _refuse(flag: str, options: dict[str, Any]) -> None:
    """Refuse options that would do nothing."""
    for name, value in options.items():
        if value not in (None, False, ()):
            raise InputError(f"{flag} makes no plan yet", field=f"--{name}", advice="leave it out")


def _estimate(
    instance: Instance, backend: str, asked: dict[str, Any], options: dict[str, Any], as_json: bool
) -> None:
    """Say what a remote job would cost."""
    from qrobot.jobs import check_budget
    from qrobot.planning import estimate

    limits = {name: asked[name] for name in ("seed", "max_work")}
    cost = estimate(instance, backend, **limits, **options)
    check_budget(cost, asked["max_cost"])
    data = {"backend": backend, "submitted": False, "estimate": cost.to_dict()}
    show(f"{backend} would cost {cost}; nothing was submitted", data, as_json)


def _hand_over(
    instance: Instance, backend: str, asked: dict[str, Any], options: dict[str, Any], as_json: bool
) -> None:
    """Submit a remote job, and say how its plan is fetched."""
    from qrobot.planning import submit

    wishes = {name: asked[name] for name in ("seed", "max_cost", "objective")}
    job = submit(instance, backend, **wishes, **options)
    fetch = f"qrobot jobs fetch {job['id']} --plan plan.json"
    show(f"job {job['id']} is {job['state']}; '{fetch}' makes a plan of it", job, as_json)
