"""The table [schedule]: what is a time to run at, and what is not."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.settings.schedule import Schedule
from tests.unit.settings.campaign_text import FEWEST, load


def schedule(tmp_path: Path, text: str) -> Schedule:
    return load(tmp_path, f"{FEWEST}\n[schedule]\n{text}\n").schedule


def test_without_a_table_nothing_runs_unasked_but_a_deployed_run_has_its_limit(tmp_path: Path) -> None:
    found = load(tmp_path, FEWEST).schedule
    assert found.cron is None
    assert (found.time_limit_s, found.retries) == (4 * 3600.0, 1)


@pytest.mark.parametrize(
    "cron", ["30 6 * * *", "*/15 0-6 1,15 jan-mar,12 mon", "0 0 1 1 7", "5 4 * * 1-5/2", "0  6 1 * *"]
)
def test_a_cron_of_five_fields_is_taken(tmp_path: Path, cron: str) -> None:
    assert schedule(tmp_path, f'cron = "{cron}"').cron == " ".join(cron.split())


@pytest.mark.parametrize(
    ("cron", "told"),
    [
        ("30 6 * *", "needs five fields .* got 4"),
        ("60 6 * * *", "the minute '60' is none"),
        ("30 24 * * *", "the hour '24' is none"),
        ("30 6 0 * *", "the day of the month '0' is none"),
        ("30 6 * 13 *", "the month '13' is none"),
        ("30 6 * * 8", "the day of the week '8' is none"),
        ("30 6 * * tue-sun", "the day of the week 'tue-sun' is none"),
        ("30 6 5-1 * *", "the day of the month '5-1' is none"),
        ("30 6 */0 * *", "the day of the month"),
        ("@daily", "needs five fields .* got 1"),
        ("³0 6 * * *", "the minute"),
    ],
)
def test_what_is_no_cron_is_refused_with_the_field(tmp_path: Path, cron: str, told: str) -> None:
    with pytest.raises(InputError, match=rf"schedule\.cron: {told}"):
        schedule(tmp_path, f'cron = "{cron}"')


@pytest.mark.parametrize("zone", ["Europe/Nowhere", "", "../../etc/passwd", "Europe"])
def test_what_is_no_time_zone_is_refused(tmp_path: Path, zone: str) -> None:
    with pytest.raises(InputError, match=r"schedule\.timezone: .* is no time zone; write it as"):
        schedule(tmp_path, f'timezone = "{zone}"')
