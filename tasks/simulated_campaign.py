"""A whole simulated campaign on disk: scans, campaign file, and the truth beside them."""

import hashlib
import json
import uuid
from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Final

import numpy as np
from laspy.header import LasHeader
from laspy.lasdata import LasData
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.simulation.campaign import SimulatedCampaignRequest, epoch_name, scan_epochs
from tasks.simulation.description import campaign_epoch, campaign_head, epoch_truth, station_truth

__all__ = [
    "CAMPAIGN_FILE",
    "REQUEST_FILE",
    "TRUTH_FILE",
    "SimulatedCampaignRequest",
    "write_simulated_campaign",
]

CAMPAIGN_FILE: Final = "campaign.toml"
TRUTH_FILE: Final = "truth.json"
REQUEST_FILE: Final = "simulation.json"

_SCALE_M: Final = 1e-4


def write_simulated_campaign(folder: Path, request: SimulatedCampaignRequest) -> Path:
    """Simulate a campaign and write it: scans as LAZ 1.4, ``campaign.toml``, and ``truth.json`` an epoch.

    A folder that already holds this request, by this code, is left as it is.

    Parameters
    ----------
    folder : Path
        Where to write; made if missing. A campaign of another request that was simulated there is replaced.
    request : SimulatedCampaignRequest
        What to simulate.

    Returns
    -------
    Path
        The campaign file.

    Raises
    ------
    InputError
        If the folder holds a campaign file that no simulation wrote.
    TiltwatchError
        If open3d cannot be loaded.
    """
    asked = {"code": _code_digest(), "request": json.loads(json.dumps(asdict(request)))}
    if _holds(folder, asked):
        return folder / CAMPAIGN_FILE
    _clear(folder)
    folder.mkdir(parents=True, exist_ok=True)
    # without "files" it says that the folder is ours but not finished: the next call writes it again
    _write_json(folder / REQUEST_FILE, asked)
    texts = _write_epochs(folder, request)
    _write_text(folder / CAMPAIGN_FILE, "\n".join([campaign_head(request), *texts]))
    names = _file_names(request.epochs, request.stations)
    sizes = {name: (folder / name).stat().st_size for name in names}
    _write_json(folder / REQUEST_FILE, {**asked, "files": sizes})
    return folder / CAMPAIGN_FILE


def _write_epochs(folder: Path, request: SimulatedCampaignRequest) -> list[str]:
    """Write scans and truth of every epoch; return the epochs' parts of the campaign file."""
    texts = []
    for epoch, stations in scan_epochs(request):
        home = folder / epoch.name
        home.mkdir(exist_ok=True)
        truths = []
        for station in stations:
            truths.append(station_truth(station))
            _write_laz(home / truths[-1].file, station.scan.points_m, epoch.time)
        _write_json(home / TRUTH_FILE, epoch_truth(request, epoch, truths).as_json())
        texts.append(campaign_epoch(epoch, truths))
    return texts


def _write_laz(path: Path, points_m: NDArray[np.float64], time: datetime) -> None:
    """Write points (n, 3) as LAZ 1.4 whose bytes depend on nothing but the arguments."""
    header = LasHeader(point_format=6, version="1.4")
    header.scales = np.full(3, _SCALE_M)
    header.offsets = np.zeros(3)
    header.creation_date = time.date()
    header.uuid = uuid.UUID(int=0)
    header.generating_software = "tiltwatch simulation"
    las = LasData(header)
    las.X, las.Y, las.Z = np.rint(points_m / _SCALE_M).astype(np.int32).T
    las.return_number = np.ones(len(points_m), np.uint8)
    las.number_of_returns = np.ones(len(points_m), np.uint8)
    las.write(str(path))


def _file_names(epochs: int, stations: int) -> list[str]:
    """Everything that is written, but the request itself; relative, with forward slashes."""
    scans = [f"ST{index + 1:02d}.laz" for index in range(stations)]
    return [
        CAMPAIGN_FILE,
        *(f"{epoch_name(e)}/{name}" for e in range(epochs) for name in [TRUTH_FILE, *scans]),
    ]


def _code_digest() -> str:
    """Digest of the code that simulates: other code writes the campaign again."""
    here = Path(__file__)
    files = [here, here.parent / "conventions.py", *sorted((here.parent / "simulation").rglob("*.py"))]
    text = "\0".join(file.name + "\0" + file.read_text(encoding="utf-8") for file in files)
    return hashlib.sha256(text.encode()).hexdigest()


def _holds(folder: Path, asked: Mapping[str, object]) -> bool:
    try:
        written = json.loads((folder / REQUEST_FILE).read_text(encoding="utf-8"))
        same = all(written[key] == value for key, value in asked.items())
        return same and all((folder / name).stat().st_size == size for name, size in written["files"].items())
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError):
        return False


def _clear(folder: Path) -> None:
    """Take away what an earlier simulation wrote, and nothing else."""
    try:
        written = json.loads((folder / REQUEST_FILE).read_text(encoding="utf-8"))
        names = _file_names(int(written["request"]["epochs"]), int(written["request"]["stations"]))
    except (FileNotFoundError, ValueError, KeyError, TypeError) as error:
        if (folder / CAMPAIGN_FILE).exists():
            raise InputError(
                f"{folder / CAMPAIGN_FILE}: no readable {REQUEST_FILE} beside it says that a simulation wrote it, so "
                "it is not overwritten; choose another folder"
            ) from error
        return
    for name in names:
        (folder / name).unlink(missing_ok=True)


def _write_json(path: Path, content: Mapping[str, object]) -> None:
    _write_text(path, json.dumps(content, indent=1) + "\n")


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
