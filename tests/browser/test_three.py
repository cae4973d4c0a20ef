"""The page in three dimensions in a real browser, drawn without a graphics card."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from dashboard.view import Site
from storage.artifacts import artifact_path
from storage.records import SurfaceMapRow
from storage.workspace import open_workspace
from tests.browser.conftest import Watched
from tests.browser.serving import serving
from tests.storage.campaign import STRUCTURE, surface_map_row
from tests.storage.stored_points import keep_isolation, publish, wall

N = 120_000
DRAWN = 100_000
HOSTILE = "Chimney <img src=x onerror=document.title='bad'>"
READY = "() => window.__ready || window.__failed"

SHARE_DRAWN = """
() => new Promise((done) => {
  // the page draws in the next frame; in the same frame the picture can still be read
  dispatchEvent(new Event("resize"));
  requestAnimationFrame(() => {
    const view = document.getElementById("view"), canvas = document.createElement("canvas");
    canvas.width = view.width; canvas.height = view.height;
    const pen = canvas.getContext("2d");
    pen.drawImage(view, 0, 0);
    const data = pen.getImageData(0, 0, canvas.width, canvas.height).data;
    let seen = 0;
    for (let at = 3; at < data.length; at += 4) seen += data[at] > 0;
    done(seen / (canvas.width * canvas.height));
  });
})
"""


def cells() -> list[SurfaceMapRow]:
    return [surface_map_row("e0", 10.0 * i + 5.0, 1e-4 * (i - 18)) for i in range(36)]


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    ws = open_workspace(tmp_path_factory.mktemp("three") / "ws")
    keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    publish(ws, "", n_points_used=N, surface_map=cells())
    with serving(ws, {STRUCTURE: Site(HOSTILE, ("A", "paper"))}) as url:
        yield url


def opened(browser_page: Watched, address: str) -> Watched:
    browser_page.page.goto(address)
    browser_page.page.wait_for_function(READY, timeout=60_000)
    return browser_page


def test_it_draws_a_hundred_thousand_points_and_asks_nobody_else(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?structure={STRUCTURE}&points={DRAWN}")
    assert watched.page.evaluate("[window.__ready, window.__points]") == [True, DRAWN]
    assert watched.page.locator("#count").inner_text().startswith("100,000 points of 120,000")


def test_names_are_shown_as_they_are(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?points=1000")
    assert watched.page.locator("#name").inner_text() == HOSTILE
    assert watched.page.title() == f"{HOSTILE} e0, 3D"
    assert watched.page.locator("img").count() == 0


def test_keys_choose_camera_colour_and_how_large_the_lean_is(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?points=1000")
    page = watched.page
    assert page.locator("#times-told").inner_text() == "×10"
    for key in ("1", "+", "c"):
        page.keyboard.press(key)
    assert page.locator("#times-told").inner_text() == "×20"
    assert page.evaluate("location.hash") == "#times=20&colour=station&camera=along"
    assert page.locator("#legend .key").all_inner_texts() == ["ST01", "ST02"]


def test_what_is_in_the_address_is_what_is_drawn(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?points=1000#times=2&colour=height&camera=top")
    assert watched.page.locator("#times-told").inner_text() == "×2"
    assert watched.page.locator("button[aria-pressed=true]").all_inner_texts() == ["height"]


def test_clipping_by_height_leaves_less_to_see(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?points={DRAWN}")
    page = watched.page
    whole = drawn_share(watched)
    page.locator("#clip-low").evaluate(
        "(slide) => { slide.value = 60; slide.dispatchEvent(new Event('input')); }"
    )
    assert page.locator("#clip-told").inner_text().startswith("z 61.0 to")
    assert drawn_share(watched) < 0.8 * whole


def drawn_share(watched: Watched) -> float:
    """Share of the picture that something was drawn on."""
    return float(watched.page.evaluate(SHARE_DRAWN))


def test_the_way_back_leads_to_the_same_epoch(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?structure={STRUCTURE}&epoch=e0&points=1000")
    watched.page.locator("#back").click()
    watched.page.wait_for_selector("#page")
    assert watched.page.url == f"{address}/overview?structure={STRUCTURE}&epoch=e0"


def test_the_dashboard_shows_it_in_its_frame(browser_page: Watched, address: str) -> None:
    browser_page.page.goto(f"{address}/cloud")
    frame = browser_page.page.frame_locator("iframe")
    frame.locator("#panel").wait_for(timeout=60_000)
    assert frame.locator("#back").is_hidden()


def test_an_epoch_that_is_not_there_is_said(browser_page: Watched, address: str) -> None:
    watched = opened(browser_page, f"{address}/3d?epoch=e9")
    assert "unknown epoch 'e9'; known: e0" in watched.page.locator("#message").inner_text()
    forgive_not_found(watched)


def test_points_that_are_gone_are_said(browser_page: Watched, tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    ref = keep_isolation(ws, *wall(1000), ("ST01", "ST02"))
    publish(ws, "", n_points_used=1000)
    artifact_path(ws, ref).unlink()
    with serving(ws, {}) as url:
        watched = opened(browser_page, f"{url}/3d")
        assert "tiltwatch run FILE --epoch" in watched.page.locator("#message").inner_text()
        assert watched.page.locator("#panel").is_hidden()
        forgive_not_found(watched)


def forgive_not_found(watched: Watched) -> None:
    """Take out what the test asked for: answers of 404 and what the console says of them."""
    watched.page.wait_for_load_state("networkidle")
    assert watched.wrong
    watched.wrong[:] = [each for each in watched.wrong if "404" not in each]
