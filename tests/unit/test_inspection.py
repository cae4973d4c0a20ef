"""What the headers of a campaign's scans show before any point is read."""

from pathlib import Path

from pyproj import CRS

from tasks.inspection import Inspection, inspect_campaign
from tests.unit.ingest.clouds import wall_points, wkt_vlr, write_las
from tests.unit.settings.campaign_text import edited, load

PLACE = "epochs[e2].registered"


def inspect(folder: Path, horizontal: str, stated: int) -> Inspection:
    """A campaign whose second epoch is a registered cloud that states a system."""
    write_las(folder / "e2" / "merged.laz", wall_points(), vlrs=(wkt_vlr(CRS.from_epsg(stated).to_wkt()),))
    return inspect_campaign(load(folder, edited('"local"', f'"{horizontal}"')))


def problems_of_cloud(found: Inspection) -> str:
    return " ".join(problem for problem in found.problems if problem.startswith(PLACE))


def test_a_registered_cloud_in_another_system_is_a_problem(tmp_path: Path) -> None:
    (tmp_path / "e2").mkdir()
    found = inspect(tmp_path, "EPSG:4548", 32650)
    assert "needs coordinates in EPSG:4548, as [frame] horizontal says, came EPSG:32650" in problems_of_cloud(
        found
    )
    assert [scan for scan in found.scans if scan.epoch == "e2"] == []


def test_a_registered_cloud_in_the_system_of_the_campaign_is_shown_with_it(tmp_path: Path) -> None:
    (tmp_path / "e2").mkdir()
    for horizontal in ("EPSG:32650", "local"):
        found = inspect(tmp_path, horizontal, 32650)
        assert "horizontal" not in problems_of_cloud(found)
        assert [scan.horizontal for scan in found.scans if scan.epoch == "e2"] == ["EPSG:32650"]
