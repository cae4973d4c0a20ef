"""Reference measurements and the comparison of schemes, from the campaign file through a run to the tables."""

import re
from pathlib import Path

import pytest

from flows.outcome import RunOutcome
from storage.records import AccuracyRow, ReferenceLeanRow, SchemeComparisonRow
from storage.workspace import Workspace
from tasks.reporting import epoch_tables_text
from tasks.settings import load_campaign
from tests.flows.campaigns import STRUCTURE, rows, run, small_campaign

STATION = "total station"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two epochs; the control is a total station, which measured the first one only."""
    file = small_campaign(tmp_path_factory.mktemp("references"), epochs=2, points=30_000)
    text = file.read_text(encoding="utf-8").replace('control = ["F", "paper"]', f'control = "{STATION}"')
    text = re.sub(r"primary = \[.*\]", 'primary = ["A", "robust"]', text)
    head, last, tail = text.rpartition("[[epochs.references]]")
    assert last
    kept = tail.split("sigma = ", 1)[1].split("\n", 1)[1]
    file.write_text(head + kept, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def outcome(campaign: Path) -> RunOutcome:
    return run(campaign, campaign.parent / "results", schemes=("A", "C"))


def epochs_of(campaign: Path) -> list[str]:
    return [epoch.id for epoch in load_campaign(campaign).epochs]


def test_the_reference_is_published_with_its_epoch(campaign: Path, outcome: RunOutcome) -> None:
    first, second = epochs_of(campaign)
    (row,) = rows(outcome.workspace, "reference_leans", first)
    (stated,) = load_campaign(campaign).epochs[0].references
    assert isinstance(row, ReferenceLeanRow)
    assert (row.source, row.lean_east, row.lean_north, row.sigma) == (
        STATION,
        stated.lean_east,
        stated.lean_north,
        stated.sigma,
    )
    assert row.azimuth_deg is not None
    assert rows(outcome.workspace, "reference_leans", second) == []


def test_every_scheme_is_counted_from_the_reference(campaign: Path, outcome: RunOutcome) -> None:
    first, _ = epochs_of(campaign)
    found: list[AccuracyRow] = rows(outcome.workspace, "accuracy", first)
    (reference,) = rows(outcome.workspace, "reference_leans", first)
    assert {row.control for row in found} == {STATION}
    assert {(row.scheme, row.method) for row in found} >= {("A", "paper"), ("A", "robust"), ("C", "paper")}
    azimuths = {row.reference for row in found if row.quantity == "azimuth_deg"}
    assert sorted(azimuths) == [pytest.approx(reference.azimuth_deg)]
    sigmas = {row.quantity: row.reference_sigma for row in found}
    assert sigmas["azimuth_deg"] == pytest.approx(reference.azimuth_sigma_deg)
    assert sigmas["deviation_m"] == pytest.approx(reference.deviation_sigma_m)
    text = epoch_tables_text(Workspace(outcome.workspace), STRUCTURE, first)
    assert f"Table 3. Against the control {STATION}, method robust" in text


def test_an_epoch_without_the_control_is_ok_with_a_note(campaign: Path, outcome: RunOutcome) -> None:
    _, second = outcome.epochs
    assert second.state == "ok"
    assert (
        f"no relative errors: no reference measurement '{STATION}' in this epoch; there is: none"
        in second.notes
    )
    assert rows(outcome.workspace, "accuracy", epochs_of(campaign)[1]) == []


def test_schemes_and_reference_stand_beside_the_primary(campaign: Path, outcome: RunOutcome) -> None:
    first, _ = epochs_of(campaign)
    found: list[SchemeComparisonRow] = rows(outcome.workspace, "scheme_comparison", first)
    assert {row.against for row in found} == {"A/robust"}
    by_label = {row.compared: row for row in found}
    assert set(by_label) >= {"A/paper", "A/robust", "C/paper", "C/robust", STATION}
    assert by_label["A/robust"].d_lean_east is None
    assert by_label["C/robust"].shared == "poses and slices"
    assert by_label[STATION].shared == "nothing"
    assert by_label["C/robust"].d_sigma_top_m is not None
    assert by_label["C/robust"].sigma_m is not None
    # most of sigma is levelling and registration, which both share
    assert by_label["C/robust"].d_sigma_top_m < by_label["C/robust"].sigma_m
    assert sum(row.is_recommended for row in found) <= 1
