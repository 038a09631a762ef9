"""Options that several commands share."""

from __future__ import annotations

import copy
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, cast

import click

from qrobot._formats import known_formats
from qrobot._json import json_text
from qrobot.errors import InputError

if TYPE_CHECKING:
    from qrobot.problem import Instance

__all__ = [
    "FILE",
    "Question",
    "ReadingCommand",
    "Robots",
    "Setting",
    "objective",
    "reading_options",
    "reading_options_of_plan",
    "rounding",
    "settings_of",
    "written",
]

Function = TypeVar("Function", bound=Callable[..., Any])

FILE = click.Path(readable=False)
"""A path; who may not read it is told by whoever reads, with the advice."""


objective = click.option(
    "--objective",
    default="distance",
    show_default=True,
    help="What shall be small: distance; time (seconds that all robots work); makespan (until the "
    "last is back); lateness (after due times); trips; robots; or a sum: distance=1,makespan=2.",
)


class ReadingCommand(click.Command):
    """A command that reads instances; the table of formats tells its help which there are.

    ``{formats}`` and ``{suffixes}`` stand for all of them, ``{layout}`` and its like for those
    with that option.
    """

    def format_help(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help with the formats put in."""
        known = known_formats()
        words = {
            "{formats}": ", ".join(f"{suffix} ({name})" for suffix, name, _ in known),
            "{suffixes}": ", ".join(dict.fromkeys(suffix for suffix, *_ in known)),
        }
        for option in {option for *_, options in known for option in options}:
            words[f"{{{option}}}"] = ", ".join(x for x, _, options in known if option in options)
        filled = copy.copy(self)
        filled.params = [copy.copy(param) for param in self.params]
        for part in (filled, *filled.params):
            if text := getattr(part, "help", None):
                for word, meaning in words.items():
                    text = text.replace(word, meaning)
                vars(part)["help"] = text
        click.Command.format_help(filled, ctx, formatter)


def _names(_ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name.strip() for text in value for name in text.split(",") if name.strip())


def _mapping(
    _ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]
) -> dict[str, list[str]]:
    """Return what the files call our columns, of texts such as ``order=OrderNo,place=BIN``."""
    found: dict[str, list[str]] = {}
    for part in (part for text in value for part in text.split(",") if part.strip()):
        ours, equals, theirs = map(str.strip, part.partition("="))
        if not (ours and equals and theirs):
            raise InputError(
                f"{part.strip()!r:.60} maps nothing",
                field="--columns",
                advice="write it as order=OrderNo: our name, and the one in the header",
            )
        found.setdefault(ours.lower(), []).append(theirs)
    return found


rounding = click.option(
    "--rounding", help="Rounding of {rounding} distances: none, nearest, up or down."
)


class Robots(click.ParamType[int | str]):
    """A number of robots, or ``free`` for as many as wanted."""

    name = "N|free"

    def convert(
        self, value: str | int, param: click.Parameter | None, _ctx: click.Context | None
    ) -> int | str:
        """Return the number or ``free``, however it is written."""
        text = str(value).strip()
        if text.lower() == "free":
            return "free"
        if re.fullmatch(r"[-+]?[0-9]{1,12}", text):
            return int(text)
        what = param.name if param is not None else "robots"
        raise InputError(
            f"{value!r:.40} is not a number of {what}",
            field=f"--{what}",
            advice="give 1 or more, or 'free'",
        )


@dataclass(frozen=True, slots=True)
class Question:
    """The file of an instance, and the options that say how it is read."""

    path: str
    options: dict[str, Any]

    @property
    def files(self) -> list[str]:
        """All files that are read."""
        beside = (self.options[name] for name in ("layout", "locations", "articles"))
        return [path for path in (self.path, *beside) if path]

    def read(self) -> Instance:
        """Return the instance."""
        from qrobot.problem.formats import read

        return read(self.path, **self.options)


def _reading_options(
    robots: str, capacity: str, trips: str, split_orders: str
) -> Callable[[Function], Function]:
    """Return what adds the options of reading an instance, and hands them over as a `Question`.

    Parameters
    ----------
    robots, capacity, trips, split_orders
        The help of these options.
    """
    options = {
        "layout": click.option("--layout", type=FILE, help="Layout and robots of {layout} orders."),
        "locations": click.option(
            "--locations", type=FILE, help="Where the bins of {locations} orders are, by labels."
        ),
        "articles": click.option(
            "--articles", type=FILE, help="What the articles of {articles} orders weigh."
        ),
        "columns": click.option(
            "--columns",
            metavar="OURS=THEIRS,..",
            multiple=True,
            callback=_mapping,
            help="What {columns} files call our columns: order=OrderNo,article=SKU. Repeatable.",
        ),
        "ignore_columns": click.option(
            "--ignore-columns",
            multiple=True,
            callback=_names,
            help="Columns of {ignore_columns} orders to ignore, separated by commas; '*': all "
            "that are not known.",
        ),
        "sheet": click.option(
            "--sheet", metavar="NAME", help="The sheet of an .xlsx that has the orders."
        ),
        "rounding": rounding,
        "robots": click.option("--robots", type=Robots(), help=robots),
        "capacity": click.option("--capacity", help=capacity),
        "trips": click.option("--trips", type=Robots(), help=trips),
        "split_orders": click.option("--split-orders", is_flag=True, help=split_orders),
    }

    def add(function: Function) -> Function:
        @wraps(function)
        def command(instance: str, **given: Any) -> Any:
            reading = {name: given.pop(name) for name in options}
            return function(question=Question(instance, reading), **given)

        for option in reversed(options.values()):
            command = option(command)
        return cast("Function", command)

    return add


reading_options = _reading_options(
    "The first N robots (or more like them), or 'free': no limit.",
    "Capacity of every robot instead of the file's.",
    "The most trips of every robot instead of the file's, or 'free': no limit.",
    "Make each item an order of its own, as in the paper.",
)
"""Options of a command that plans."""

reading_options_of_plan = _reading_options(
    "The number of robots that the plan was made with.",
    "The capacity that the plan was made with.",
    "The most trips that the plan was made with.",
    "The orders were allowed to be split.",
)
"""Options of a command that reads a plan and its question."""


def written(*names: str, **more: Any) -> Callable[[Function], Function]:
    """Return an option that names a file to write, and refuses a second one.

    Of an option that is given twice, click would pass over the first: a file that was asked for
    would not be written, without a word.
    """

    def only(
        _ctx: click.Context, param: click.Parameter, paths: tuple[str, ...] | None
    ) -> str | None:
        if paths and len(paths) > 1:
            raise InputError(
                f"is given {len(paths)} times ({', '.join(paths)})",
                field=max(param.opts, key=len),
                advice="give one file",
            )
        return paths[0] if paths else None

    return click.option(*names, type=FILE, multiple=True, callback=only, **more)


OWN_FLAGS = {
    **{
        name: f"use --{name}"
        for name in ("backend", "control", "deadline", "fallback", "objective", "routing", "seed")
    },
    "max_cost": "use --max-cost",
    "max_work": "use --max-work",
    "dry_run": "use --dry-run",
    "wait": "use --no-wait",
    **dict.fromkeys(
        ("instance", "stop", "on_progress", "interrupt_function", "context"), "leave it out"
    ),
}
"""What is set in another way, or not from a command line at all."""


class Setting(click.ParamType[tuple[str, Any]]):
    """An option of a sampler: ``name=value``, the value as JSON or else as text."""

    name = "NAME=VALUE"

    def convert(
        self,
        value: str | tuple[str, Any],
        _param: click.Parameter | None,
        _ctx: click.Context | None,
    ) -> tuple[str, Any]:
        """Return the name and the value."""
        if isinstance(value, tuple):
            return value
        name, equals, text = value.partition("=")
        if not (equals and name.isidentifier()):
            raise InputError(
                f"{value!r} sets nothing", field="--option", advice="write it as name=value"
            )
        if name in OWN_FLAGS:
            raise InputError(
                f"{name} is not an option of a sampler here",
                field="--option",
                advice=OWN_FLAGS[name],
            )
        return name, _value(name, text)


def _value(name: str, text: str) -> Any:
    """Return a value as JSON has it, else the text itself."""

    def refuse(constant: str) -> NoReturn:
        raise InputError(
            f"{constant} is not a finite number", field=name, advice="give a plain number"
        )

    def number(digits: str) -> float:
        found = float(digits)
        return found if math.isfinite(found) else refuse(digits)

    try:
        return json.loads(text, parse_constant=refuse, parse_float=number)
    except InputError:
        raise
    except (ValueError, RecursionError):
        return text


def settings_of(flags: dict[str, Any], settings: tuple[tuple[str, Any], ...]) -> dict[str, Any]:
    """Return the options of a sampler: those with a flag of their own, and ``--option``.

    Parameters
    ----------
    flags
        Name of the option to the flag and its value, which is ``None`` when it was not given.
    settings
        As `Setting` gives them.

    Raises
    ------
    InputError
        When an option gets two different values.
    """
    found: dict[str, tuple[str, Any]] = {
        name: given for name, given in flags.items() if given[1] is not None
    }
    for name, value in settings:
        flag = f"-O {name}"
        before, other = found.setdefault(name, (flag, value))
        if other != value:
            raise InputError(
                f"{flag}={_shown(value)} contradicts {before}{'=' if before == flag else ' '}"
                f"{_shown(other)}",
                field="--option",
                advice="give one of them",
            )
    return {name: value for name, (_, value) in found.items()}


def _shown(value: Any) -> str:
    return value if isinstance(value, str) else json_text(value)
