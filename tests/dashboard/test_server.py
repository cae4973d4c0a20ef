"""Who may come in, and what the pages may load."""

import flask
import pytest
from flask.testing import FlaskClient

from dashboard.server import COOKIE, Listening, guarded, is_loopback
from storage.errors import UsageError

TOKEN = "0123456789abcdef0123"  # noqa: S105 (of the tests)


def _client(where: Listening) -> FlaskClient:
    server = flask.Flask("test")
    server.add_url_rule("/", view_func=lambda: "in")
    return guarded(server, where).test_client()


@pytest.mark.parametrize(
    ("host", "local"),
    [
        ("127.0.0.1", True),
        ("127.8.9.1", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),  # noqa: S104 (only asked about)
        ("10.0.0.5", False),
        ("example.org", False),
    ],
)
def test_only_addresses_of_this_machine_are_its_own(host: str, local: bool) -> None:
    assert is_loopback(host) is local


def test_on_loopback_nobody_needs_a_token() -> None:
    assert _client(Listening()).get("/").status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8050", "10.0.0.5:8050", "[::1].evil.example", "127.0.0.1:80@evil.example"],
)
def test_a_foreign_name_that_points_at_this_machine_is_refused(host: str) -> None:
    answer = _client(Listening()).get("/", headers={"Host": host})
    assert answer.status_code == 403


@pytest.mark.parametrize("host", ["127.0.0.1:8050", "localhost:8050", "[::1]:8050"])
def test_the_names_of_this_machine_are_answered(host: str) -> None:
    assert _client(Listening()).get("/", headers={"Host": host}).status_code == 200


def test_elsewhere_a_token_is_demanded_at_the_start() -> None:
    with pytest.raises(UsageError, match="needs a token"):
        _client(Listening("0.0.0.0"))  # noqa: S104


def test_a_token_that_can_be_guessed_is_refused() -> None:
    with pytest.raises(UsageError, match="the token has 5 characters"):
        _client(Listening("0.0.0.0", token="short"))  # noqa: S104, S106


def test_elsewhere_nobody_comes_in_without_the_token() -> None:
    client = _client(Listening("0.0.0.0", token=TOKEN))  # noqa: S104
    assert client.get("/").status_code == 401
    assert client.get("/?token=wrong").status_code == 401
    assert client.get("/", headers={"Authorization": "Bearer wrong"}).status_code == 401
    client.set_cookie(COOKIE, "wrong")
    assert client.get("/").status_code == 401


def test_the_token_in_the_address_becomes_a_cookie_and_leaves_the_address() -> None:
    client = _client(Listening("0.0.0.0", token=TOKEN))  # noqa: S104
    answer = client.get(f"/?structure=a%26b&token={TOKEN}")
    assert (answer.status_code, answer.headers["Location"]) == (303, "/?structure=a%26b")
    assert "HttpOnly" in answer.headers["Set-Cookie"]
    assert client.get("/").status_code == 200


def test_a_program_brings_the_token_in_a_header() -> None:
    client = _client(Listening("0.0.0.0", token=TOKEN))  # noqa: S104
    assert client.get("/", headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_pages_may_load_from_this_server_only() -> None:
    answer = _client(Listening()).get("/")
    policy = answer.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "http" not in policy


def test_a_path_that_looks_like_another_server_stays_here() -> None:
    answer = _client(Listening("0.0.0.0", token=TOKEN)).get(f"//evil.example/x?token={TOKEN}")  # noqa: S104
    assert answer.headers.get("Location", "/x").startswith("/")
    assert not answer.headers.get("Location", "/x").startswith("//")
