"""The dashboard in a real browser: its numbers are the catalog's, a click leads on, the address says what is shown."""

import re

import pytest
from playwright.sync_api import expect

from dashboard import numbers
from dashboard.page import pages
from storage.views import tilt_rows
from storage.workspace import existing_workspace
from tests.browser.conftest import Watched
from tests.browser.demo_site import CHIMNEY, FAILED, SILO, TOWER, DemoSite
from tests.browser.opened import open_page
from tests.browser.served import Served

PRIMARY = ("S", "surface")


def test_the_numbers_on_the_screen_are_those_of_the_catalog(
    browser_page: Watched, dashboard: Served, demo_site: DemoSite
) -> None:
    ws = existing_workspace(demo_site.workspace)
    for structure, epoch in ((CHIMNEY, "2025-04"), (TOWER, "2025-04"), (SILO, "2025-01")):
        row = next(row for row in tilt_rows(ws, structure, epoch) if (row.scheme, row.method) == PRIMARY)
        open_page(browser_page.page, dashboard, f"/overview?structure={structure}&epoch={epoch}")
        expect(browser_page.page.locator("#deviation")).to_have_text(
            numbers.mm_with_u(row.deviation_m, row.deviation_sigma_m)
        )
        expect(browser_page.page.locator("#limit")).to_have_text(numbers.mm(row.allowable_m))
        open_page(browser_page.page, dashboard, f"/profile?structure={structure}&epoch={epoch}")
        expect(browser_page.page.locator("#panel-numbers")).to_contain_text(numbers.dms(row.tilt_deg))


def test_the_points_that_are_drawn_are_those_of_the_catalog(
    browser_page: Watched, dashboard: Served, demo_site: DemoSite
) -> None:
    ws = existing_workspace(demo_site.workspace)
    rows = [row for row in tilt_rows(ws, TOWER) if (row.scheme, row.method) == PRIMARY]
    open_page(browser_page.page, dashboard, f"/overview?structure={TOWER}")
    drawn = browser_page.page.evaluate(
        "() => document.querySelector('#panel-deviation .js-plotly-plot').data.filter(t => t.customdata).map(t => [...t.y])"
    )
    assert drawn[0] == pytest.approx([1e3 * row.deviation_m for row in rows])


def test_what_is_missing_is_shown_as_missing_with_its_reason(
    browser_page: Watched, dashboard: Served
) -> None:
    page = browser_page.page
    open_page(page, dashboard, f"/overview?structure={TOWER}&epoch={FAILED}")
    expect(page.locator("#deviation")).to_have_text("--")
    expect(page.locator("#verdict")).to_contain_text("NO RESULT")
    expect(page.locator("#panel-limit")).to_contain_text("came a file of 200 bytes")
    open_page(page, dashboard, f"/overview?structure={SILO}")
    expect(page.locator("#state")).to_contain_text("NO LIMIT")
    expect(page.locator("#limit")).to_have_text("--")
    expect(page.locator("#panel-change")).to_contain_text("one epoch only")
    expect(page.locator("body")).not_to_contain_text(re.compile(r"\b(None|nan|NaN|undefined)\b"))


def test_names_of_the_user_stay_text(browser_page: Watched, dashboard: Served) -> None:
    with_silo = f"/overview?structure={SILO}"
    open_page(browser_page.page, dashboard, with_silo)
    # its campaign file is not the one that was opened: it goes by its id
    expect(browser_page.page.locator(".name")).to_have_text(SILO)


def test_a_click_on_a_centre_opens_its_slice(browser_page: Watched, dashboard: Served) -> None:
    page = browser_page.page
    open_page(page, dashboard, f"/profile?structure={CHIMNEY}&scheme=A&method=robust")
    points = page.locator("#panel-axis .js-plotly-plot .xy .scatterlayer .trace").last.locator(".point")
    expect(points.first).to_be_visible()
    points.nth(5).click(force=True)
    expect(page.locator("#page")).to_have_attribute("data-page", "slice")
    assert re.search(r"[?&]slice=\d+", page.url)


def test_choices_go_into_the_address_and_links_keep_them(browser_page: Watched, dashboard: Served) -> None:
    page = browser_page.page
    open_page(page, dashboard, f"/overview?structure={CHIMNEY}")
    page.locator("#choose-epoch").click()
    page.get_by_role("option", name="2025-07", exact=True).click()
    expect(page.locator("#epoch")).to_have_text("2025-07")
    assert "epoch=2025-07" in page.url
    page.locator("#to-series").click()
    expect(page.locator("h1")).to_have_text(pages()["series"].title)
    assert "epoch=2025-07" in page.url
    page.go_back()
    expect(page.locator("h1")).to_have_text(pages()["overview"].title)


def test_another_scheme_shows_a_slice_of_its_own(browser_page: Watched, dashboard: Served) -> None:
    page = browser_page.page
    open_page(page, dashboard, f"/slice?structure={CHIMNEY}&scheme=A&method=robust&slice=70")
    page.locator("#choose-result").click()
    page.get_by_role("option", name="B/robust", exact=True).click()
    page.wait_for_url(lambda url: "scheme=B" in url and "slice=" not in url)
    expect(page.locator("#page")).to_have_attribute("data-page", "slice")


def test_keys_turn_pages_and_epochs(browser_page: Watched, dashboard: Served) -> None:
    page = browser_page.page
    open_page(page, dashboard, f"/overview?structure={CHIMNEY}&epoch=2025-07")
    page.keyboard.press("[")
    expect(page.locator("#epoch")).to_have_text("2025-04")
    page.keyboard.press("]")
    expect(page.locator("#epoch")).to_have_text("2025-07")
    page.keyboard.press("3")
    expect(page.locator("h1")).to_have_text(pages()["profile"].title)


@pytest.mark.slow
def test_every_table_can_be_had_as_csv(browser_page: Watched, dashboard: Served) -> None:
    page = browser_page.page
    for name in pages():
        open_page(page, dashboard, f"/{name}?structure={CHIMNEY}")
        for href in page.locator("a.csv").evaluate_all("links => links.map(link => link.href)"):
            answer = page.request.get(href)
            assert answer.status == 200, href
            lines = answer.text().splitlines()
            assert len(lines) > 1, href
