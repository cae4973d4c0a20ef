"""Words and options that several commands have."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

CampaignFile = Annotated[Path, Parameter(name="FILE", help="campaign file (TOML)")]

AsJson = Annotated[
    bool, Parameter(name="--json", negative="", show_default=False, help="one JSON object on stdout")
]

WorkspaceFolder = Annotated[
    Path | None,
    Parameter(name="--workspace", help="folder of the results; tiltwatch-data/ beside the campaign file"),
]

DEFAULT_WORKSPACE = "tiltwatch-data"


def workspace_of(folder: Path, wanted: Path | None) -> Path:
    """Return the workspace that the user wants, or the one beside the campaign file."""
    return wanted if wanted is not None else folder / DEFAULT_WORKSPACE
