"""Twenty visitors at once for a minute, while the pipeline writes."""

import shutil
import threading
import time
from pathlib import Path

import pytest

from dashboard.page import pages
from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.workspace import Workspace, existing_workspace
from tests.browser.demo_site import CHIMNEY, TOWER, DemoSite
from tests.browser.served import serve_dashboard
from tests.browser.visitors import Visitor
from tests.storage.campaign import epoch_tables

VISITORS = 20
SECONDS = 60.0


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_twenty_visitors_for_a_minute_see_no_error_while_the_pipeline_writes(
    demo_site: DemoSite, tmp_path: Path
) -> None:
    shutil.copytree(demo_site.root, tmp_path / "site", ignore=shutil.ignore_patterns("prefect", "locks"))
    site = DemoSite(tmp_path / "site")
    ws = existing_workspace(site.workspace)
    paths = [f"/{name}?structure={structure}" for name in pages() for structure in (CHIMNEY, TOWER)]
    over = threading.Event()
    writer = threading.Thread(target=_keep_publishing, args=(ws, over))
    with serve_dashboard(site.campaign("chimney"), site.workspace) as served:
        visitors = [Visitor(served.url, paths[n % len(paths) :] + paths, SECONDS) for n in range(VISITORS)]
        writer.start()
        runner = threading.Thread(target=site.publish_the_next)
        runner.start()
        for visitor in visitors:
            visitor.start()
        for visitor in visitors:
            visitor.join(SECONDS + 60.0)
        over.set()
        writer.join(60.0)
        runner.join(200.0)
    assert [line for visitor in visitors for line in visitor.wrong] == []
    assert all(len(visitor.took_s) > 1 for visitor in visitors)
    assert not any(thread.is_alive() for thread in (*visitors, writer, runner))


def _keep_publishing(ws: Workspace, over: threading.Event) -> None:
    """Publish made-up epochs and make the catalog anew, again and again."""
    number = 0
    while not over.is_set():
        publish_epoch(ws, CHIMNEY, f"made-up-{number}", epoch_tables(f"made-up-{number}", number % 5))
        rebuild_catalog(ws)
        number += 1
        time.sleep(1.0)
