# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # From orders to a quantum model to a plan
#
# One small question, taken the whole way: a list of orders, the QUBO (quadratic unconstrained
# binary optimisation) that asks for the shortest tour, an annealer, a variational quantum
# eigensolver (VQE), and at the end a plan that an independent checker accepts.
#
# `make tutorial` runs this file as a notebook; `python examples/tutorial.py` runs it as it is.
# It needs the profile `edge` (or the extra `qiskit`), no account and no network.

# %%
from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import qrobot

try:
    EXAMPLES = Path(__file__).parent  # as a script
except NameError:
    EXAMPLES = Path("examples")  # as a notebook, which `make tutorial` runs in the project
folder = Path(tempfile.mkdtemp(prefix="qrobot-tutorial-"))


def show(path: Path) -> None:
    """Show a picture in a notebook; a script only says where it is."""
    try:
        from IPython import get_ipython
        from IPython.display import Image, display
    except ImportError:
        get_ipython = None
    if get_ipython is not None and get_ipython() is not None:
        display(Image(filename=str(path), width=560))
    else:
        print("picture:", path)


# %% [markdown]
# ## 1. Orders
#
# Four items of the paper's figure 4, with its weights 8, 8, 3 and 3 and its capacity of 45. The
# paper gives no places: ours are drawn with a fixed seed. Everything together weighs 22, so one
# robot can carry it all; as long as ways are metric, one robot is then always best.

# %%
instance = qrobot.read(EXAMPLES / "paper-4-items-m45.json").with_robots(1)
for item in instance.items:
    print(item.id, "weighs", float(item.weight), "at", item.place)
print(instance.distances.round(1))

# %% [markdown]
# ## 2. The answer to compare with
#
# Four items have 4! = 24 sequences: the exact planner proves the best. Whatever a quantum method
# finds later is compared with this.

# %%
exact = qrobot.solve(instance, backend="exact")
print(exact.summary())
assert exact.is_optimal

# %% [markdown]
# ## 3. The QUBO
#
# A binary variable says "item i is collected at step t". The energy of an assignment is its
# distance where it is a tour; what is not a tour pays penalties. Two encodings of the same
# question:
#
# - `reduced` is the paper's (its tables 2 and 3): the depot is a place to be at, too, and slack
#   bits hold the capacity. Its qubit counts are the paper's.
# - `compact` knows that a tour visits one item a step: n² variables for one robot.

# %%
from qrobot.models import build_model

paper = build_model(instance, encoding="reduced", slack="paper")
model = build_model(instance, encoding="compact")
print("reduced:", paper.num_variables, "qubits; compact:", model.num_variables)
print("penalties:", model.penalties)

# %% [markdown]
# A plan goes in and comes back, and its energy is its distance:

# %%
route = exact.plan.to_dict()["trips"][0]["stops"]
print("the best sequence:", route)
nodes = [[item.id for item in instance.items].index(name) + 1 for name in route]
best = model.encode([nodes])
print("energy", model.bqm.energy(best), "distance", exact.cost)
assert abs(model.bqm.energy(best) - exact.cost) < 1e-9
print("decoded:", model.decode(best).routes)

# %% [markdown]
# How rare are tours? Of all 2^16 assignments only 24 are tours, and two of those are the best one
# (a tour has two directions). Random guessing needs tens of thousands of reads:

# %%
print("random:", 2 / 2**model.num_variables, "of all assignments are optimal")

# %% [markdown]
# ## 4. An annealer
#
# Simulated annealing on this machine: 100 reads. `control=True` lays as many random reads beside
# them. *Feasible* and *optimal* are counted on the raw reads: nothing is repaired before.

# %%
annealed = qrobot.solve(instance, backend="neal", encoding="compact", control=True, seed=1)
print(annealed.summary())
report = annealed.sampler
print(f"feasible {report.feasible_fraction:.0%}, optimal {report.optimal_fraction:.0%};")
print(f"random reads: feasible {report.random_feasible_fraction:.2%}")
assert report.optimal_fraction > 0

# %% [markdown]
# The same call with `backend="dwave-qpu"` runs on D-Wave's machine, with `--max-cost` and
# `--dry-run` before anything is billed. See `docs/remote.md`.
#
# ## 5. The same question in the gate model
#
# A quantum computer of gates sees the model as an Ising Hamiltonian: sums of Pauli Z. Mind the
# sign: here x = (1 - z) / 2, so that state |1> is x = 1, while dimod's spin is s = 2x - 1.

# %%
from qrobot.backends.qiskit.sampler import sparse_pauli_op

hamiltonian = sparse_pauli_op(model.bqm)
print(hamiltonian.num_qubits, "qubits,", len(hamiltonian), "terms")
index = sum(int(best[name]) << k for k, name in enumerate(model.variables))
energy = hamiltonian.to_matrix(sparse=True)[index, index].real
print("the Hamiltonian says", round(energy, 6), "for the best tour")
assert abs(energy - exact.cost) < 1e-6

# %% [markdown]
# ## 6. VQE
#
# A circuit of rotations and entangling gates, its angles searched so that the best twentieth of
# what is measured becomes short (the conditional value at risk, CVaR). Qiskit's Aer simulates the
# state exactly; the search is by full turns of one angle after another (NFT).

# %%
from qrobot.backends import get

found = get("qiskit-vqe").sample(model.bqm, num_reads=1000, starts=3, seed=0)
info = found.info
print(info["ansatz"], "ansatz,", len(info["parameters"]), "angles,", info["evaluations"], "runs")
chance = info["ground_probability_uniform"]
print(f"P(optimum) = {info['ground_probability']:.3f}, by chance {chance:.1e}")
assert info["ground_probability"] >= 10 * chance

feasible, lengths = model.decode_all(found)
reads = found.record.num_occurrences
share = reads[feasible].sum() / reads.sum()
print(f"raw reads: {share:.0%} feasible, best {lengths[feasible].min():.1f}")

# %% [markdown]
# The search, run by run: the objective falls as angle after angle is set.

# %%
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(6, 3.2))
axes.plot(np.minimum.accumulate(info["history"]), lw=1.5)
axes.axhline(exact.cost, color="grey", ls="--", label="proven optimum")
axes.set(xlabel="runs of the circuit", ylabel="best objective so far", yscale="log")
axes.legend()
figure.tight_layout()
figure.savefig(folder / "vqe.png", dpi=110)
plt.close(figure)
show(folder / "vqe.png")

# %% [markdown]
# ## 7. The plan
#
# `qrobot.solve` does all of this in one call: build, sample, decode, report what the sampler found
# by itself, and only then repair and polish; the checker has the last word.

# %%
result = qrobot.solve(
    instance,
    backend="qiskit-vqe",
    encoding="compact",
    initial_parameters=info["parameters"],  # resumed:
    evaluations=0,  # nothing is left to search
    deadline=60,
    seed=0,
)
print(result.summary())
assert qrobot.check(result.plan, instance).ok
assert result.cost <= exact.cost + 1e-9
result.save(folder / "plan.json")
qrobot.plot(result, folder / "plan.png")
show(folder / "plan.png")

# %% [markdown]
# ## What this shows, and what it does not
#
# - The models are right: energy is distance, on every stack.
# - The annealer and VQE find by themselves what random reads hardly ever find.
# - It is not a speed-up. The exact planner took milliseconds, and simulating a quantum computer
#   costs twice as much with every qubit. `qrobot reproduce all` puts the paper's tables beside
#   ours.
