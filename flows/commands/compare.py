"""``tiltwatch compare``: whether two epochs differ."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, check_epochs, workspace_of
from flows.terminal import answer, say
from storage.errors import StorageError, UsageError

if TYPE_CHECKING:
    from storage.views import ChangeRow
    from tasks.epoch_difference import ReferenceChange


def compare(
    file: CampaignFile,
    epoch: Annotated[str, Parameter(name="EPOCH")],
    reference: Annotated[str, Parameter(name="REFERENCE")],
    /,
    *,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Say for every scheme and method how far the top moved between two epochs.

    A change is significant where its probability without any movement is below 1 %. What others measured in both epochs
    stands below ours, by its source.

    Parameters
    ----------
    epoch
        The later epoch.
    reference
        The epoch to count from.
    """
    from storage.workspace import existing_workspace
    from tasks.epoch_difference import epoch_differences, reference_differences
    from tasks.settings import load_campaign

    campaign = load_campaign(file)
    check_epochs(campaign, (epoch, reference))
    if epoch == reference:
        raise UsageError(f"epoch {epoch!r} cannot be compared with itself; name two epochs")
    place = existing_workspace(workspace_of(campaign.folder, workspace))
    rows = epoch_differences(place, campaign.structure.id, epoch, reference)
    measured = reference_differences(place, campaign.structure.id, epoch, reference)
    if not rows and not measured:
        raise StorageError(
            f"no scheme has an axis in both {epoch} and {reference}; `tiltwatch run {file}` processes what is missing"
        )
    if as_json:
        facts = {"changes": [_facts(row) for row in rows], "references": [asdict(row) for row in measured]}
        return answer(0, {"primary": list(campaign.report.primary), **facts})
    height_m = rows[0].height_m if rows else measured[0].height_m
    say(f"{campaign.structure.title}: movement of the top at {height_m:g} m from {reference} to {epoch}")
    say(*(_line(row, campaign.report.primary) for row in rows), *(_measured_line(row) for row in measured))
    return 0


def _facts(row: "ChangeRow") -> dict[str, bool | float | str | None]:
    facts: dict[str, bool | float | str | None] = asdict(row)
    return {
        **facts,
        "epoch_time": row.epoch_time.isoformat(),
        "reference_time": row.reference_time.isoformat(),
    }


def _line(row: "ChangeRow", primary: tuple[str, str]) -> str:
    mark = "  <- primary" if (row.scheme, row.method) == tuple(primary) else ""
    return f"{row.scheme}/{row.method}: {_movement(row)}{mark}"


def _measured_line(row: "ReferenceChange") -> str:
    return f"{row.source} (reference): {_movement(row)}"


def _movement(row: "ChangeRow | ReferenceChange") -> str:
    from flows.condition_text import significance_text

    sigma = "uncertainty unknown" if row.sigma_top_m is None else f"± {2e3 * row.sigma_top_m:.2f} mm (k=2)"
    significance = significance_text(row.significant, row.p_value, row.smallest_detectable_m)
    return (
        f"{1e3 * row.d_top_m:.2f} {sigma}, east {1e3 * row.height_m * row.d_lean_east:+.2f} mm,"
        f" north {1e3 * row.height_m * row.d_lean_north:+.2f} mm, {significance}"
    )
