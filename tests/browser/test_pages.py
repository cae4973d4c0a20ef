"""The dashboard in a real browser: every page loads cleanly, also where it has little to show."""

import pytest
from playwright.sync_api import expect

from dashboard.page import pages
from tests.browser.conftest import Watched
from tests.browser.demo_site import CHIMNEY, DEGRADED, FAILED, SILO, TOWER
from tests.browser.opened import open_page
from tests.browser.served import Served

# what is hard to show: a failed epoch, one that lost a station, one epoch without a limit, two slices, an earlier reference
PLACES = {
    "newest": f"structure={CHIMNEY}",
    "failed": f"structure={TOWER}&epoch={FAILED}",
    "degraded": f"structure={TOWER}&epoch={DEGRADED}",
    "alone": f"structure={SILO}",
    "two-slices": f"structure={CHIMNEY}&scheme=F&method=paper",
    "other-reference": f"structure={CHIMNEY}&epoch=2026-01&reference=2025-07",
}


QUICK = ("newest",)
"""Places at which every run of the tests looks; the slow ones look at all."""


@pytest.mark.parametrize(
    "place", [place if place in QUICK else pytest.param(place, marks=pytest.mark.slow) for place in PLACES]
)
@pytest.mark.parametrize("name", list(pages()))
def test_every_page_loads_without_an_error_and_asks_nobody_else(
    browser_page: Watched, dashboard: Served, name: str, place: str
) -> None:
    open_page(browser_page.page, dashboard, f"/{name}?{PLACES[place]}")
    expect(browser_page.page.locator("#page")).to_have_attribute("data-page", name)
    expect(browser_page.page.locator("h1")).to_have_text(pages()[name].title)


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("overview", "axis", "quality") else pytest.param(name, marks=pytest.mark.slow)
        for name in pages()
    ],
)
def test_on_a_telephone_nothing_stands_beside_the_screen(
    browser_page: Watched, dashboard: Served, name: str
) -> None:
    page = browser_page.page
    page.set_viewport_size({"width": 400, "height": 800})
    open_page(page, dashboard, f"/{name}?structure={CHIMNEY}")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 400
