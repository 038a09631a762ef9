"""PennyLane: lightning.qubit and any other device."""
