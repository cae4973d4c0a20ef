"""compare-schemes, and reference measurements beside ours in compare."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.records import ReferenceLeanRow, SliceRow, TiltRow
from storage.views import scheme_comparison_rows
from tasks.scheme_comparison import EpochAxes, compare_schemes
from tests.flows.calls import call
from tests.flows.stored_campaign import Stored, publish, stored_campaign
from tests.storage.campaign import epoch_tables, fill, reference_lean_row, slice_row, tilt_row

N_SLICES = {"A": 101, "C": 11, "E": 2}
LEAN = (0.007, -0.0057)
POINT_VARIANCE = {"A": 1e-11, "C": 3e-11, "E": 4e-10}
POSES = 4e-10
STATION = "total station"


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    made = stored_campaign(tmp_path)
    fill(made.workspace, 0)
    return made


def scheme_rows(epoch: str, number: int, scheme: str, off: float) -> tuple[TiltRow, list[SliceRow]]:
    points = POINT_VARIANCE[scheme]
    row = tilt_row(epoch, number, (LEAN[0] + off, LEAN[1]), scheme=scheme, n_slices=N_SLICES[scheme])
    stated = {
        "lean_cov_ee": POSES + points,
        "lean_cov_en": 0.0,
        "lean_cov_nn": POSES + points,
        "point_cov_ee": points,
        "point_cov_nn": points,
    }
    step_m = 100.0 / (N_SLICES[scheme] - 1)
    slices = [
        replace(slice_row(epoch, i), scheme=scheme, z_m=2.005 + i * step_m) for i in range(N_SLICES[scheme])
    ]
    return replace(row, n_centres=N_SLICES[scheme], **stated), slices


def publish_schemes(
    stored: Stored,
    epoch: str,
    number: int,
    offs: dict[str, float],
    references: Sequence[ReferenceLeanRow] = (),
) -> None:
    made = [scheme_rows(epoch, number, scheme, off) for scheme, off in offs.items()]
    tables = epoch_tables(epoch, number, LEAN)
    tilt, slices = [row for row, _ in made], [one for _, several in made for one in several]
    axes = EpochAxes("chimney-01", epoch, tilt, slices, references)
    tables |= {"tilt": tilt, "slices": slices, "accuracy": [], "reference_leans": list(references)}
    tables["scheme_comparison"] = compare_schemes(axes, "A/paper")
    publish_epoch(stored.workspace, "chimney-01", epoch, tables)
    rebuild_catalog(stored.workspace)


def station(epoch: str, number: int, east: float = LEAN[0], sigma: float = 5e-5) -> ReferenceLeanRow:
    return reference_lean_row(epoch, number, lean_east=east, lean_north=LEAN[1], sigma=sigma)


def test_terminal_shows_workload_differences_and_the_recommendation(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish_schemes(stored, "e1", 0, {"A": 0.0, "C": 2e-6, "E": 1e-5}, [station("e1", 0)])
    called = call(capsys, "compare-schemes", stored.file)
    assert (called.code, called.err) == (0, "")
    lines = called.out.splitlines()
    assert lines[0] == "Heritage chimney, epoch e1, at 102 m"
    (chosen,) = [line for line in lines if "<- recommended" in line]
    assert chosen.split()[:5] == ["C/paper", "<-", "recommended", "11", "0.1"]
    (difference,) = [line for line in lines if line.startswith("C/paper - A/paper")]
    # sigma of the difference: sqrt(3e-11 - 1e-11) * 102 m = 0.46 mm, about, by slices that are shared
    assert difference.split()[3:5] == ["+0.20", "+0.00"]
    assert difference.split()[-1] == "no"
    (measured,) = [line for line in lines if line.startswith("total station - A/paper")]
    # sqrt(25e-10 + 4.1e-10) * 102 m
    assert measured.split()[-3] == "5.50"
    (advice,) = [line for line in lines if line.startswith("recommendation: ")]
    assert advice == (
        "recommendation: 11 slices (C/paper) are enough here: sigma 2 % above that of A/paper, no significant difference"
    )
    assert any(line.startswith("- not enough: 2 slices (E/paper): 2 centres: a bad slice") for line in lines)


def test_the_answer_holds_the_stored_rows(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish_schemes(stored, "e1", 0, {"A": 0.0, "C": 2e-6}, [station("e1", 0)])
    answer = call(capsys, "compare-schemes", stored.file, "e1", "--json").answer
    assert (answer["ok"], answer["recommended"], answer["recommended_slices"]) == (True, "C/paper", 11)
    assert [row["compared"] for row in answer["comparison"]] == ["A/paper", "C/paper", STATION]
    rows = scheme_comparison_rows(stored.workspace, "chimney-01", "e1")
    assert [row["d_cov_ee"] for row in answer["comparison"]] == [row.d_cov_ee for row in rows]
    assert (answer["pairs"], answer["over_epochs"]) == ([], [])


def test_pairs_and_another_base_are_shown_on_request(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish_schemes(stored, "e1", 0, {"A": 0.0, "C": 2e-6, "E": 1e-5}, [station("e1", 0)])
    called = call(capsys, "compare-schemes", stored.file, "--against", STATION, "--pairs", "--json")
    assert {row["against"] for row in called.answer["comparison"]} == {STATION}
    assert [(row["compared"], row["against"]) for row in called.answer["pairs"]] == [
        ("C/paper", "A/paper"),
        ("E/paper", "A/paper"),
        (STATION, "A/paper"),
        ("E/paper", "C/paper"),
        (STATION, "C/paper"),
        (STATION, "E/paper"),
    ]


def test_over_the_epochs_bias_and_scatter_are_told(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    for number, off in enumerate((1e-6, 3e-6)):
        publish_schemes(stored, f"e{number + 1}", number, {"A": 0.0, "C": off})
    called = call(capsys, "compare-schemes", stored.file)
    assert called.out.startswith("Heritage chimney, epoch e2, ")
    line = [line for line in called.out.splitlines() if line.startswith("C/paper - A/paper ")][-1]
    # mean 2e-6, scatter of one component sqrt(2 * 1e-6^2 / 2) = 1e-6
    assert line.split()[3:7] == ["2", "+0.20", "+0.00", "0.10"]
    answer = call(capsys, "compare-schemes", stored.file, "--json").answer
    assert answer["over_epochs"][0]["agreement"]["scatter"] == pytest.approx(1e-6)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["e3"], 2, "unknown epoch 'e3'; known: e1, e2"),
        (["--against", "B/robust"], 2, "epoch e1 has no axis 'B/robust'; known: A/paper, C/paper"),
        (["e2"], 3, "no scheme has an axis in e2; `tiltwatch run"),
    ],
)
def test_what_there_is_not_is_answered_with_what_there_is(
    capsys: pytest.CaptureFixture[str], stored: Stored, words: list[str], code: int, message: str
) -> None:
    publish_schemes(stored, "e1", 0, {"A": 0.0, "C": 2e-6})
    called = call(capsys, "compare-schemes", stored.file, *words)
    assert called.code == code
    assert message in called.err


def test_compare_shows_what_others_measured_in_both_epochs(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish_schemes(stored, "e1", 0, {"A": 0.0}, [station("e1", 0), replace(station("e1", 0), source="GNSS")])
    publish_schemes(stored, "e2", 1, {"A": 0.0}, [station("e2", 1, LEAN[0] + 0.05 / 102.0)])
    called = call(capsys, "compare", stored.file, "e2", "e1")
    line = next(line for line in called.out.splitlines() if line.startswith(STATION))
    # sqrt(2) * 5e-5 * 102 m = 7.21 mm
    assert line.startswith(
        "total station (reference): 50.00 ± 14.42 mm (k=2), east +50.00 mm, north +0.00 mm, "
    )
    assert "significant (p < 0.0001" in line
    assert "GNSS" not in called.out
    answer = call(capsys, "compare", stored.file, "e2", "e1", "--json").answer
    assert [(row["source"], row["significant"]) for row in answer["references"]] == [(STATION, True)]
    assert [row["scheme"] for row in answer["changes"]] == ["A"]


def test_references_alone_can_be_compared(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish_schemes(stored, "e1", 0, {}, [station("e1", 0)])
    publish_schemes(stored, "e2", 1, {"A": 0.0}, [station("e2", 1)])
    called = call(capsys, "compare", stored.file, "e2", "e1")
    assert called.code == 0
    assert "not significant (p = 1; " in called.out


def test_epochs_without_stored_comparison_are_compared_anew(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0)
    answer = call(capsys, "compare-schemes", stored.file, "--json").answer
    assert [row["compared"] for row in answer["comparison"]] == ["A/paper", "F/paper"]
