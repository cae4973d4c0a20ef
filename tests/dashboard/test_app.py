"""Pages and tables, asked for without a browser."""

import csv
import io
import json
from collections.abc import Iterator
from typing import Any

import pytest
from flask.testing import FlaskClient

from dashboard.app import make_app
from dashboard.page import pages
from dashboard.reader import Reader
from dashboard.view import Site
from storage.views import tilt_rows
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE

SITES = {STRUCTURE: Site("The <b>chimney</b>", ("A", "paper"))}


@pytest.fixture
def client(reader: Reader) -> FlaskClient:
    return make_app(reader.workspace, SITES).server.test_client()


def _page(client: FlaskClient, path: str, search: str = "") -> str:
    """What the frame asks the server for when it is at an address."""
    wanted = [{"id": "app", "property": "children"}, {"id": "stamp", "property": "data"}]
    request = {
        "output": "..app.children...stamp.data..",
        "outputs": wanted,
        "inputs": [
            {"id": "url", "property": "pathname", "value": path},
            {"id": "url", "property": "search", "value": search},
            {"id": "newer", "property": "data", "value": None},
        ],
        "changedPropIds": ["url.pathname"],
    }
    answer = client.post("/_dash-update-component", json=request)
    assert answer.status_code == 200, answer.text
    return json.dumps(answer.json, ensure_ascii=False)


def _texts(answer: Any) -> Iterator[str]:
    if isinstance(answer, dict):
        for value in answer.values():
            yield from _texts(value)
    elif isinstance(answer, list):
        for value in answer:
            yield from _texts(value)
    elif isinstance(answer, str):
        yield answer


@pytest.mark.parametrize("name", list(pages()))
def test_every_page_can_be_filled_from_a_small_catalog(client: FlaskClient, name: str) -> None:
    texts = list(_texts(json.loads(_page(client, f"/{name}"))))
    assert pages()[name].title in texts
    assert not {"This cannot be shown", "This page failed"} & set(texts)


@pytest.mark.parametrize("name", list(pages()))
def test_every_page_can_be_filled_for_the_first_epoch_alone(client: FlaskClient, name: str) -> None:
    texts = list(_texts(json.loads(_page(client, f"/{name}", "?epoch=e0"))))
    assert not {"This cannot be shown", "This page failed"} & set(texts)


def test_the_bar_says_the_deviation_of_the_catalog(client: FlaskClient, reader: Reader) -> None:
    row = reader.ask(tilt_rows, STRUCTURE, "e1")[0]
    assert f"{1e3 * row.deviation_m:.1f} ± {2e3 * row.deviation_sigma_m:.1f} mm" in _page(client, "/overview")


def test_a_page_that_is_not_there_is_answered_with_those_that_are(client: FlaskClient) -> None:
    assert "unknown page 'nowhere'; known: overview" in _page(client, "/nowhere")


def test_an_epoch_that_is_not_there_is_answered_with_those_that_are(
    client: FlaskClient,
) -> None:
    assert "unknown epoch 'e9'; known: e0, e1" in _page(client, "/overview", "?epoch=e9")


def test_a_workspace_without_epochs_says_what_to_do(ws: Workspace) -> None:
    client = make_app(ws, SITES).server.test_client()
    assert "Nothing is processed yet" in _page(client, "/")


def test_the_table_of_a_drawing_has_the_numbers_of_the_catalog(client: FlaskClient, reader: Reader) -> None:
    answer = client.get("/csv/overview/deviation?epoch=e1")
    assert answer.mimetype == "text/csv"
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    stored = reader.ask(tilt_rows, STRUCTURE)
    assert [row["epoch"] for row in rows] == [row.epoch for row in stored]
    assert [float(row["deviation_m"]) for row in rows] == [row.deviation_m for row in stored]
    # no limit holds there
    assert [row["allowable_m"] for row in rows] == ["", ""]


@pytest.mark.parametrize(
    "path",
    [
        "/csv/overview/nothing",
        "/csv/nowhere/deviation",
        "/csv/overview/deviation?epoch=e9",
        "/csv/alarms/list?state=x",
    ],
)
def test_a_table_that_is_not_there_is_not_found(client: FlaskClient, path: str) -> None:
    assert client.get(path).status_code == 404


def test_what_a_user_wrote_stays_text(client: FlaskClient) -> None:
    page = _page(client, "/overview")
    assert "The <b>chimney</b>" in page
    assert "dangerously" not in page
