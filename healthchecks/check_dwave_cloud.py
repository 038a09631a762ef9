# %% [markdown]
# # D-Wave's cloud client: what goes over the wire
#
# Before a problem reaches the QPU it is packed: every number of every working qubit, in the
# machine's own sequence, as raw bytes in base64. The answer comes back as packed bits. The client
# does both. This notebook sends nothing; it looks into the envelope.

# %%
import base64
import struct
from types import SimpleNamespace

from dwave.cloud.coders import encode_problem_as_qp

from qrobot.health.checks.dwave_cloud import CHECK, COUPLERS, LINEAR, QUADRATIC, QUBITS
from qrobot.health.lesson import table, verdict

solver = SimpleNamespace(_encoding_qubits=QUBITS, _encoding_couplers=COUPLERS)
sent = encode_problem_as_qp(solver, LINEAR, QUADRATIC)
print(sent)

# %% [markdown]
# ## Reading it with the standard library
#
# `lin` holds one double of eight bytes for each qubit that works. Qubit 3 and 6 are missing: real
# chips have a few dead ones. A qubit that the problem does not use is sent as *nan*, not as zero: a
# zero would mean "use it, without a field".

# %%
raw = base64.b64decode(sent["lin"])
numbers = struct.unpack(f"<{len(raw) // 8}d", raw)
table(
    ["qubit", "sent", "in the problem"],
    [(q, n, LINEAR.get(q, "not used")) for q, n in zip(QUBITS, numbers, strict=True)],
)

# %% [markdown]
# `quad` holds the couplers between used qubits only, in the solver's sequence.
#
# ## The check
#
# The numbers that are sent (99 stands for nan), then an answer that we pack ourselves, bit by bit,
# and let the client read: energies, how often each state came, and the spins.

# %%
verdict(CHECK, [f"qubit {q}" for q in QUBITS])

# %% [markdown]
# ## Try it yourself
#
# 1. How many bytes does a full problem on a machine of 5,600 qubits and 40,000 couplers take?
# 2. Why is one bit a spin enough for the answer, and what must the reader know to use it?
