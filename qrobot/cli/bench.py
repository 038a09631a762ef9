"""``qrobot bench``: backends against each other and against references."""

from __future__ import annotations

import sys

import click

from qrobot.cli.options import FILE, ReadingCommand, Robots, objective, rounding, written
from qrobot.cli.streams import say
from qrobot.errors import InputError

__all__ = ["command"]


@click.command("bench", cls=ReadingCommand)
@click.argument("folder", type=FILE)
@click.option(
    "--backends", default="auto", show_default=True, help="Names of backends, separated by commas."
)
@click.option("--deadline", "-t", type=float, help="Seconds for each run.  [default: 10]")
@click.option("--max-work", type=int, help="Limit of work units for each run.")
@click.option(
    "--seeds", type=int, default=1, show_default=True, help="Runs of each backend on each instance."
)
@click.option("--robots", type=Robots(), help="Number of robots instead of the file's, or 'free'.")
@click.option(
    "--robots-for", multiple=True, help="--robots for some instances: 'X-*=free'. Repeatable."
)
@objective
@rounding
@click.option("--match", default="*", help="Only files whose names match: 'A-*', 'henn/*'.")
@click.option(
    "--variant", help="Change the instances as an index.json has values for: two_blocks, .."
)
@click.option("--limit", type=int, help="Largest number of instances.")
@written("--json", "json_path", help="Write the report as JSON, row by row.")
@written("--csv", "csv_path", help="Write the rows as CSV.")
@written("--markdown", "markdown_path", help="Write tables as Markdown.")
@written("--plot", "plot_path", help="Draw gap against time: .svg or .png.")
def command(
    folder: str,
    backends: str,
    deadline: float | None,
    max_work: int | None,
    seeds: int,
    robots: int | str | None,
    robots_for: tuple[str, ...],
    objective: str,
    rounding: str | None,
    match: str,
    variant: str | None,
    limit: int | None,
    json_path: str | None,
    csv_path: str | None,
    markdown_path: str | None,
    plot_path: str | None,
) -> None:
    """Compare backends on a FOLDER of instances ({suffixes}), and the folders in it.

    References come from .sol files beside the instances, an index.json, or the instances
    themselves. Each run has a process of its own, so its peak memory is its own.

    \b
    Examples:
      qrobot bench instances/ --backends auto,pyvrp --deadline 10 --seeds 3 --json out.json
      qrobot bench instances/ --objective time
      qrobot bench cvrplib/ --robots-for 'X-*=free' --markdown out.md --plot out.svg
    """
    from pathlib import Path

    from qrobot._files import check_outputs, write_text_atomic
    from qrobot.cli.signals import terminate_as_interrupt
    from qrobot.errors import InputError
    from qrobot.plan.objective import objective_named
    from qrobot.planning import DEFAULT_DEADLINE
    from qrobot.report.picture import check_picture_path
    from qrobot.study.bench import BenchRow, find_instances, run_bench, tasks
    from qrobot.study.bench_report import bench_csv, bench_markdown, bench_plot, row_text
    from qrobot.study.variants import VARIANTS

    named = _checked(backends, seeds, deadline=deadline, limit=limit, max_work=max_work)
    if deadline is None and max_work is None:
        deadline = DEFAULT_DEADLINE
    check_outputs([path for path in (json_path, csv_path, markdown_path, plot_path) if path])
    if plot_path:
        check_picture_path(plot_path)
    if variant not in (None, *VARIANTS):
        raise InputError(
            f"{variant!r:.40} is not a variant",
            field="--variant",
            advice=f"use one of {', '.join(VARIANTS)}",
        )
    todo = tasks(
        find_instances(folder, match)[:limit],
        named,
        seeds,
        deadline=deadline,
        max_work=max_work,
        robots=robots,
        robots_for=robots_for,
        rounding=rounding,
        objective=objective_named(objective, field="--objective").name,
        root=Path(folder),
        variant=variant,
    )
    most = "" if deadline is None else f", at most {len(todo) * deadline:.0f} s of searching"
    say(f"{len(todo)} runs{most}", err=True)

    def tell(done: int, row: BenchRow) -> None:
        say(f"{done}/{len(todo)} {row_text(row)}", err=True)

    with terminate_as_interrupt() as interrupted:
        report = run_bench(todo, save=json_path, on_row=tell, interrupted=interrupted)
    if csv_path:
        bench_csv(report, csv_path)
    text = bench_markdown(report, folder)
    if markdown_path:
        write_text_atomic(markdown_path, text)
    if plot_path:
        bench_plot(report, plot_path)
    say(bench_markdown(report, folder, rows=False))
    if report["interrupted"]:
        say(f"interrupted: {len(report['rows'])} of {len(todo)} runs are kept", err=True)
        sys.exit(130)
    sys.exit(0 if all(row["error"] is None or row["proven"] for row in report["rows"]) else 1)


def _checked(backends: str, seeds: int, **limits: float | None) -> list[str]:
    """Return the names of the backends, when they and all limits can be used."""
    from qrobot.backends import get

    if seeds < 1:
        raise InputError(f"{seeds} seeds are too few", field="--seeds", advice="give 1 or more")
    named = [name.strip() for name in backends.split(",") if name.strip()]
    for name in named:
        get(name)
    if not named:
        raise InputError("no backend is named", field="--backends", advice="name one, such as auto")
    for name, value in limits.items():
        if value is not None and not 0 < value < float("inf"):
            field = f"--{name.replace('_', '-')}"
            raise InputError(
                f"{value} is not above zero", field=field, advice="give a number above 0"
            )
    return named
