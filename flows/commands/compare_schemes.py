"""``tiltwatch compare-schemes``: what the schemes make of one epoch, and how many slices are enough."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from collections.abc import Sequence
from dataclasses import asdict
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
from flows.terminal import Json, answer, say
from storage.errors import StorageError, UsageError

if TYPE_CHECKING:
    from storage.records import SchemeComparisonRow
    from tasks.scheme_comparison import EpochAxes
    from tasks.stored_comparison import SchemeAgreement


def compare_schemes(
    file: CampaignFile,
    epoch: Annotated[str | None, Parameter(name="EPOCH")] = None,
    /,
    *,
    against: str | None = None,
    pairs: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Compare schemes, methods and reference measurements of an epoch, and recommend how many slices are enough.

    The sigma of a difference counts what both do not share: schemes of one epoch have the same poses, and some of the
    same points. Enough are the fewest slices whose sigma, levelling and registration included, is at most 10 % above
    the best one, without a significant difference from it.

    Parameters
    ----------
    epoch
        Epoch to compare; the newest with a result where none is named.
    against
        SCHEME/METHOD or source of a reference to compare with; the primary where none is named.
    pairs
        Show every two axes against each other, too.
    """
    from storage.upgrade import ready_workspace
    from tasks.scheme_comparison import compare_schemes as comparison_of
    from tasks.stored_comparison import agreements, epoch_axes, newest_epoch, pairs_of

    campaign = load_with_workspace(file, workspace)
    check_epochs(campaign, () if epoch is None else (epoch,))
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    chosen = epoch or newest_epoch(place, campaign.structure.id)
    axes = None if chosen is None else epoch_axes(place, campaign.structure.id, chosen)
    if axes is None or not axes.tilt:
        where = f"in {chosen}" if chosen else f"in {place.root}"
        raise StorageError(f"no scheme has an axis {where}; `tiltwatch run {file}` processes what is missing")
    base = against or "/".join(campaign.report.primary)
    rows = comparison_of(axes, _checked(axes, against) or base)
    others = pairs_of(axes) if pairs else []
    found = agreements(place, campaign.structure.id, base)
    if as_json:
        return answer(0, _facts(rows, others, found))
    _tell(campaign.structure.title, rows, others, found)
    return 0


def _checked(axes: "EpochAxes", against: str | None) -> str | None:
    from tasks.scheme_comparison import labels_of

    known = labels_of(axes)
    if against is not None and against not in known:
        raise UsageError(f"epoch {axes.epoch} has no axis {against!r}; known: {', '.join(known)}")
    return against


def _facts(
    rows: Sequence["SchemeComparisonRow"],
    pairs: Sequence["SchemeComparisonRow"],
    found: Sequence["SchemeAgreement"],
) -> dict[str, Json]:
    from tasks.scheme_comparison_text import recommendation_of

    chosen = next((row for row in rows if row.is_recommended), None)
    return {
        "structure": rows[0].structure,
        "epoch": rows[0].epoch,
        "against": rows[0].against,
        "comparison": [asdict(row) for row in rows],
        "pairs": [asdict(row) for row in pairs],
        "best": rows[0].best,
        "recommended": chosen.compared if chosen else None,
        "recommended_slices": chosen.n_slices if chosen else None,
        "recommendation": recommendation_of(rows),
        "over_epochs": [asdict(one) for one in found],
    }


def _tell(
    title: str,
    rows: Sequence["SchemeComparisonRow"],
    pairs: Sequence["SchemeComparisonRow"],
    found: Sequence["SchemeAgreement"],
) -> None:
    from tasks.scheme_comparison_text import (
        agreement_lines,
        difference_lines,
        recommendation_of,
        workload_table_lines,
    )

    first = rows[0]
    say(f"{title}, epoch {first.epoch}, at {first.height_m:g} m")
    say("", *workload_table_lines([row for row in rows if row.scheme is not None]))
    differences = difference_lines(rows, f"Difference from {first.against} (mm)")
    say("", *(differences or [first.reason or "nothing to compare with"]))
    if pairs:
        say("", *difference_lines(pairs, "Every two of them (mm)"))
    if found:
        say("", *agreement_lines(found))
    say("", *recommendation_of(rows))
