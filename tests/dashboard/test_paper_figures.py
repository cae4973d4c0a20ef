"""Figures of the paper: from any workspace, the same bytes, whole or with a word about what is missing."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from dashboard.paper_figures import Subject, draw_figure, figure_names
from dashboard.paper_figures.fig5_contours import _about_the_circle, _taper
from dashboard.paper_figures.fig6_axes import _line
from dashboard.paper_figures.oblique import ObliqueView
from dashboard.paper_figures.schemes_shown import schemes_of
from storage.errors import UsageError
from storage.records import SchemeRow
from storage.views import epoch_rows, tilt_rows
from storage.views.shaft_points import ShaftPoints
from storage.workspace import Workspace, open_workspace
from tests.flows.calls import call
from tests.flows.stored_campaign import publish, publish_without_result, stored_campaign
from tests.storage.campaign import STRUCTURE, slice_row, tilt_row
from tests.storage.stored_scans import keep_scans, publish_scans

FIGURES = (3, 4, 5, 6)
HOSTILE = "</text><script>alert(1)</script> $\\frac{1}{0}$ \n& %%"


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """One workspace for all tests here, which only read it: schemes A, B and F, of which B failed."""
    ws = open_workspace(tmp_path_factory.mktemp("figures"))
    keep_scans(ws)
    state = dict(interval_m=1.0, thickness_m=0.01, contour="kasa", axis="irls", n_slices=5, n_centres=5)  # noqa: C408
    schemes = [
        SchemeRow(
            structure=STRUCTURE, epoch="e0", scheme=name, method="paper", state=now, reason=why, **state
        )
        for name, now, why in (("A", "ok", None), ("B", "failed", HOSTILE), ("F", "ok", None))
    ]
    tilt = [tilt_row("e0"), replace(tilt_row("e0"), scheme="F", azimuth_deg=None, deviation_sigma_m=None)]
    publish_scans(ws, schemes=schemes, tilt=tilt, slices=[slice_row("e0", index) for index in range(5)])
    return ws


def subject(ws: Workspace, title: str = "Heritage chimney") -> Subject:
    return Subject(epoch_rows(ws, STRUCTURE)[0], title, ("A", "paper"))


def test_every_figure_of_the_paper_is_found() -> None:
    assert tuple(figure_names()) == FIGURES


@pytest.mark.parametrize("file_format", ["png", "svg"])
@pytest.mark.parametrize("number", FIGURES)
def test_the_same_results_give_the_same_bytes(filled: Workspace, number: int, file_format: str) -> None:
    first, second = (draw_figure(filled, subject(filled), number, file_format) for _ in range(2))
    assert first == second
    assert b"Date" not in first[:2000]


@pytest.mark.parametrize("number", FIGURES)
def test_hostile_names_stay_text(filled: Workspace, number: int) -> None:
    drawn = draw_figure(filled, subject(filled, HOSTILE), number, "svg").decode()
    # words are drawn as paths; what the file says of them are comments and ids
    assert "<script" not in re.sub(r"<!--.*?-->", "", drawn, flags=re.DOTALL)


def test_an_unknown_figure_or_format_is_answered_with_the_known_ones(filled: Workspace) -> None:
    with pytest.raises(UsageError, match="unknown figure 9; known: 3, 4, 5, 6, all"):
        draw_figure(filled, subject(filled), 9, "png")
    with pytest.raises(UsageError, match="'jpg'; known: png, svg"):
        draw_figure(filled, subject(filled), 3, "jpg")


def test_a_scheme_that_failed_keeps_its_place_with_the_reason(filled: Workspace) -> None:
    schemes = schemes_of(filled, subject(filled))
    assert [(one.label, one.axis is None) for one in schemes.shown] == [
        ("A/paper", False),
        ("B/paper", True),
        ("F/paper", False),
    ]
    assert schemes.shown[1].reason == HOSTILE


def test_the_drawn_axis_is_off_plumb_by_the_deviation_of_the_catalog(filled: Workspace) -> None:
    schemes = schemes_of(filled, subject(filled))
    foot, top = _line(tilt_rows(filled, STRUCTURE)[0], schemes)
    assert foot == pytest.approx(0.0, abs=1e-9)
    assert top == pytest.approx(1e3 * tilt_rows(filled, STRUCTURE)[0].deviation_m)


def test_points_on_the_surface_of_a_leaning_cone_are_drawn_on_the_circle(filled: Workspace) -> None:
    """Lean and taper within a thick slice are no scatter of its points."""
    shown = schemes_of(filled, subject(filled)).shown[0]
    slices = [
        replace(
            row,
            radius_m=4.0 - 0.02 * row.z_m,
            center_east_m=0.01 + 0.007 * row.z_m,
            center_north_m=-0.02 - 0.0057 * row.z_m,
        )
        for row in shown.slices
    ]
    shown = replace(shown, slices=slices)
    top = replace(slices[-1], thickness_m=4.0)
    assert _taper(slices) == pytest.approx(-0.02)
    angle = np.linspace(0.0, 6.0, 50)
    z = np.linspace(top.z_m - 2.0, top.z_m + 2.0, 50)
    radius = 4.0 - 0.02 * z
    points = np.column_stack(
        [0.01 + 0.007 * z + radius * np.cos(angle), -0.02 - 0.0057 * z + radius * np.sin(angle), z]
    )
    shaft = ShaftPoints(STRUCTURE, "e0", points, np.zeros(50, np.uint16), ("ST01",))
    drawn = _about_the_circle(shaft, top, shown, 100.0)
    assert np.hypot(*drawn.T) == pytest.approx(np.full(50, top.radius_m), abs=1e-9)


def test_a_view_from_the_south_has_east_to_the_right_and_north_behind() -> None:
    right, up, towards = ObliqueView(180.0, 0.0).seen(np.eye(3)).T
    np.testing.assert_allclose(right, [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(up, [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(towards, [0.0, -1.0, 0.0], atol=1e-12)


def test_a_view_from_above_keeps_lengths() -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(20, 3))
    seen = ObliqueView(200.0, 24.0).seen(points)
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), np.linalg.norm(points, axis=1))


def test_the_command_writes_all_figures_and_says_which(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    stored = stored_campaign(tmp_path)
    publish(stored, "e1", 0)
    called = call(capsys, "figures", stored.file, "--out", tmp_path / "out", "--json")
    assert called.code == 0
    assert [Path(name).name for name in called.answer["figures"]] == [
        f"{name}.png" for name in figure_names().values()
    ]
    with Image.open(called.answer["figures"][0]) as image:
        assert image.width == 1417


def test_a_failed_epoch_is_drawn_when_it_is_named_and_passed_over_when_not(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    stored = stored_campaign(tmp_path)
    publish(stored, "e1", 0)
    publish_without_result(stored, "e2", 1, state="failed", reason="no scan", n_points_used=0)
    words = ("figures", stored.file, "--out", tmp_path, "--json")
    assert call(capsys, *words, "--figure", "6").answer["epoch"] == "e1"
    assert call(capsys, *words, "--epoch", "e2").answer["epoch"] == "e2"


def test_the_command_answers_wrong_words_with_the_known_ones(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    stored = stored_campaign(tmp_path)
    publish(stored, "e1", 0)
    called = call(capsys, "figures", stored.file, "--figure", "7")
    assert (called.code, "known: 3, 4, 5, 6, all" in called.err) == (2, True)
    called = call(capsys, "figures", stored.file, "--epoch", "e7")
    assert (called.code, "in the workspace: e1" in called.err) == (2, True)
