"""A real browser, a workspace to look at and the dashboard over it; each is started by the tests and stopped by its id."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from tests.browser.demo_site import DemoSite, make_demo_site
from tests.browser.served import Served, serve_dashboard
from tests.made_once import made_once
from tests.shared import unavailable

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-quic",
    "--no-first-run",
    # a name is looked up nowhere: a request elsewhere fails and is seen
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
]


@dataclass
class Watched:
    """A page and all that went wrong in it."""

    page: Page
    wrong: list[str] = field(default_factory=list)

    def watch(self) -> None:
        """Note errors of the console, answers of 400 and above, and requests that leave this machine."""
        self.page.on("console", lambda m: self._note(f"console: {m.text}") if m.type == "error" else None)
        self.page.on("pageerror", lambda fault: self._note(f"page: {fault}"))
        self.page.on("response", lambda r: self._note(f"{r.status} {r.url}") if r.status >= 400 else None)
        self.page.on("request", lambda r: None if _is_ours(r.url) else self._note(f"request to {r.url}"))

    def _note(self, text: str) -> None:
        self.wrong.append(text)


def _is_ours(url: str) -> bool:
    return url.startswith(("http://127.0.0.1:", "data:", "blob:"))


# of a module: its event loop must not be there for tests of other kinds in the same process
@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    """Debian's Chromium without a window; skipped where there is none, but never in CI."""
    program = next((found for found in map(shutil.which, CHROMIUM) if found), None)
    if program is None:
        unavailable(
            "no Chromium on this machine; `apt-get install chromium` has these tests run (.ci/run does)"
        )
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def browser_page(chromium: Browser) -> Iterator[Watched]:
    """A fresh page of 1400 pixels; the test fails at its end if anything went wrong in it."""
    context = chromium.new_context(viewport={"width": 1400, "height": 900})
    watched = Watched(context.new_page())
    watched.page.set_default_timeout(30_000)
    watched.watch()
    yield watched
    context.close()
    assert watched.wrong == []


@pytest.fixture(scope="session")
def demo_site(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> DemoSite:
    """Three structures and twelve epochs; run once, whichever of the workers comes first."""
    assert prefect_api
    return DemoSite(made_once(tmp_path_factory, "demo-site", make_demo_site))


@pytest.fixture(scope="session")
def dashboard(demo_site: DemoSite) -> Iterator[Served]:
    """The dashboard over it."""
    with serve_dashboard(demo_site.campaign("chimney"), demo_site.workspace) as served:
        yield served
