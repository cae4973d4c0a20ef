"""A user's own tables of limits: rules, versions by time, and what must not be said."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.geometry.failure import FitFailure
from tasks.limit_choice import further_limits, own_tables, primary_limit
from tasks.limits import LimitTable, MissingLimit, allowable, verdict
from tasks.settings import Campaign
from tasks.settings.limit_file import load_limits
from tests.unit.settings.campaign_text import FEWEST, load

HEAD = 'document = "our rules"\nsource = "our file"\n'


def one(rule: str, kind: str = "in-service", more: str = "") -> str:
    """A file of one table."""
    return f'[[limits]]\nname = "own"\nkind = "{kind}"\n{HEAD}{rule}\n{more}\n'


def table_of(folder: Path, text: str) -> LimitTable:
    file = folder / "own.toml"
    file.write_text(text, encoding="utf-8")
    (table,) = own_tables(load_limits(file))
    return table


def campaign_of(folder: Path, limits: str, tables: str) -> Campaign:
    (folder / "limits").mkdir(exist_ok=True)
    (folder / "limits" / "own.toml").write_text(tables, encoding="utf-8")
    return load(folder, f'{FEWEST}[limits]\nfile = "limits/own.toml"\n{limits}\n')


@pytest.mark.parametrize(
    ("rule", "height_m", "limit_m"),
    [
        ("points_m = [[20.0, 0.02], [40.0, 0.06]]", 30.0, 0.04),
        ("ratio = 0.001", 50.0, 0.05),
        ("one_in = 250", 50.0, 0.2),
        ("ratio = 0.001\nat_least_m = 0.025", 10.0, 0.025),
        ("ratio = 0.001\nat_least_m = 0.025", 50.0, 0.05),
        ("ratio = 0.001\nat_most_m = 0.04", 50.0, 0.04),
        ("ratio = 0.001\nat_least_m = 0.02\nat_most_m = 0.04", 30.0, 0.03),
        ("one_in = 100\nabove_m = 10.0\nup_to_m = 50.0", 50.0, 0.5),
    ],
)
def test_a_rule_allows_what_it_says(tmp_path: Path, rule: str, height_m: float, limit_m: float) -> None:
    assert allowable(table_of(tmp_path, one(rule)), height_m) == pytest.approx(limit_m, abs=1e-15)


@pytest.mark.parametrize(
    ("rule", "height_m", "reason"),
    [
        ("points_m = [[20.0, 0.02], [40.0, 0.06]]", 19.9, "holds from 20 m to 40 m; the height is 19.9 m"),
        (
            "one_in = 100\nabove_m = 10.0\nup_to_m = 50.0",
            10.0,
            "holds above 10 m up to 50 m; the height is 10 m",
        ),
        ("one_in = 100\nup_to_m = 50.0", 50.1, "holds above 0 m up to 50 m; the height is 50.1 m"),
    ],
)
def test_outside_its_heights_a_rule_says_nothing(
    tmp_path: Path, rule: str, height_m: float, reason: str
) -> None:
    found = allowable(table_of(tmp_path, one(rule)), height_m)
    assert isinstance(found, FitFailure)
    assert reason in found.reason


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (one(""), "needs one of points_m, ratio and one_in, got none; keep one of them"),
        (one("ratio = 0.01\none_in = 100"), "got ratio and one_in"),
        (one("points_m = [[1.0, 0.1]]\nat_most_m = 1.0"), "at_most_m goes with ratio or one_in"),
        (one("ratio = 0.01\nabove_m = 50.0\nup_to_m = 20.0"), "up_to_m must be higher than above_m"),
        (
            one("ratio = 0.01\nat_least_m = 0.5\nat_most_m = 0.2"),
            "at_least_m must not be more than at_most_m",
        ),
        (one("ratio = 0.01\nsigmas = 2.0"), "sigmas goes with kind measurement"),
        (one("ratio = 0.01", kind="service"), "should be 'construction', 'design', 'in-service' or 'meas"),
        (one("rate = 0.01"), "unknown key; did you mean 'ratio'?"),
        (one("ratio = 0.01").replace("own", "bre-digest-475"), "is the name of a shipped table"),
        (one("ratio = 0.01") * 2, "2 tables of that name have version = 1; each version needs its own"),
        (one("ratio = 0.01") * 2, "2 tables of that name have no valid_from"),
        ('[[limits]]\nname = "own"\nratio = 0.01\n', "kind: is required"),
        ("", "limits: is required"),
    ],
)
def test_a_file_that_says_too_much_or_too_little_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as refused:
        table_of(tmp_path, text)
    assert message in str(refused.value)
    assert "own.toml: limits" in str(refused.value)


def test_no_file_says_where_an_example_is(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.toml: no such file; docs/limits\.md has an example"):
        load_limits(tmp_path / "none.toml")


VERSIONS = (
    one("ratio = 0.010", more="version = 1\nvalid_from = 2020-01-01")
    + one("ratio = 0.008", more="version = 3\nvalid_from = 2026-01-01")
    + one("ratio = 0.009", more="version = 2\nvalid_from = 2024-06-01")
)


@pytest.mark.parametrize(
    ("day", "version"),
    [("2020-01-01", 1), ("2024-05-31", 1), ("2024-06-01", 2), ("2026-01-01", 3), ("2099-01-01", 3)],
)
def test_an_epoch_is_judged_by_the_version_of_its_day(tmp_path: Path, day: str, version: int) -> None:
    campaign = campaign_of(tmp_path, "", VERSIONS)
    found = primary_limit(campaign, datetime.fromisoformat(f"{day}T06:00:00+08:00"))
    assert isinstance(found, LimitTable)
    assert found.version == version


def test_an_epoch_before_the_first_version_has_no_limit_and_the_reason(tmp_path: Path) -> None:
    found = primary_limit(campaign_of(tmp_path, "", VERSIONS), datetime(2019, 12, 31, tzinfo=UTC))
    assert isinstance(found, MissingLimit)
    judged = verdict(0.1, 0.01, 10.0, found)
    assert (judged.verdict, judged.allowable_m) == ("no limit", None)
    assert judged.reason == "own: no version holds on 2019-12-31; the first is valid from 2020-01-01"


def test_a_version_without_a_date_holds_before_all_others(tmp_path: Path) -> None:
    tables = one("ratio = 0.02") + one("ratio = 0.01", more="version = 2\nvalid_from = 2024-01-01")
    campaign = campaign_of(tmp_path, "", tables)
    before, after = (primary_limit(campaign, datetime(year, 1, 1, tzinfo=UTC)) for year in (1999, 2024))
    assert isinstance(before, LimitTable)
    assert isinstance(after, LimitTable)
    assert (before.version, after.version) == (1, 2)


def test_limits_are_judged_side_by_side(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path, 'table = "own"\nalso = ["bre-digest-475"]', one("ratio = 0.01"))
    beside = further_limits(campaign, datetime(2025, 1, 1, tzinfo=UTC))
    assert [limit.name for limit in beside] == ["bre-digest-475"]


def test_the_content_of_the_file_is_a_setting(tmp_path: Path) -> None:
    first = campaign_of(tmp_path, "", one("ratio = 0.01"))
    second = campaign_of(tmp_path, "", one("ratio = 0.02"))
    assert first.digest != second.digest
    assert '"ratio":0.02' in second.filled_in_json()


TWO = one("ratio = 0.01") + one("ratio = 0.001", kind="measurement").replace('"own"', '"survey"')


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("", "limits.file: holds several tables: own, survey; say with table which one counts"),
        ('table = "ovn"', "limits.table: unknown table of limits 'ovn'; known: own, survey, aci117-general"),
        ('table = "own"\nalso = ["gb"]', "limits.also: unknown table of limits 'gb'; known: own"),
        ('table = "own"\nalso = ["own"]', "limits.also: names own twice; name each table once"),
        (
            'table = "survey"',
            "limits.table: 'survey' is of kind measurement and judges the survey, not the lean",
        ),
        ('table = "own"\nkind = "design"', "limits.kind: says what verticality_m is for, and there is none"),
        (
            'kind = "measurement"\nverticality_m = [[10.0, 0.1]]',
            "limits.kind: a limit of the measurement judges",
        ),
    ],
)
def test_a_campaign_that_chooses_wrongly_is_told(tmp_path: Path, limits: str, message: str) -> None:
    with pytest.raises(InputError) as refused:
        campaign_of(tmp_path, limits, TWO)
    assert message in str(refused.value)


def test_a_file_of_limits_outside_the_campaigns_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"limits\.file: '\.\./own\.toml' lies outside the allowed folders"):
        load(tmp_path, f'{FEWEST}[limits]\nfile = "../own.toml"\n')


def test_own_points_have_the_kind_that_the_campaign_states(tmp_path: Path) -> None:
    text = f'{FEWEST}[limits]\nkind = "in-service"\nverticality_m = [[10.0, 0.05]]\n'
    found = primary_limit(load(tmp_path, text), datetime(2025, 1, 1, tzinfo=UTC))
    assert isinstance(found, LimitTable)
    assert "an in-service limit" in found.described


@pytest.mark.parametrize(
    ("sigma_m", "sigmas", "word"), [(0.009, 1.0, "pass"), (0.011, 1.0, "fail"), (0.009, 2.0, "fail")]
)
def test_a_limit_of_the_measurement_judges_the_sigma(
    tmp_path: Path, sigma_m: float, sigmas: float, word: str
) -> None:
    table = table_of(tmp_path, one("ratio = 0.001", kind="measurement", more=f"sigmas = {sigmas}"))
    # however far the lean is beyond it: the limit is not one of the lean
    found = verdict(1.0, sigma_m, 10.0, table)
    assert found.verdict == word
    assert found.reason.startswith(f"{'sigma' if sigmas == 1.0 else '2 sigma'} of the deviation")


def test_a_measurement_without_sigma_cannot_be_told(tmp_path: Path) -> None:
    table = table_of(tmp_path, one("ratio = 0.001", kind="measurement"))
    assert verdict(1.0, None, 10.0, table).verdict == "cannot tell"
