"""Slices, the surface and points in a real browser: slide, keys and clicks lead on."""

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest
from playwright.sync_api import expect

from dashboard.view import Site
from storage.workspace import open_workspace
from tests.browser.conftest import Watched
from tests.browser.serving import serving
from tests.dashboard.test_point_pages import rows
from tests.storage.campaign import STRUCTURE, surface_map_row
from tests.storage.stored_points import keep_isolation, publish, wall

N = 40_000
BANDS = 10


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    ws = open_workspace(tmp_path_factory.mktemp("points") / "ws")
    keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    cells = [
        replace(
            surface_map_row("e0", 10.0 * i + 5.0, 1e-4 * (i - 18)), z_low_m=z, z_high_m=z + 10.0, z_m=z + 5.0
        )
        for z in (2.0 + 10.0 * band for band in range(BANDS))
        for i in range(36)
    ]
    publish(ws, "", n_points_used=N, slices=rows(), surface_map=cells)
    with serving(ws, {STRUCTURE: Site("Chimney", ("A", "paper"))}) as url:
        yield url


def test_arrow_keys_go_from_slice_to_slice(browser_page: Watched, address: str) -> None:
    page = browser_page.page
    page.goto(f"{address}/slice?slice=1&times=50")
    expect(page.locator("#panel-contour .main-svg").first).to_be_visible()
    page.keyboard.press("ArrowUp")
    expect(page.locator("#panel-place h2")).to_contain_text("z = 52.00 m")
    page.keyboard.press("ArrowDown")
    expect(page.locator("#panel-place h2")).to_contain_text("z = 27.00 m")
    assert page.url == f"{address}/slice?slice=1&times=50"


def test_the_slide_goes_to_a_slice_and_only_when_it_is_moved(browser_page: Watched, address: str) -> None:
    page = browser_page.page
    page.goto(f"{address}/slice")
    expect(page.locator("#panel-place h2")).to_contain_text("Slice 2 ")
    assert page.url == f"{address}/slice"
    slide = page.locator("#panel-place .dash-slider-root").bounding_box()
    assert slide is not None
    page.mouse.click(slide["x"] + slide["width"] - 12, slide["y"] + slide["height"] / 2)
    expect(page.locator("#panel-place h2")).to_contain_text("Slice 4 ")
    assert page.url == f"{address}/slice?slice=4"


def test_a_click_on_the_surface_opens_the_slice_nearest_in_height(
    browser_page: Watched, address: str
) -> None:
    page = browser_page.page
    page.goto(f"{address}/surface")
    area = page.locator("#panel-map .nsewdrag").first
    expect(area).to_be_visible()
    area.click(position={"x": 60, "y": 400})
    expect(page.locator("#page")).to_have_attribute("data-page", "slice")
    assert re.search(r"[?&]z=[\d.]+$", page.url)
    expect(page.locator("#panel-place h2")).to_contain_text(re.compile(r"Slice [01] "))


@pytest.mark.slow
@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("path", ["slice", "slice?slice=3", "surface", "cloud"])
def test_pages_of_points_load_cleanly_and_fit_the_screen(
    browser_page: Watched, address: str, path: str, width: int
) -> None:
    page = browser_page.page
    page.set_viewport_size({"width": width, "height": 800})
    page.goto(f"{address}/{path}")
    expect(page.locator("#page")).to_be_visible()
    page.wait_for_load_state("networkidle")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
