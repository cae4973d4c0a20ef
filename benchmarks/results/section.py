"""A section of the results: what was measured, by which command, as a table."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Section:
    """A table with a title, the command that makes it, and what to mind when reading it."""

    title: str
    command: str
    note: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        """The section as Markdown."""
        lines = [f"## {self.title}", "", f"`{self.command}`", "", self.note, ""]
        lines += [_line(self.head), "|" + "---|" * len(self.head), *(_line(row) for row in self.rows)]
        return "\n".join(lines) + "\n"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
