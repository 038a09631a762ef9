"""Say what the control of the emulated processor proves, and fail where it proves too little.

Usage: control.py CPU.json MAX.json     what instruction_probe.py said on both processors
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from instruction_probe import NOT_REFUSED


def judge(cpu: dict[str, str], largest: dict[str, str]) -> tuple[str, str]:
    """Return what is proven, and what is wrong; the latter is empty where the control holds."""
    refused = [name for name, said in cpu.items() if said == "refused"]
    executed = [name for name, said in cpu.items() if said == "executed"]
    told = f"refused, as on a Pi 4: {', '.join(refused)}\n"
    told += f"executed, though a Pi 4 refuses it, so not proven here: {', '.join(executed)}"
    blind = [name for name in executed if name not in NOT_REFUSED]
    dead = [name for name in refused if largest.get(name) != "executed"]
    unclear = [name for name, said in cpu.items() if said not in ("refused", "executed")]
    if blind:
        return told, f"the emulator executes {', '.join(blind)}: a wheel that needs it would pass"
    if dead:
        return (
            told,
            f"the largest processor refuses {', '.join(dead)} too: the control says nothing",
        )
    if unclear or not refused:
        return told, f"the control is unclear: {', '.join(unclear) or 'nothing was refused'}"
    return told, ""


def main() -> int:
    told, wrong = judge(*(json.loads(Path(name).read_text()) for name in sys.argv[1:3]))
    print(told)
    if wrong:
        print(wrong, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
