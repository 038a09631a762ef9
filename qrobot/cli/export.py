"""``qrobot export``: the model of an instance as a file for other programs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import click

from qrobot.cli.options import FILE, Question, ReadingCommand, reading_options, written
from qrobot.cli.streams import say, say_json

__all__ = ["command"]


@click.command("export", cls=ReadingCommand)
@click.argument("instance", type=FILE)
@click.argument("output", type=FILE, required=False)
@click.option(
    "--encoding",
    help="full, reduced or (not in an LP) compact.  [default: reduced in an LP, else compact]",
)
@click.option(
    "--slack",
    help="exact or paper.  [default: none in an LP (an inequality), else exact]",
)
@click.option(
    "--penalties",
    type=click.Choice(["safe", "measured"]),
    default="safe",
    show_default=True,
    help="safe: the lowest energy is the best plan; measured: what annealers sample best, "
    "without that proof. Not for an LP.",
)
@written("--circuit", help="Write a circuit whose reads are all plans, as OpenQASM 3.")
@click.option(
    "--mixer",
    default="swap",
    show_default=True,
    help="Mixer of the circuit: swap, swap-all or grover.",
)
@click.option("--layers", type=int, default=1, show_default=True, help="Layers of the circuit.")
@reading_options
@click.option("--json", "as_json", is_flag=True, help="Print what was written as JSON.")
def command(
    question: Question,
    output: str | None,
    encoding: str | None,
    slack: str | None,
    penalties: str,
    circuit: str | None,
    mixer: str,
    layers: int,
    as_json: bool,
) -> None:
    """Write the model of an instance as a file for other programs.

    The ending of OUTPUT chooses: .lp is the constrained model in CPLEX's format (made by
    docplex; extra docplex), .bqm.json or .bqm the penalty form as dimod reads it, .coo the same
    as lines of coordinates. --circuit writes a gate-model circuit of a small instance whose
    measurements are plans, with its angles searched.

    \b
    Examples:
      qrobot export examples/paper-7-items.json picking.lp
      qrobot export examples/paper-4-items.json picking.lp --encoding full --slack paper
      qrobot export examples/small-warehouse.json picking.bqm.json --json
      qrobot export orders.csv picking.coo --layout layout.json --robots 2
      qrobot export examples/paper-4-items.json --robots 1 --capacity 45 --circuit plan.qasm
    """
    outputs = [path for path in (output, circuit) if path is not None]
    if not outputs:
        raise click.UsageError("name the file to write: OUTPUT, --circuit FILE, or both")
    if output is not None and output.lower().endswith(".lp"):
        # Before the models, which import dimod: a missing package is reported at once.
        from qrobot._extras import load

        load("docplex", "an LP file")

    from qrobot._files import check_outputs

    if output is not None:
        from qrobot.models.export import format_of

        format_of(output)
    check_outputs(outputs, question.files)
    instance = question.read()
    report: dict[str, Any] = {}
    if output is not None:
        from qrobot.models.export import export_model

        report = {"path": output} | export_model(instance, output, encoding, slack, penalties)
    if circuit is not None:
        from qrobot.backends.gate.constrained import export_circuit

        report["circuit"] = {"path": circuit} | export_circuit(instance, circuit, mixer, layers)
    if as_json:
        say_json(report)
        return
    for line in _lines(report):
        say(line)


def _lines(report: dict[str, Any]) -> Iterator[str]:
    """Yield what is said about the written files."""
    if "path" in report:
        held = f", {report['constraints']} constraints" if report["constraints"] else ""
        yield (
            f"written: {report['path']} ({report['encoding']}: {report['variables']} variables, "
            f"{report['couplings']} couplings{held})"
        )
        yield (
            "The lowest energy of this model is the best plan."
            if report["ground_state_is_plan"]
            else "The lowest energy of this model need not be a plan: --penalties safe with "
            "--slack exact proves it."
        )
        if not report["offset_in_file"]:
            yield (
                f"Energies read from it lack the constant {report['offset']:.12g}, which "
                "coordinates have no place for; .bqm.json and .bqm keep it."
            )
    if (made := report.get("circuit")) is not None:
        yield (
            f"written: {made['path']} ({made['qubits']} qubits, {made['gates']} gates, "
            f"{made['two_qubit_gates']} of them on two qubits, depth {made['depth']})"
        )
        yield (
            f"Every measurement is one of {made['plans']} plans, the best one with probability "
            f"{made['optimum_probability']:.3g} (a random plan: "
            f"{made['random_plan_probability']:.3g})."
        )
