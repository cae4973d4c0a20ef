"""``tiltwatch check``: whether the campaign file and its scans are fit to run."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from flows.commands.options import AsJson, CampaignFile
from flows.terminal import Json, answer, complain, say
from storage.errors import InputError

if TYPE_CHECKING:
    from tasks.inspection import InspectedScan, Inspection
    from tasks.settings import Campaign

BAD_INPUT = 3


def check(file: CampaignFile, /, *, as_json: AsJson = False) -> int:
    """Check a campaign file and the headers of its scans; no points are read.

    Everything that is wrong is told at once. Exit code 3 if anything is.
    """
    from tasks.inspection import inspect_campaign
    from tasks.settings import load_campaign

    try:
        campaign = load_campaign(file)
    except InputError as error:
        problems = str(error).splitlines()
        complain(*(f"error: {problem}" for problem in problems))
        return answer(BAD_INPUT, {"problems": problems}) if as_json else BAD_INPUT
    inspection = inspect_campaign(campaign)
    problems = [f"{file}: {problem}" for problem in inspection.problems]
    complain(*(f"error: {problem}" for problem in problems))
    code = BAD_INPUT if problems else 0
    if as_json:
        return answer(code, {**_facts(campaign, inspection), "problems": problems})
    say(*_lines(file, campaign, inspection))
    return code


def _facts(campaign: "Campaign", inspection: "Inspection") -> dict[str, Json]:
    return {
        "structure": campaign.structure.id,
        "digest": campaign.digest,
        "reference": campaign.reference_epoch.id,
        "epochs": [
            {"epoch": epoch.id, "time": epoch.time.isoformat(), "n_scans": len(epoch.scans)}
            for epoch in campaign.epochs
        ],
        "scans": [
            {
                "epoch": scan.epoch,
                "station": scan.station,
                "scan": str(scan.path),
                "format": scan.format,
                "n_points": scan.n_points,
                "size_bytes": scan.size_bytes,
                "horizontal": scan.horizontal,
            }
            for scan in inspection.scans
        ],
    }


def _lines(file: Path, campaign: "Campaign", inspection: "Inspection") -> Iterator[str]:
    structure = campaign.structure
    yield f"{structure.title}: {structure.kind}, {len(campaign.epochs)} epochs, reference {campaign.reference_epoch.id}"
    for epoch in campaign.epochs:
        scans = [scan for scan in inspection.scans if scan.epoch == epoch.id]
        yield f"{epoch.id}: {len(scans)} of {len(epoch.scans)} scans sound, {_points(scans)}, {_size(scans)}"
    yield f"{file}: {'ready to run' if not inspection.problems else f'{len(inspection.problems)} problems'}"


def _points(scans: Sequence["InspectedScan"]) -> str:
    counts = [scan.n_points for scan in scans]
    known = sum(count for count in counts if count is not None)
    return f"{known:,} points" + (" and more" if None in counts else "")


def _size(scans: Sequence["InspectedScan"]) -> str:
    return f"{sum(scan.size_bytes for scan in scans) / 1e6:.1f} MB"
