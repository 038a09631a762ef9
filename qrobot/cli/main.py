"""The group of commands, loaded when they are called, and what errors turn into."""

from __future__ import annotations

import importlib
import io
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from qrobot._version import __version__
from qrobot.cli.streams import prepare, say
from qrobot.errors import QRobotError

__all__ = ["COMMANDS", "cli", "main"]

COMMANDS = {
    "solve": "Plan which robot collects which orders, in which sequence, by which way.",
    "waves": "Cut many orders into waves, and plan one after the other.",
    "next": "Rank the waiting orders by what each costs from where a robot stands now.",
    "check": "Check a plan against its instance, without trusting any solver.",
    "picklist": "Print what each robot takes at each stop, and the basket that it goes into.",
    "schedule": "Print when each robot leaves and is back, trip by trip.",
    "ways": "Write the ways and stops of a plan as GeoJSON, for maps of other programs.",
    "state": "Tell what of a plan is delivered and under way at a moment.",
    "replan": "Plan the rest of a plan in progress anew, and tell what changes.",
    "compare-routing": "Compare the routing policies that pickers know on the trips of a plan.",
    "backends": "List the backends: what they can do and how to install them.",
    "bench": "Compare backends on a folder of instances.",
    "export": "Write the model of an instance as a file for other programs.",
    "reproduce": "Reproduce the tables and figures of the paper, its seconds beside ours.",
    "compile": "Compile the searches for this machine, so that no plan waits for it.",
    "jobs": "List, fetch and cancel jobs on remote machines.",
    "health": "Prove that every installed stack computes right.",
    "image": "Prepare the card of a Raspberry Pi for its first boot.",
    "doctor": "Show versions, extras, credentials present, and folders.",
}
"""Name and one line of help; the module of that name (``_`` for ``-``) holds the command."""


class LazyGroup(click.Group):
    """A group that imports a command only when it is called: `--help` stays fast on a Pi."""

    def list_commands(self, _ctx: click.Context) -> list[str]:
        """Return the commands in the sequence that they are listed in."""
        return list(COMMANDS)

    def get_command(self, _ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(
            f"qrobot.cli.{cmd_name.replace('-', '_')}"
        ).command
        return command

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; ``ctx.obj`` says whether the user wants to see what libraries say."""
        with quiet_libraries(ctx.obj):
            return super().invoke(ctx)

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="qrobot")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def cli(debug: bool) -> None:
    """Order picking and batching for warehouse robots, quantum and classical.

    \b
    Examples:
      qrobot solve examples/small-warehouse.json --picture plan.svg
      qrobot solve orders.csv --layout layout.json --deadline 5 --output plan.json
      qrobot check plan.json examples/small-warehouse.json
      qrobot picklist plan.json examples/small-warehouse.json -o picks.html --paper a5
      qrobot bench instances/ --backends auto,pyvrp --deadline 10 --seeds 3

    Exit codes: 0 done, 1 infeasible or unhealthy, 2 bad input, 3 a backend failed.
    """
    del debug  # taken out by `main`, which must know it whatever the command does


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its code; users see sentences, not tracebacks."""
    prepare()
    words = sys.argv[1:] if arguments is None else arguments
    debug = "--debug" in words  # wherever it stands
    words = [word for word in words if word != "--debug"]
    try:
        code: Any = cli.main(args=words, prog_name="qrobot", standalone_mode=False, obj=debug)
    except click.exceptions.Exit as done:
        code = done.exit_code
    except SystemExit as done:  # a command that tells its own code
        code = done.code
    except click.ClickException as error:
        page = io.StringIO()
        error.show(page)
        say(page.getvalue(), err=True, end="")
        code = 2
    except (click.Abort, KeyboardInterrupt):
        say("qrobot: interrupted", err=True)
        code = 130
    except QRobotError as error:
        code = _tell(str(error), error, error.exit_code, debug)
    except OSError as error:
        where = f" ({error.filename})" if error.filename else ""
        code = _tell(f"{error.strerror or error}{where}", error, 2, debug)
    except MemoryError as error:
        code = _tell("out of memory; plan a smaller instance", error, 3, debug)
    except Exception as error:
        text = f"internal error: {type(error).__name__}: {error}; show more with --debug"
        code = _tell(text, error, 3, debug)
    sys.exit(code if isinstance(code, int) else 0)


@contextmanager
def quiet_libraries(debug: bool) -> Iterator[None]:
    """Keep warnings and log lines of libraries from users, who can do nothing about them.

    ``--debug``, ``python -W`` and ``PYTHONWARNINGS`` show them. Filters would not do: libraries
    add some of their own.
    """
    if debug or sys.warnoptions:
        yield
        return
    import logging  # not at the top: `--help` must be fast

    handler = logging.lastResort
    with warnings.catch_warnings():
        warnings.showwarning = lambda *_, **__: None
        logging.lastResort = None
        try:
            yield
        finally:
            logging.lastResort = handler


def _tell(text: str, error: BaseException, code: int, debug: bool) -> int:
    if debug:
        import traceback

        from qrobot.jobs.redaction import redact

        # The chain of an error may quote a service, and a service may quote a token.
        say(redact("".join(traceback.format_exception(error))), err=True, end="")
    say(f"qrobot: {' '.join(text.split())}", err=True)
    return code
