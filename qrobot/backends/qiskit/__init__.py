"""Qiskit: statevector, Aer and IBM Quantum."""
