"""Colours and lines of every drawing, on the web and on paper: colour-blind safe, with a word beside each."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

# Okabe & Ito 2008, told apart with every kind of colour vision
BLACK: Final = "#000000"
ORANGE: Final = "#E69F00"
SKY: Final = "#56B4E9"
GREEN: Final = "#009E73"
YELLOW: Final = "#F0E442"
BLUE: Final = "#0072B2"
VERMILION: Final = "#D55E00"
PURPLE: Final = "#CC79A7"

INK: Final = "#1c2430"
"""Text and lines that carry a value."""
SOFT: Final = "#5d6875"
"""Text beside it; 5.5 to 1 on white."""
FAINT: Final = "#c9d0d8"
"""Lines of a grid."""
PAPER: Final = "#ffffff"
NO_DATA: Final = "#e3e6ea"
"""Where nothing was measured."""

SCHEMES: Final[Mapping[str, str]] = {
    "S": INK,
    "A": BLUE,
    "B": SKY,
    "C": GREEN,
    "D": ORANGE,
    "E": PURPLE,
    "F": VERMILION,
}
"""A colour a scheme, the same on every drawing."""

OTHER_SCHEME: Final = "#7b6f58"

METHOD_MARKS: Final[Mapping[str, str]] = {"surface": "diamond", "robust": "circle", "paper": "square-open"}
"""Marks of methods, by their names in plotly."""

DIVERGING: Final = (
    (0.0, "#0b4a7f"),
    (0.25, "#6fa8d6"),
    (0.5, "#f7f7f7"),
    (0.75, "#e8a06a"),
    (1.0, "#a63d00"),
)
"""Inward is blue, outward is orange; lightness alone tells the size."""


@dataclass(frozen=True, slots=True)
class Tone:
    """How a state is shown: never by colour alone."""

    word: str
    icon: str
    ink: str
    ground: str


TONES: Final[Mapping[str, Tone]] = {
    "ok": Tone("OK", "✓", "#0b5d46", "#e2f3ec"),
    "alarm": Tone("ALARM", "▲", "#8c2f00", "#fde8dc"),
    "warning": Tone("WARNING", "◆", "#6b4d00", "#fdf3d3"),
    "quality": Tone("CANNOT TELL", "?", "#3d4752", "#e8ebee"),
    "missing": Tone("NO DATA", "–", "#3d4752", "#e8ebee"),
}
"""By the level of a condition, in small letters."""

NO_LIMIT: Final = Tone("NO LIMIT STATED", "–", "#3d4752", "#e8ebee")
""""Nothing was found", where nothing was asked for."""


VERDICTS: Final[Mapping[str, str]] = {
    "pass": "ok",
    "fail": "alarm",
    "cannot tell": "warning",
    "no limit": "missing",
}
"""The tone of each verdict of the view ``tilt``."""


def scheme_colour(scheme: str) -> str:
    """Return the colour of a scheme; those of users share one."""
    return SCHEMES.get(scheme, OTHER_SCHEME)
