"""``qrobot reproduce``: the paper's tables and figures, its seconds beside ours."""

from __future__ import annotations

import os
import sys

import click

from qrobot.cli.options import FILE, written
from qrobot.cli.streams import say, show

__all__ = ["command"]

TARGETS = ["table1", "table2", "table3", "figure4", "figure7", "all"]


@click.command("reproduce")
@click.argument("targets", nargs=-1, required=True, type=click.Choice(TARGETS))
@written("--output", "-o", help="Folder for all files.  [default: build/reproduce]")
@click.option("--rows", help="Numbers of items, such as 2-5 or 2,4,10-12.")
@click.option("--largest", type=int, help="Largest number of items.")
@click.option("--quick", is_flag=True, help="At most 4 items, no SDK: under a minute.")
@click.option("--large", is_flag=True, help="Simulate 26 qubits too (needs 1.5 GiB).")
@click.option(
    "--reads", type=int, default=1000, show_default=True, help="Reads (shots) of every method."
)
@click.option(
    "--seed", type=int, default=7, show_default=True, help="Seed of places and of random numbers."
)
@click.option("--resume", is_flag=True, help="Keep what an earlier run in the folder finished.")
@click.option("--docs", type=FILE, help="Also write the tables between the marks of a page.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
def command(
    targets: tuple[str, ...],
    output: str | None,
    rows: str | None,
    largest: int | None,
    quick: bool,
    large: bool,
    reads: int,
    seed: int,
    resume: bool,
    docs: str | None,
    as_json: bool,
) -> None:
    """Reproduce tables 1 to 3 and figures 4 and 7 of the qRobot paper (2021).

    The same n, K, M and numbers of qubits; the paper's seconds beside ours; the raw reads of
    every method, beside as many random guesses. The paper gives no coordinates: places are
    drawn with the seed. Writes CSV, Markdown, plots and reproduce.json, row by row.

    \b
    Examples:
      qrobot reproduce all --quick
      qrobot reproduce table2 --rows 2-5 --output build/reproduce
      qrobot reproduce figure4 figure7
      qrobot reproduce all --large --resume --docs docs/reproduction.md

    Exit codes: 0 done, 2 bad input, 3 a backend failed, 130 interrupted (what is done is kept).
    """
    # Rows are measured on one thread. OpenBLAS reads this when numpy is imported, just below;
    # with more it spins, ten times slower beside other work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from qrobot.cli.signals import terminate_as_interrupt
    from qrobot.study.reproduce import Settings, reproduce
    from qrobot.study.reproduce.tables import (
        check_page,
        drawn_text,
        fill_page,
        place_text,
        result_text,
        summary,
    )

    output = output or "build/reproduce"
    if docs:
        check_page(docs)

    def tell(text: str) -> None:
        say(text, err=True)

    with terminate_as_interrupt() as interrupted:
        report = reproduce(
            [name for name in TARGETS[:-1] if name in targets or "all" in targets],
            output,
            Settings(reads, seed, rows, largest, large, quick),
            resume=resume,
            on_start=lambda line: tell(f"{place_text(line)} ..."),
            on_line=lambda line: tell(result_text(line)),
            interrupted=interrupted,
            on_figure=lambda figure: tell(drawn_text(figure)),
        )
    if docs and not report["interrupted"]:
        fill_page(docs, output)
    show(summary(report, output), report, as_json)
    if report["interrupted"]:
        say(f"interrupted: {len(report['lines'])} lines are kept in {output}", err=True)
        sys.exit(130)
    sys.exit(3 if any(line["status"] == "failed" for line in report["lines"]) else 0)
