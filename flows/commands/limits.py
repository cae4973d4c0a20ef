"""``tiltwatch limits``: the tables of limits, with their papers."""
# ruff: noqa: PLC0415 (imports stand where they are needed: a start must be quick)

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson
from flows.terminal import answer, say
from storage.errors import UsageError


def limits(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    height_m: Annotated[float | None, Parameter(name="--height-m")] = None,
    file: Annotated[Path | None, Parameter(name="--file")] = None,
    as_json: AsJson = False,
) -> int:
    """List the tables of limits with their papers, and what they allow at a height.

    Of each: rule, heights it holds for, kind, document, source, and who compared it with the document.

    Parameters
    ----------
    name
        Only the table of that name.
    height_m
        Say what each allows at this height above the base, metres.
    file
        List the tables of this file of limits (TOML) instead of the shipped ones.
    """
    from flows.limit_text import limit_facts, limit_lines
    from tasks.limit_choice import own_tables
    from tasks.limits import TABLES
    from tasks.settings.limit_file import load_limits

    if height_m is not None and not 0.0 < height_m < float("inf"):
        raise UsageError(f"--height-m needs a height above 0, got {height_m:g}")
    tables = list(own_tables(load_limits(file))) if file is not None else list(TABLES.values())
    chosen = [table for table in tables if name in (None, table.name)]
    if not chosen:
        known = ", ".join(dict.fromkeys(table.name for table in tables))
        raise UsageError(f"unknown table of limits {name!r}; known: {known}")
    if as_json:
        return answer(0, {"limits": [asdict(limit_facts(table, height_m)) for table in chosen]})
    for number, table in enumerate(chosen):
        say(*([""] if number else []), *limit_lines(limit_facts(table, height_m)))
    return 0
