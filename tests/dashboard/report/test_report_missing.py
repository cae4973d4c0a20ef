"""What is not there is shown as missing, with the reason, and never as 0."""

import json
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from dashboard.report.blocks import Block, Chart, Document, Missing
from dashboard.report.page import html_of
from dashboard.report.words import words_of
from storage.errors import StorageError
from storage.records import REGISTERED
from storage.workspace import Workspace, open_workspace
from tests.dashboard.report.reported import document, facts_of, limited, publish, text_of

Tables = dict[str, list[Any]]


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    """An empty workspace."""
    return open_workspace(tmp_path / "ws")


def blocks(made: Document) -> list[Block]:
    """All blocks, those side by side as well."""
    flat: list[Block] = []
    for section in made.sections:
        for block in section.blocks:
            flat.extend(block.blocks if block.type == "beside" else [block])
    return flat


def missing(made: Document) -> dict[str, str]:
    """What is said to be missing, and why."""
    return {block.what: block.why for block in blocks(made) if isinstance(block, Missing)}


def test_a_failed_epoch_says_so_with_its_reason_and_what_came_before(ws: Workspace) -> None:
    def failed(tables: Tables) -> None:
        row = replace(tables["epochs"][0], state="failed", reason="no scan could be read", coverage_deg=None)
        tables.update({key: [] for key in tables})
        tables["epochs"] = [row]

    publish(ws, 2, failed)
    made = document(ws)
    assert made.first.word == "NO RESULT"
    assert made.first.measured == made.first.limit == "--"
    assert [card.value for card in made.first.cards] == ["--", "--", "--", "failed"]
    assert isinstance(made.first.sketch, Missing)
    text = text_of(made)
    assert "Epoch e1 could not be processed: no scan could be read" in text
    assert "The last result before it is that of epoch e0" in text
    assert set(made.charts) == {"series", "plan"}


def test_without_a_limit_nothing_passes_or_fails(ws: Workspace) -> None:
    publish(ws, 2)
    made = document(ws)
    assert (made.first.word, made.first.limit, made.first.limit_label) == ("NO LIMIT", "--", "Limit")
    assert made.first.tone == "missing"
    assert "No limit was applied: no table." in text_of(made)
    assert missing(made)["What every limit says of the result that counts"] == "no limit was judged"


def test_one_epoch_alone_has_no_change_and_no_rate(ws: Workspace) -> None:
    publish(ws, 1, limited)
    made = document(ws, "e0")
    change, rate, *_ = made.first.cards
    assert (change.value, change.note) == ("--", "this is the reference epoch")
    assert rate.value == "--"
    assert "Measure a second epoch: a change can be told from then on." in made.first.next_steps


def test_an_axis_through_two_centres_has_no_residuals_and_none_are_drawn(ws: Workspace) -> None:
    def two_slices(tables: Tables) -> None:
        limited(tables)
        rows = [tables["slices"][0], tables["slices"][-1]]
        bare = {"residual_m": None, "weight": None, "offset_east_m": None, "offset_north_m": None}
        tables["slices"] = [replace(row, **bare) for row in rows]
        bare = {"rmse_m": None, "mean_deviation_m": None, "n_slices": 2, "n_centres": 2, "iterations": None}
        tables["tilt"] = [replace(row, **bare) for row in tables["tilt"]]

    publish(ws, 2, two_slices)
    made = document(ws)
    profile = next(block for block in blocks(made) if isinstance(block, Chart) and block.name == "profile")
    assert profile.note == "An axis through two centres leaves no residuals: none are shown."
    table = next(block for block in blocks(made) if block.type == "table" and block.title == "Why these")
    place = table.head.index("off axis mm")
    assert [row[place] for row in table.rows] == ["--", "--"]


def test_without_a_covariance_the_uncertainty_is_said_to_be_missing(ws: Workspace) -> None:
    def bare(tables: Tables) -> None:
        names = ("lean_cov_ee", "lean_cov_en", "lean_cov_nn", "deviation_sigma_m", "tilt_sigma_deg")
        tables["tilt"] = [
            replace(row, azimuth_deg=None, azimuth_sigma_deg=None, **dict.fromkeys(names))
            for row in tables["tilt"]
        ]
        tables["axis_covariances"] = []
        limited(tables, verdict="cannot tell")

    publish(ws, 2, bare)
    made = document(ws)
    assert made.first.word == "CANNOT TELL"
    assert re.fullmatch(r"\d+\.\d ± -- mm", made.first.measured)
    text = text_of(made)
    assert "The deviation has no uncertainty." in text
    assert "± 0" not in text


def test_without_coverage_pairs_or_map_their_places_say_so(ws: Workspace) -> None:
    def bare(tables: Tables) -> None:
        limited(tables)
        for name in (
            "coverage",
            "pairs",
            "removals",
            "surface_map",
            "reference_leans",
            "axis_parameters",
            "stations",
        ):
            tables[name] = []

    publish(ws, 2, bare)
    made = document(ws)
    said = missing(made)
    assert said["What was seen of the shaft"] == "no coverage is stored for this epoch"
    assert said["Stations"] == "the epoch came as one registered cloud, without stations"
    assert said["Measured by other means"] == "no measurement by other means is stored for this epoch"
    assert said["The slices that fit worst"].startswith("no map of the wall is stored for these heights")
    assert "coverage" not in made.charts
    assert made.first.next_steps[-1].startswith("Check the lean once by other means")
    assert html_of(made)


def test_without_the_settings_of_the_run_the_id_stands_for_the_name(ws: Workspace) -> None:
    publish(ws, 2, limited)
    facts = replace(facts_of(ws), settings=None)
    assert facts.name == "chimney-01"
    made = document(ws, primary=("F", "paper"))
    assert made.first.word == "NO RESULT", "a primary without an axis is no result"


def test_an_unknown_epoch_is_refused_with_those_there_are(ws: Workspace) -> None:
    publish(ws, 2, limited)
    with pytest.raises(StorageError, match="holds no epoch 'e7' of chimney-01; stored: e0, e1"):
        document(ws, "e7")


def test_where_the_control_gave_no_axis_table_3_says_so(ws: Workspace) -> None:
    def bare(tables: Tables) -> None:
        limited(tables)
        tables["accuracy"] = []

    publish(ws, 2, bare)
    assert missing(document(ws))["Table 3: relative errors"] == "the control gave no axis in this epoch"


@pytest.mark.parametrize("language", ["en", "zh"])
def test_a_cloud_that_came_registered_is_not_called_scanned_from_stations(
    ws: Workspace, language: str
) -> None:
    def registered(tables: Tables) -> None:
        limited(tables)
        (row, *_others) = tables["stations"]
        nowhere = {"position_east_m": None, "position_north_m": None, "position_up_m": None}
        tables["stations"] = [replace(row, station="registered", start=REGISTERED, **nowhere)]

    publish(ws, 2, registered)
    words = words_of(language)
    made = document(ws, lang=language)
    said = json.dumps(asdict(made), default=str, ensure_ascii=False)
    assert words.said["method.text"][:20] not in said
    assert words.said["method.text_registered"][:20] in said
    assert "stations" not in made.charts
