"""How well tiltwatch tells real movement from noise: simulated series of epochs.

`.venv/bin/python -m benchmarks.change COMMAND --help` for each command; each prints Markdown tables.
"""

import importlib
import pkgutil
import sys
from pathlib import Path


def commands() -> dict[str, str]:
    """Modules of this package that have a ``main``, with the first line of what they say of themselves."""
    names = [module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])]
    found = {
        name: importlib.import_module(f"benchmarks.change.{name}") for name in names if name != "__main__"
    }
    return {
        name: (module.__doc__ or "").splitlines()[0]
        for name, module in found.items()
        if hasattr(module, "main")
    }


def main() -> None:
    """Hand the arguments to the command."""
    known = commands()
    if len(sys.argv) < 2 or sys.argv[1] not in known:
        listed = "\n".join(f"{name:16} {line}" for name, line in known.items())
        raise SystemExit(f"{__doc__}\n{listed}")
    importlib.import_module(f"benchmarks.change.{sys.argv[1]}").main(sys.argv[2:])


if __name__ == "__main__":
    main()
