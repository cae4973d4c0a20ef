"""What the page in three dimensions asks for."""

from dataclasses import replace

import numpy as np
import pytest
from flask import Flask
from flask.testing import FlaskClient

from dashboard.content.cloud import HEADER, mixed_rows
from dashboard.reader import Reader
from dashboard.three.routes import MOST_POINTS, three_routes
from dashboard.view import Site
from storage.artifacts import artifact_path
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, station_row
from tests.storage.stored_points import keep_isolation, publish, wall

N = 3000
HOSTILE = '</script><img src=x onerror="alert(1)">'


def client_of(ws: Workspace, name: str = "Chimney") -> FlaskClient:
    app = Flask(__name__)
    app.register_blueprint(three_routes(Reader(ws), {STRUCTURE: Site(name, ("A", "paper"))}))
    return app.test_client()


@pytest.fixture
def shaft_ws(ws: Workspace) -> Workspace:
    keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    publish(ws, "", n_points_used=N)
    return ws


@pytest.fixture
def client(shaft_ws: Workspace) -> FlaskClient:
    return client_of(shaft_ws)


def test_the_points_are_those_of_the_epoch(client: FlaskClient) -> None:
    answer = client.get(f"/3d/points.bin?structure={STRUCTURE}&epoch=e0")
    assert (answer.status_code, answer.mimetype) == (200, "application/octet-stream")
    n, whole, *origin = HEADER.unpack_from(answer.data)[2:]
    assert (n, whole) == (N, N)
    places = np.frombuffer(answer.data, "<f4", 3 * n, HEADER.size).reshape(n, 3)
    np.testing.assert_allclose(places + origin, wall(N)[0][mixed_rows(N, N)], rtol=0, atol=1e-5)


def test_so_many_points_are_sent_as_are_asked_for(client: FlaskClient) -> None:
    answer = client.get("/3d/points.bin?points=700")
    assert HEADER.unpack_from(answer.data)[2:4] == (700, N)


def test_the_scene_names_what_the_catalog_has(client: FlaskClient) -> None:
    scene = client.get("/3d/scene.json").json
    assert scene["what"] == {
        "structure": STRUCTURE, "name": "Chimney", "epoch": "e0", "day": "2025-03-13", "result": "A/paper", "state": "ok",
    }  # fmt: skip
    assert scene["axis"]["lean"] == [0.007, -0.0057]
    assert scene["axis"]["height_m"] == 102.0
    assert len(scene["rings"]) == 5
    assert [pin["station"] for pin in scene["stations"]] == ["ST01", "ST02", "ST03"]
    assert scene["n_points"] == N
    assert scene["links"]["back"] == "/overview"


def test_the_way_back_keeps_what_is_shown(client: FlaskClient) -> None:
    scene = client.get(f"/3d/scene.json?structure={STRUCTURE}&epoch=e0&points=10").json
    assert scene["links"]["back"] == f"/overview?structure={STRUCTURE}&epoch=e0"


@pytest.mark.parametrize("file", ["scene.json", "points.bin"])
@pytest.mark.parametrize(
    ("query", "reason"),
    [
        ("structure=nowhere", "unknown structure 'nowhere'"),
        ("epoch=..%2F..%2Fetc", "unknown epoch '../../etc'"),
        ("scheme=Z", "unknown scheme"),
        ("points=0", f"points needs a number from 1 to {MOST_POINTS}; got '0'"),
        ("points=-1", "points needs a number"),
        ("points=1e9", "points needs a number"),
        ("points=9999999999999999", "points needs a number"),
        ("points=%D9%A3", "points needs a number"),
        ("structure=" + "x" * 3000, "at most 2000 are read"),
        ("epoch=%00", "unknown epoch"),
        ("epoch=%FF", "unknown epoch"),
    ],
)
def test_what_cannot_be_shown_is_not_found_and_says_why(
    client: FlaskClient, file: str, query: str, reason: str
) -> None:
    answer = client.get(f"/3d/{file}?{query}")
    assert (answer.status_code, answer.mimetype) == (404, "text/plain")
    assert reason in answer.text


def test_points_that_are_gone_are_said_with_what_to_do(ws: Workspace) -> None:
    ref = keep_isolation(ws, *wall(N), ("ST01", "ST02"))
    publish(ws, "", n_points_used=N)
    artifact_path(ws, ref).unlink()
    answer = client_of(ws).get("/3d/points.bin")
    assert answer.status_code == 404
    assert "tiltwatch run FILE --epoch" in answer.text


def test_a_workspace_without_epochs_says_what_to_do(ws: Workspace) -> None:
    answer = client_of(ws).get("/3d/scene.json")
    assert answer.status_code == 404
    assert "tiltwatch run" in answer.text


def test_hostile_names_stay_json(ws: Workspace) -> None:
    keep_isolation(ws, *wall(N), (HOSTILE, "ST02"))
    stations = [replace(station_row("e0", HOSTILE)), station_row("e0", "ST02")]
    publish(ws, "", n_points_used=N, stations=stations)
    answer = client_of(ws, HOSTILE).get("/3d/scene.json")
    assert answer.mimetype == "application/json"
    assert answer.json["what"]["name"] == HOSTILE
    assert answer.json["station_names"] == [HOSTILE, "ST02"]


def test_the_page_holds_nothing_of_the_query_and_loads_from_here_alone(client: FlaskClient) -> None:
    answer = client.get("/3d?structure=%3Cscript%3Ealert(1)%3C/script%3E")
    assert answer.status_code == 200
    assert "alert" not in answer.text
    assert "http" not in answer.text
    policy = answer.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


SCRIPTS = ("page.js", "scene.js", "shaders.js", "labels.js", "panel.js")
VENDORED = ("three.module.js", "three.core.js", "OrbitControls.js")


@pytest.mark.parametrize("name", [*SCRIPTS, *VENDORED, "page.css"])
def test_files_of_the_page_are_there(client: FlaskClient, name: str) -> None:
    answer = client.get(f"/3d/static/{name}")
    assert answer.status_code == 200
    assert answer.mimetype == ("text/css" if name.endswith("css") else "text/javascript")
    again = client.get(f"/3d/static/{name}", headers={"If-None-Match": answer.headers["ETag"]})
    assert again.status_code == 304


@pytest.mark.parametrize(
    "name", ["routes.py", "..%2Froutes.py", "page.html", "nothing.js", "%2e%2e/routes.py"]
)
def test_nothing_else_is_served(client: FlaskClient, name: str) -> None:
    assert client.get(f"/3d/static/{name}").status_code == 404


def test_words_are_inserted_as_text_alone(client: FlaskClient) -> None:
    for name in SCRIPTS:
        source = client.get(f"/3d/static/{name}").text
        assert not any(
            word in source for word in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write")
        )
