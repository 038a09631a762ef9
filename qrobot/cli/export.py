"""``qrobot export``: the model of an instance as a file for other programs."""

from __future__ import annotations

import click

from qrobot.cli.options import FILE, Robots
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("export")
@click.argument("instance", type=FILE)
@click.argument("output", type=FILE)
@click.option(
    "--encoding",
    help="full, reduced or (not in an LP) compact.  [default: reduced in an LP, else compact]",
)
@click.option(
    "--slack",
    help="exact or paper.  [default: none in an LP (an inequality), else exact]",
)
@click.option("--layout", type=FILE, help="Layout and robots of CSV orders.")
@click.option("--robots", type=Robots(), help="Another number of robots, or 'free'.")
@click.option("--capacity", help="Another capacity of every robot.")
@click.option("--split-orders", is_flag=True, help="Let each item stand alone, as in the paper.")
@click.option("--json", "as_json", is_flag=True, help="Print what was written as JSON.")
def command(
    instance: str,
    output: str,
    encoding: str | None,
    slack: str | None,
    layout: str | None,
    robots: int | str | None,
    capacity: str | None,
    split_orders: bool,
    as_json: bool,
) -> None:
    """Write the model of an instance as a file for other programs.

    The ending of OUTPUT chooses: .lp is the constrained model in CPLEX's format (made by
    docplex; extra docplex), .bqm.json the penalty form as dimod writes it, .coo the same as
    lines of coordinates.

    \b
    Examples:
      qrobot export examples/paper-7-items.json picking.lp
      qrobot export examples/paper-4-items.json picking.lp --encoding full --slack paper
      qrobot export examples/small-warehouse.json picking.bqm.json --json
      qrobot export orders.csv picking.coo --layout layout.json --robots 2
    """
    if output.lower().endswith(".lp"):
        # Before the models, which import dimod: what is absent is told at once.
        from qrobot.errors import MissingExtraError

        try:
            import docplex  # noqa: F401
        except ImportError:
            raise MissingExtraError("an LP file", "docplex") from None

    from qrobot.models.export import export_model, format_of
    from qrobot.problem.formats import read
    from qrobot.report.outputs import check_outputs

    format_of(output)
    check_outputs([output], [instance, *([layout] if layout else [])])
    question = read(
        instance, layout=layout, robots=robots, capacity=capacity, split_orders=split_orders
    )
    report = {"path": output} | export_model(question, output, encoding, slack)
    if as_json:
        say_json(report)
        return
    held = f", {report['constraints']} constraints" if report["constraints"] else ""
    say(
        f"written: {output} ({report['encoding']}: {report['variables']} variables, "
        f"{report['couplings']} couplings{held})"
    )
