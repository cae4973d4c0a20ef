"""``tiltwatch figures``: figures 3 to 6 of the paper from a workspace."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, note
from storage.errors import StorageError, UsageError

if TYPE_CHECKING:
    from dashboard.paper_figures import Subject
    from storage.workspace import Workspace
    from tasks.settings import Campaign

ALL = "all"


def figures(  # noqa: PLR0913 (options of a command)
    file: CampaignFile,
    /,
    *,
    epoch: str | None = None,
    figure: str = ALL,
    file_format: Annotated[str, Parameter(name="--format")] = "png",
    out: Path | None = None,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Draw figures 3 to 6 of the paper: stations and clouds, shaft, contours and axes of the schemes.

    The same results give the same bytes. Points that are not in the workspace any more are said to be missing.

    Parameters
    ----------
    epoch
        Epoch to draw; the newest with points on the shaft where none is named.
    figure
        3 (stations and their clouds), 4 (shaft, raw and isolated), 5 (contours of each scheme), 6 (axis of each scheme)
        or all.
    file_format
        png or svg.
    out
        Folder for the figures; figures/STRUCTURE/EPOCH in the workspace where none is named.
    """
    from dashboard.paper_figures import draw_figure, figure_names
    from storage.named_files import write_named_file
    from storage.upgrade import ready_workspace

    campaign = load_with_workspace(file, workspace)
    numbers = _numbers(figure, list(figure_names()))
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    subject = _subject(place, campaign, epoch)
    folder = out or place.root / "figures" / campaign.structure.id / subject.epoch.epoch
    written = []
    for number in numbers:
        target = folder.expanduser().absolute() / f"{figure_names()[number]}.{file_format}"
        write_named_file(target, draw_figure(place, subject, number, file_format))
        written.append(target)
        if not as_json:
            note(f"wrote {target}")
    if as_json:
        return answer(0, {"epoch": subject.epoch.epoch, "figures": [str(target) for target in written]})
    return 0


def _numbers(wanted: str, known: list[int]) -> list[int]:
    if wanted == ALL:
        return known
    if wanted not in map(str, known):
        raise UsageError(f"unknown figure {wanted!r}; known: {', '.join(map(str, known))}, {ALL}")
    return [int(wanted)]


def _subject(place: "Workspace", campaign: "Campaign", epoch: str | None) -> "Subject":
    """The epoch that was asked for, else the newest that has points on the shaft."""
    from dashboard.paper_figures import Subject
    from storage.views import epoch_rows

    rows = epoch_rows(place, campaign.structure.id)
    known = [row.epoch for row in rows]
    if epoch is not None and epoch not in known:
        raise UsageError(f"unknown epoch {epoch!r}; in the workspace: {', '.join(known) or 'none'}")
    fit = [row for row in rows if (row.n_points_used > 0 if epoch is None else row.epoch == epoch)]
    if not fit:
        raise StorageError(
            f"no epoch of {campaign.structure.id} in {place.root} has points on the shaft; `tiltwatch run FILE` processes "
            "what is missing"
        )
    primary = campaign.report.primary
    return Subject(fit[-1], campaign.structure.title, (primary[0], primary[1]))
