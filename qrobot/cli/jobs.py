"""``qrobot jobs``: jobs on remote machines that outlived their process."""

from __future__ import annotations

from pathlib import Path

import click

from qrobot._json import json_text
from qrobot.cli.options import written
from qrobot.cli.streams import say, say_json, show
from qrobot.errors import InputError

__all__ = ["command"]

STATES = ("submitting", "queued", "running", "done", "failed", "cancelled")


@click.group("jobs")
def command() -> None:
    """List, fetch and cancel jobs on remote machines.

    Every remote job is kept in a small file of yours before it is submitted, so that its
    answer can be fetched when the process that asked for it is gone.

    \b
    Examples:
      qrobot jobs list --refresh
      qrobot jobs fetch qr-3f9a2c71d0b4 --plan plan.json
      qrobot jobs cancel qr-3f9a2c71d0b4
    """


@command.command("list")
@click.option("--state", type=click.Choice(STATES), help="Only jobs in this state.")
@click.option("--backend", help="Only jobs of this backend.")
@click.option("--refresh", is_flag=True, help="Ask the services first.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def list_(state: str | None, backend: str | None, refresh: bool, as_json: bool) -> None:
    """List jobs, the newest first."""
    from qrobot.backends import get
    from qrobot.backends.jobs import refresh_all
    from qrobot.jobs import JobStore
    from qrobot.jobs.samples import jobs_table

    with JobStore() as store:
        jobs = store.list(None if refresh else state, backend)
        troubles = refresh_all(jobs, store, get) if refresh else []
        jobs = [job for job in jobs if state in (None, job.state)]
    for trouble in troubles:
        say(f"not refreshed: {trouble}", err=True)
    show(jobs_table(jobs), [job.to_dict() for job in jobs], as_json)


@command.command("fetch")
@click.argument("job")
@written("--output", "-o", help="Write the samples as JSON (of dimod).")
@written("--plan", help="Write the plan as JSON; checked like every plan.")
@click.option("--json", "as_json", is_flag=True, help="Print the job as JSON.")
def fetch_(job: str, output: str | None, plan: str | None, as_json: bool) -> None:
    """Fetch the samples of a JOB that is done, by its id or the beginning of it."""
    from qrobot._files import check_outputs, write_text_atomic
    from qrobot.backends import get
    from qrobot.backends.jobs import fetch
    from qrobot.jobs import JobStore
    from qrobot.jobs.samples import samples_report, samples_text

    check_outputs([path for path in (output, plan) if path])
    with JobStore() as store:
        samples = fetch(job, store, get)
        report = samples_report(store.get(job), samples)
        if plan:
            from qrobot.planning import collect

            result = collect(job, store)
            result.save(plan)
    if output:
        write_text_atomic(output, json_text(samples.to_serializable()) + "\n")
    if as_json:
        say_json(report)
        return
    say(samples_text(report))
    if plan:
        say(result.summary())
    for path in (output, plan):
        if path:
            say(f"written: {Path(path)}")


@command.command("cancel")
@click.argument("job")
def cancel_(job: str) -> None:
    """Ask the service to drop a JOB that is not over."""
    from qrobot.backends import get
    from qrobot.backends.jobs import cancel
    from qrobot.jobs import JobStore

    with JobStore() as store:
        dropped = cancel(job, store, get)
    note = f": {dropped.problem}" if dropped.problem else ""
    say(f"{dropped.id} is {dropped.state}{note}")


@command.command("forget")
@click.option(
    "--days", type=float, default=30.0, show_default=True, help="Only jobs older than this."
)
def forget_(days: float) -> None:
    """Forget jobs that are over, and their answers; jobs that may still run are kept."""
    from qrobot.jobs import JobStore

    if not 0 <= days < float("inf"):
        raise InputError(
            f"{days:g} is not an age in days", field="--days", advice="give 0 or more days"
        )
    with JobStore() as store:
        say(f"{store.prune(days)} jobs are forgotten")
