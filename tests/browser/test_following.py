"""An open page follows the pipeline; it is the last of its kind, since it changes the workspace of all."""

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Watched
from tests.browser.demo_site import CHIMNEY, HELD_BACK, DemoSite
from tests.browser.served import Served


@pytest.mark.slow
def test_an_epoch_that_is_published_appears_in_an_open_page(
    browser_page: Watched, dashboard: Served, demo_site: DemoSite
) -> None:
    page = browser_page.page
    page.goto(dashboard.at(f"/overview?structure={CHIMNEY}"))
    expect(page.locator("#epoch")).not_to_have_text(HELD_BACK)
    demo_site.publish_the_next()
    expect(page.locator("#epoch")).to_have_text(HELD_BACK, timeout=15_000)
