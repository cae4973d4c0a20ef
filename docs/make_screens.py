"""Take pictures of every page of the dashboard: `PYTHONPATH=. .venv/bin/python docs/make_screens.py`.

Simulates three structures with twelve epochs (what tests/browser does, with more points), opens each page in Debian's
Chromium at 1400 and at 400 pixels and writes docs/images/dashboard/PAGE-WIDTH.png. Takes some minutes.
With `--site DIR` the workspace is kept there and used again.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from dashboard.page import pages
from tests.browser.conftest import CHROMIUM, FLAGS
from tests.browser.demo_site import CHIMNEY, FAILED, TOWER, DemoSite, make_demo_site
from tests.browser.served import Served, serve_dashboard

ROOT = Path(__file__).resolve().parents[1]
WIDTHS = (1400, 400)
POINTS = 150_000
COLOURS = 200
DRAWN = "() => [...document.querySelectorAll('.dash-graph')].every(g => g.querySelector('.main-svg'))"


def main() -> None:
    """Make the workspace where it is missing, and take the pictures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--site", type=Path)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images" / "dashboard")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        root = asked.site or Path(temporary) / "site"
        if not (root / "workspace").exists():
            make_demo_site(root, points=POINTS, stations=8)
        site = DemoSite(root)
        asked.out.mkdir(parents=True, exist_ok=True)
        with serve_dashboard(site.campaign("chimney"), site.workspace) as served:
            _take_all(served, asked.out)


def _take_all(served: Served, out: Path) -> None:
    wanted = {name: f"/{name}?structure={CHIMNEY}" for name in pages()}
    wanted["slice"] += "&scheme=A&method=robust&slice=70"
    wanted["missing"] = f"/overview?structure={TOWER}&epoch={FAILED}"
    program = next(found for found in map(shutil.which, CHROMIUM) if found)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        for width in WIDTHS:
            page = browser.new_page(viewport={"width": width, "height": 900})
            for name, path in wanted.items():
                _take(page, served.at(path), out / f"{name}-{width}.png")
        browser.close()


def _take(page: Page, url: str, picture: Path) -> None:
    page.goto(url)
    page.wait_for_selector("#page")
    page.wait_for_function(DRAWN)
    page.wait_for_timeout(1500)
    page.screenshot(path=picture, full_page=True)
    with Image.open(picture) as whole:
        small = whole.convert("RGB").quantize(COLOURS)
    small.save(picture, optimize=True)
    print(picture.name)


if __name__ == "__main__":
    main()
