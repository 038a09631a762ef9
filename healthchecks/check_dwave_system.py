# %% [markdown]
# # D-Wave's Ocean: from a model to a QPU and back
#
# `dwave-system` is what stands between a model and the machine: it embeds, sends, waits, and puts
# the chains together again. This check needs no account: `MockDWaveSampler` has the graph and the
# interface of a QPU, and a classical heuristic inside. What is tested is the whole way there and
# back, not physics.

# %%
import dimod
from dwave.embedding import embed_bqm
from dwave.system import EmbeddingComposite
from dwave.system.testing import MockDWaveSampler

from qrobot.health import known
from qrobot.health.checks.dwave_system import CHECK
from qrobot.health.lesson import table, verdict

model = dimod.BinaryQuadraticModel(dict(enumerate(known.FIELDS)), known.COUPLINGS, 0.0, "SPIN")
device = MockDWaveSampler(topology_type="pegasus", topology_shape=[2])
print(len(device.nodelist), "qubits,", len(device.edgelist), "couplers")

# %% [markdown]
# ## There
#
# Eight variables, most of them coupled with all others, become chains of qubits. Inside a chain a
# strong coupling $-|J_c| s_a s_b$ rewards agreement.

# %%
found = EmbeddingComposite(device).sample(model, num_reads=5, return_embedding=True)
chains = found.info["embedding_context"]["embedding"]
on_chip = embed_bqm(model, chains, device.adjacency, chain_strength=10)
table(["variable", "qubits"], [(k, str(tuple(chains[k]))) for k in sorted(chains)])
print(model.num_variables, "variables became", on_chip.num_variables, "qubits;")
print(model.num_interactions, "couplings became", on_chip.num_interactions, "with the chains'")

# %% [markdown]
# ## And back
#
# A read gives a value to each qubit. Where a chain disagrees with itself the majority is taken and
# the share of broken chains is reported:

# %%
table(
    ["energy", "broken chains", "reads"],
    [
        (float(row.energy), float(row.chain_break_fraction), int(row.num_occurrences))
        for row in found.data()
    ],
)
device.close()

# %% [markdown]
# ## The check
#
# All 200 reads must come back, and every energy must be that of its state by the definition (the
# largest error is shown). Right energies alone prove little: Ocean works them out from the model
# that we gave, whatever it sent to the machine. Had it sent the opposite of every coupling, all
# energies would still be right and all states bad. So the best read must be the ground state. A
# heuristic promises no optimum, but this small model is solved in about one read of six here, and
# that none of 200 hits is out of the question.

# %%
verdict(CHECK, ["reads", "largest error of an energy", "lowest energy"])

# %% [markdown]
# ## Try it yourself
#
# 1. Sample with `chain_strength=0.1`, then 1000. What happens to the broken chains, and to the
#    energies?
# 2. The same with the real machine is one name: `DWaveSampler()`. What does `docs/remote.md` ask
#    for first?
