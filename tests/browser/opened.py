"""A page of the dashboard, opened and drawn."""

from playwright.sync_api import Page, expect

from tests.browser.served import Served


def open_page(page: Page, served: Served, path: str) -> None:
    """Open an address, and wait until the page and its drawings are there."""
    page.goto(served.at(path))
    expect(page.locator("#page")).to_be_visible()
    # drawings come after the frame
    page.wait_for_function(
        "() => [...document.querySelectorAll('.dash-graph')].every(g => g.querySelector('.main-svg'))"
    )
