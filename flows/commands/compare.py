"""``tiltwatch compare``: whether two epochs differ."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import (
    AsJson,
    CampaignFile,
    WorkspaceFolder,
    check_epochs,
    load_with_workspace,
    workspace_of,
)
from flows.terminal import answer, say
from storage.errors import StorageError, UsageError

if TYPE_CHECKING:
    from storage.records import ChangeTestRow
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
    """Say for every scheme and method how far the top moved between two epochs, and what else changed.

    A change is significant where its probability without any movement is below 1 %. What the epochs have in common is
    cancelled: the form of the wall as far as both saw the same of it, the frame of stable surroundings. Of the primary
    scheme and method the base, the bending, the radius profile and the centres of all slices are tested, too. What others
    measured in both epochs stands below ours, by its source.

    Parameters
    ----------
    epoch
        The later epoch.
    reference
        The epoch to count from.
    """
    from storage.upgrade import ready_workspace
    from tasks.epoch_difference import epoch_tests, reference_differences

    campaign = load_with_workspace(file, workspace)
    check_epochs(campaign, (epoch, reference))
    if epoch == reference:
        raise UsageError(f"epoch {epoch!r} cannot be compared with itself; name two epochs")
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    tests = epoch_tests(place, campaign.structure.id, epoch, reference)
    measured = reference_differences(place, campaign.structure.id, epoch, reference)
    leans = [row for row in tests if row.quantity == "lean"]
    if not leans and not measured:
        raise StorageError(
            f"no scheme has an axis in both {epoch} and {reference}; `tiltwatch run {file}` processes what is missing"
        )
    if as_json:
        facts = {
            "changes": [_facts(row) for row in leans],
            "tests": [_facts(row) for row in tests if row.quantity != "lean"],
            "references": [asdict(row) for row in measured],
        }
        return answer(0, {"primary": list(campaign.report.primary), **facts})
    primary = tuple(campaign.report.primary)
    height_m = leans[0].height_m if leans else measured[0].height_m
    where = f"the top at {height_m:g} m against the foot, by the lean"
    say(f"{campaign.structure.title}: movement of {where}, from {reference} to {epoch}")
    say(*(_line(row, primary) for row in leans), *(_measured_line(row) for row in measured))
    others = [row for row in tests if row.quantity != "lean" and (row.scheme, row.method) == primary]
    if others:
        say("", f"{'/'.join(primary)} besides:", *(_quantity_line(row) for row in others))
        say("", "Each line is a test of its own at 1 %; the lean of the primary decides.")
    return 0


def _facts(row: "ChangeTestRow") -> dict[str, bool | float | str | None]:
    """A test as JSON; the lean under the names of the view ``changes``."""
    facts: dict[str, bool | float | str | None] = {
        **asdict(row),
        "epoch_time": row.epoch_time.isoformat(),
        "reference_time": row.reference_time.isoformat(),
    }
    if row.quantity != "lean":
        return facts
    names = {
        "d_east": "d_lean_east",
        "d_north": "d_lean_north",
        "size_m": "d_top_m",
        "sigma_m": "sigma_top_m",
        "statistic": "chi2",
    }
    return {names.get(name, name): value for name, value in facts.items()}


def _line(row: "ChangeTestRow", primary: tuple[str, ...]) -> str:
    mark = "  <- primary" if (row.scheme, row.method) == primary else ""
    east, north = (row.height_m * (part or 0.0) for part in (row.d_east, row.d_north))
    told = _movement(_Movement(row.size_m or 0.0, row.sigma_m, east, north), row)
    why = f" ({row.reason})" if row.reason else ""
    return f"{row.scheme}/{row.method}: {told}{mark}{why}"


def _measured_line(row: "ReferenceChange") -> str:
    east, north = row.height_m * row.d_lean_east, row.height_m * row.d_lean_north
    told = _movement(_Movement(row.d_top_m, row.sigma_top_m, east, north), row)
    return f"{row.source} (reference): {told}"


@dataclass(frozen=True, slots=True)
class _Movement:
    """A movement with its sigma along it and its components, metres."""

    size_m: float
    sigma_m: float | None
    east_m: float
    north_m: float


def _movement(movement: _Movement, row: "ChangeTestRow | ReferenceChange") -> str:
    from flows.condition_text import significance_text

    sigma = "uncertainty unknown" if movement.sigma_m is None else f"± {2e3 * movement.sigma_m:.2f} mm (k=2)"
    significance = significance_text(row.significant, row.p_value, row.smallest_detectable_m)
    return (
        f"{1e3 * movement.size_m:.2f} {sigma}, east {1e3 * movement.east_m:+.2f} mm,"
        f" north {1e3 * movement.north_m:+.2f} mm, {significance}"
    )


QUANTITIES = {
    "base": "foot of the axis moved",
    "bending": "sagitta changed by",
    "radius": "radius profile changed by up to",
    "centres": "centres of the slices moved by up to",
}


def _quantity_line(row: "ChangeTestRow") -> str:
    from flows.condition_text import significance_text

    sigma = "" if row.sigma_m is None else f" ± {2e3 * row.sigma_m:.2f}"
    size = "" if row.size_m is None else f" {1e3 * row.size_m:.2f}{sigma} mm"
    told = significance_text(row.significant, row.p_value, row.smallest_detectable_m)
    why = f"; {row.reason}" if row.reason else ""
    if row.p_value is None:
        return f"{row.quantity}: not compared{why}"
    return f"{QUANTITIES[row.quantity]}{size}, {told}{why}"
