"""What the dashboard takes: the first visit and the next ones in a real browser, and twenty visitors at once."""

import statistics
import tempfile
import time
from pathlib import Path
from typing import Final

from playwright.sync_api import BrowserContext, sync_playwright

from benchmarks.results.section import Section
from benchmarks.results.whole_run import campaign_of, timed_run
from dashboard.page import pages
from tests.browser.served import serve_dashboard
from tests.browser.visitors import Visitor

REPEATS: Final = 3
VISITORS: Final = 20
SECONDS: Final = 60.0
CHROMIUM: Final = "/usr/bin/chromium"
FLAGS: Final = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]

DRAWN: Final = """() => {
  const plots = [...document.querySelectorAll('.js-plotly-plot')];
  return plots.length >= 3 && plots.every(plot => plot.querySelector('.xtick'));
}"""
"""The overview has three drawings; one that is drawn has ticks."""


def visits(folder: Path, points: int) -> Section:
    """Open the dashboard of a small campaign, then send twenty visitors through all pages."""
    campaign, workspace = campaign_of(folder, points, epochs=4), folder / "seen"
    timed_run(campaign, workspace)
    rows = []
    for number in range(REPEATS):
        with serve_dashboard(campaign, workspace) as served:
            first, second, third = _three_visits(served.url)
        rows.append(
            [
                f"server and browser started anew, {number + 1}",
                f"{first:.2f}",
                f"{second:.2f}",
                f"{third:.2f}",
            ]
        )
    with serve_dashboard(campaign, workspace) as served:
        rows.append(_crowd(served.url))
    return Section(
        "The dashboard",
        f"python -m benchmarks.results dashboard --points {points}",
        "Seconds from asking for the address until all drawings of the overview are drawn, in headless Chromium with an "
        f"empty profile, on the same machine; the last line: {VISITORS} visitors for a minute through all pages "
        "(what a browser asks for, without one): median, 95 % and largest time of a page, and how many.",
        ["", "first visit, s", "second, s", "third, s"],
        rows,
    )


def _three_visits(url: str) -> list[float]:
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as profile:
        context = playwright.chromium.launch_persistent_context(profile, executable_path=CHROMIUM, args=FLAGS)
        took = [_visit(context, url) for _ in range(3)]
        context.close()
    return took


def _visit(context: BrowserContext, url: str) -> float:
    page = context.new_page()
    began = time.perf_counter()
    page.goto(url, wait_until="commit")
    page.wait_for_function(DRAWN, polling=50)
    took = time.perf_counter() - began
    page.close()
    return took


def _crowd(url: str) -> list[str]:
    paths = [f"/{name}" for name in pages()]
    crowd = [Visitor(url, paths[n % len(paths) :] + paths, SECONDS) for n in range(VISITORS)]
    for visitor in crowd:
        visitor.start()
    for visitor in crowd:
        visitor.join()
    wrong = sum(len(visitor.wrong) for visitor in crowd)
    took = sorted(second for visitor in crowd for second in visitor.took_s)
    return [
        f"{VISITORS} visitors, {len(took)} pages, {wrong} errors",
        f"{statistics.median(took):.2f}",
        f"{took[int(0.95 * len(took))]:.2f}",
        f"{took[-1]:.2f}",
    ]
