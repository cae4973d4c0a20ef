"""A campaign file of many epochs, of eight stations each."""

from datetime import timedelta
from typing import Final

from benchmarks.catalog.made_up import N_STATIONS, START, STRUCTURE, epoch_name

HEAD: Final = f"""schema_version = 1
[structure]
id = "{STRUCTURE}"
kind = "chimney"
height_m = 102.0
shaft_z_m = [2.0, 102.0]
base_xy_m = [0.0, 0.0]
radius_m = [4.6, 2.7]
[frame]
axes = "ENU"
horizontal = "local"
"""


def campaign_text(n_epochs: int) -> str:
    """The file; its scans are not there."""
    return HEAD + "".join(_epoch(number) for number in range(n_epochs))


def _epoch(number: int) -> str:
    name, time = epoch_name(number), START + timedelta(days=7 * number)
    stations = "".join(
        f'[[epochs.stations]]\nid = "ST{station:02d}"\nscan = "{name}/ST{station:02d}.laz"\n'
        f"position_m = [{200.0 + station}, 10.0, 1.6]\nheading_deg = 271.3\n"
        for station in range(N_STATIONS)
    )
    return f'[[epochs]]\nid = "{name}"\ntime = {time.isoformat()}\n{stations}'
