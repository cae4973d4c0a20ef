"""Words and options that several commands have."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.terminal import note
from storage.errors import UsageError

if TYPE_CHECKING:
    from tasks.settings import Campaign

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


def load_with_workspace(file: Path, workspace: Path | None) -> "Campaign":
    """Read a campaign file together with the epochs that came into its workspace through an inbox.

    From then on the user is told for whom a command waits.

    Raises
    ------
    InputError
        If either is bad.
    """
    # a start for help must be quick
    from storage.locks import waiting_teller  # noqa: PLC0415
    from tasks.settings.intake import load_with_intake  # noqa: PLC0415

    waiting_teller.set(note)
    return load_with_intake(file, workspace_of(file.absolute().parent, workspace))


def check_epochs(campaign: "Campaign", names: Sequence[str]) -> None:
    """Refuse epochs that the campaign does not have.

    Raises
    ------
    UsageError
        With the known epochs.
    """
    known = [epoch.id for epoch in campaign.epochs]
    for name in names:
        if name not in known:
            raise UsageError(f"unknown epoch {name!r}; known: {', '.join(known)}")
