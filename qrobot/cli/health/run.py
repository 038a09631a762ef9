"""``qrobot health NAMES...``: runs the checks, and writes what they found in every format."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any

import click

from qrobot._json import json_text
from qrobot.cli.options import FILE, written
from qrobot.cli.streams import say, show
from qrobot.errors import InputError

if TYPE_CHECKING:
    from qrobot.health import Check, CheckResult, Limits

__all__ = ["Limit", "listing", "run"]


class Limit(click.FloatRange):
    """A finite number above zero: with ``nan`` or ``inf`` there would be no limit."""

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number."""
        number = float(super().convert(value, param, ctx))  # type: ignore[arg-type]
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


def listing(checks: list[Check], as_json: bool) -> str:
    """Return the checks as a table or as JSON; none is run."""
    from qrobot._text import columns

    if as_json:
        rows: list[dict[str, Any]] = [
            {"name": c.name, "group": c.group, "title": c.title, "quick": c.quick,
             "profile": c.profile, "expected_from": c.source, "extra": c.extra,
             "versions": c.versions()}
            for c in checks
        ]  # fmt: skip
        return json_text(rows, indent=1)
    heads = ["check", "group", "computes", "quick", "profile", "installed"]
    return columns(
        heads,
        [
            [c.name, c.group, c.title, "yes" if c.quick else "no", c.profile,
             next(iter(c.versions().values()), "no")]
            for c in checks
        ],
    )  # fmt: skip


class Run(click.Command):
    """Shows itself without the word ``run``, which nobody has to write."""

    def format_usage(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write how it is called."""
        path = ctx.parent.command_path if ctx.parent else ctx.command_path
        formatter.write_usage(path, "[OPTIONS] [NAMES]...")
        formatter.write_usage(path, "merge | compare FILES...", " " * len("Usage: "))


@click.command("run", cls=Run)
@click.argument("names", nargs=-1)
@click.option("--quick", is_flag=True, help="Run only the cheap checks.")
@click.option("--profile", help="Require a profile: base, solver, edge or full.")
@click.option("--list", "as_list", is_flag=True, help="List the checks and run none.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.option("--schema", is_flag=True, help="Print the JSON Schema of the report and run none.")
@written("--output", "-o", help="Write the report as JSON.")
@written("--junit", "junit_path", help="Write the report as JUnit XML.")
@written("--html", "html_path", help="Write the report as an HTML page.")
@written("--prometheus", help="Write the report as metrics, to NAME.prom.")
@click.option(
    "--compare",
    "baseline",
    type=FILE,
    help="Show what changed since a report.",
)
@click.option(
    "--strict-compare", is_flag=True, help="With --compare: exit with 1 for any difference."
)
@click.option(
    "--notebooks",
    type=FILE,
    help="Run the notebooks, one by one, and keep them in a folder.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Number of checks at the same time.",
)
@click.option(
    "--timeout",
    type=Limit(),
    default=300.0,
    show_default=True,
    metavar="SECONDS",
    help="Time limit of one check.",
)
@click.option(
    "--memory",
    type=Limit(),
    default=2048.0,
    show_default=True,
    metavar="MB",
    help="Memory limit of one check, in MiB.",
)
@click.option("--no-system", is_flag=True, help="Do not look at the machine.")
@click.option("--network", is_flag=True, help="Also try to reach the quantum services.")
def run(
    names: tuple[str, ...], quick: bool, profile: str | None, as_list: bool, as_json: bool,
    schema: bool, output: str | None, junit_path: str | None, html_path: str | None,
    prometheus: str | None, baseline: str | None, strict_compare: bool, notebooks: str | None,
    jobs: int, timeout: float, memory: float, no_system: bool, network: bool,
) -> None:  # fmt: skip
    """Prove that every installed stack computes right.

    Each check imports one stack and lets it compute something whose answer is known from
    elsewhere, in a process of its own: a crash or a hang is reported and the others go on.
    Without NAMES all are run; a stack that is not installed is then not a fault. With NAMES or
    --profile it is. The machine is examined too: a fault there counts, a warning does not.

    Exit code 0: healthy, 1: a check failed, the machine has a fault, or something got worse
    since --compare, 2: bad input, or a report or notebook could not be written. Times, memory
    and what changes all the time, such as a temperature, do not count as drift.

    \b
    Examples:
      qrobot health
      qrobot health qiskit aer --json
      qrobot health --profile edge --jobs 2 --output today.json --html today.html
      qrobot health --quick --compare yesterday.json
      qrobot health merge reports/*.json --html fleet.html
    """
    from qrobot._files import check_outputs
    from qrobot.cli.health.reports import show_report
    from qrobot.cli.signals import exit_on_signals
    from qrobot.health import Limits, choose, make_report, read_report, system_findings
    from qrobot.health.record import Stopwatch, schema_text
    from qrobot.health.reports import compare, document, save

    if schema:
        say(schema_text(), end="")
        return
    checks = choose(names, quick=quick, profile=profile)
    if as_list:
        say(listing(checks, as_json))
        return
    if network and no_system:
        raise InputError(
            "it is part of what --no-system leaves out",
            field="--network",
            advice="give one of both",
        )
    if strict_compare and not baseline:
        raise InputError(
            "there is nothing to compare with",
            field="--strict-compare",
            advice="give --compare too",
        )
    # All that can be refused is refused now: the checks take minutes.
    before = read_report(baseline) if baseline else None
    others = [path for path in (junit_path, html_path, prometheus) if path]
    check_outputs([*others, *([output] if output else [])])
    if baseline:
        check_outputs(others, [baseline])  # which --output alone may replace
    if notebooks:
        from qrobot.health.notebooks import prepare

        prepare(notebooks, checks)
    click.get_current_context().with_resource(exit_on_signals())
    limits = Limits(seconds=timeout, megabytes=memory)
    clock = Stopwatch()
    findings = [] if no_system else system_findings(network=network)
    results, troubles = _results(checks, limits, jobs, notebooks)
    report = make_report(
        results,
        findings,
        clock=clock,
        profile=profile or ("quick" if quick else "named" if names else "all"),
        required=bool(names or profile),
    )
    drift = compare(before, report) if before else None
    troubles += save(
        report,
        drift,
        output=output,
        junit_path=junit_path,
        html_path=html_path,
        prometheus=prometheus,
    )
    show(show_report(report, drift), document(report, drift), as_json)
    for trouble in troubles:
        say(f"qrobot: {trouble}", err=True)
    if troubles:
        sys.exit(2)
    worse = drift is not None and (drift.worse or (strict_compare and drift.drift))
    sys.exit(1 if worse or not report.healthy else 0)


def _results(
    checks: list[Check], limits: Limits, jobs: int, notebooks: str | None
) -> tuple[list[CheckResult], list[InputError]]:
    """Return what the checks gave, and why copies of notebooks could not be written."""
    from qrobot.health import run_all

    begun = 0

    def tell(check: Check) -> None:
        nonlocal begun
        begun += 1
        say(f"{begun}/{len(checks)} {check.name}", err=True)

    if notebooks is None:
        return run_all(checks, limits, jobs=jobs, progress=tell), []
    from qrobot.health.notebooks import run_notebooks

    return run_notebooks(checks, notebooks, limits, progress=tell)
