"""A table as it is read: written cells with the reason of what is missing, and the same as Markdown and LaTeX."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from dashboard.numbers import MINUS, MISSING

_LATEX: Final = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "±": r"$\pm$",
    "°": r"$^\circ$",
    "\u2032": r"$'$",
    "\u2033": r"$''$",
    "σ": r"$\sigma$",
    "β": r"$\beta$",
    "χ": r"$\chi$",
    "²": r"$^2$",
    "Δ": r"$\Delta$",
    "‰": r"\textperthousand{}",
    "\u202f": r"\,",
    MINUS: "$-$",
}


@dataclass(frozen=True, slots=True)
class Shown:
    """A cell: its text, and in ``why`` the reason where it is ``--``, or a remark on it."""

    text: str
    why: str | None = None


@dataclass(frozen=True, slots=True)
class Head:
    """A column: its title, whether it holds numbers, and what it means."""

    title: str
    is_number: bool = True
    means: str | None = None


@dataclass(frozen=True, slots=True)
class Line:
    """A row. ``instead`` is a sentence that stands in the place of all cells but the first.

    ``kind`` is empty, ``marked`` for the row that counts, ``mean`` for one that sums up others, ``gone`` for one
    without a result.
    """

    cells: Sequence[Shown]
    kind: str = ""
    instead: str | None = None


@dataclass(frozen=True, slots=True)
class Sheet:
    """A table to look at or to copy."""

    caption: str
    head: Sequence[Head]
    lines: Sequence[Line]

    def as_markdown(self) -> str:
        """The table in the Markdown of GitHub."""
        rule = "|".join("---:" if column.is_number else "---" for column in self.head)
        rows = [
            "| " + " | ".join(_in_markdown(text) for text in row) + " |"
            for row in (self._titles(), *self._texts())
        ]
        return "\n".join([rows[0], f"|{rule}|", *rows[1:], "", f"{_in_markdown(self.caption)}.", ""])

    def as_latex(self) -> str:
        """The table as a ``table`` with booktabs' rules."""
        columns = "".join("r" if column.is_number else "l" for column in self.head)
        rows = [
            " & ".join(_in_latex(text) for text in row) + r" \\" for row in (self._titles(), *self._texts())
        ]
        lines = [
            r"\begin{table}",
            rf"\caption{{{_in_latex(self.caption)}.}}",
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            rows[0],
            r"\midrule",
            *rows[1:],
            r"\bottomrule",
            r"\end{tabular}",
            r"\end{table}",
            "",
        ]
        return "\n".join(lines)

    def _titles(self) -> list[str]:
        return [column.title for column in self.head]

    def _texts(self) -> list[list[str]]:
        return [
            [cell.text for cell in line.cells]
            if line.instead is None
            else [line.cells[0].text, line.instead, *[""] * (len(self.head) - 2)]
            for line in self.lines
        ]


def gap(why: str) -> Shown:
    """A cell without a value."""
    return Shown(MISSING, why)


def _in_markdown(text: str) -> str:
    flat = " ".join(text.split())
    for sign in "\\`*_{}[]<>|":
        flat = flat.replace(sign, f"\\{sign}")
    return flat


def _in_latex(text: str) -> str:
    # an accent or a letter of another script is for the engine, as xelatex
    return "".join(_LATEX.get(sign, sign) for sign in " ".join(text.split())).replace("--", "{-}{-}")
