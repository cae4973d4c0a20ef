"""The file of results: a section each, with the machine it was measured on."""

import re
from pathlib import Path

from benchmarks.results.machine import machine_lines
from benchmarks.results.section import Section

HEAD = """# Results

Measured by `make bench`; every section says by which command, when, and on what. Compare ratios, not seconds, between
machines.
"""


def put_section(path: Path, name: str, section: Section) -> None:
    """Put a section into the file in place of the one of that name, or at its end."""
    marked = f"<!-- {name} -->\n{section.markdown()}\n" + "\n".join(machine_lines()) + f"\n<!-- /{name} -->\n"
    text = path.read_text(encoding="utf-8") if path.is_file() else HEAD
    old = re.compile(rf"<!-- {name} -->\n.*?<!-- /{name} -->\n", re.DOTALL)
    text = old.sub(lambda _found: marked, text) if old.search(text) else f"{text}\n{marked}"
    path.write_text(text, encoding="utf-8")
    print(section.markdown(), flush=True)
