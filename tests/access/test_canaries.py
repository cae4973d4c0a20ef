"""No secret gets into what commands say or keep: logs, results, catalog, records, database of the workflow server."""

import base64
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.access.canaries import Found, search
from tests.flows.alarm_receivers import free_port, http_server, mail_server
from tests.flows.calls import ROOT
from tests.flows.campaigns import small_campaign
from tests.flows.stored_campaign import Stored, publish, stored_campaign

pytestmark = pytest.mark.filterwarnings("ignore:Requiring AUTH while not requiring TLS")

SECRETS = {
    name: f"canary{number}x7f3aQ{name.replace('_', '')[:8]}"
    for number, name in enumerate(
        (
            "mail_password",
            "hook_path",
            "hook_query",
            "hook_user",
            "store_key",
            "store_token",
            "dashboard_token",
            "site_token",
            "server_secret",
            "database_password",
        )
    )
}
FAIL = {"verdict": "fail", "allowable_m": 0.0605, "verdict_reason": None}
ALARMS = """
[[alarms]]
id = "limit"
when = "limit"
severity = "alarm"
notify = ["mail", "hook", "other"]
[[notify]]
id = "mail"
kind = "email"
url_env = "MAIL_URL"
[[notify]]
id = "hook"
kind = "webhook"
url_env = "HOOK_URL"
[[notify]]
id = "other"
kind = "webhook"
url_env = "OTHER_URL"
"""


def variables(mail_port: int, hook_port: int, folder: Path) -> dict[str, str]:
    """An environment with a secret in every place that takes one; the keys of the store are a file's."""
    s = SECRETS
    hook = folder / "hook.secret"
    hook.write_text(f"jsons://{s['hook_user']}@127.0.0.1:{free_port()}/{s['hook_path']}?x={s['hook_query']}")
    hook.chmod(0o600)
    return {
        "MAIL_URL": f"mailto://bell:{s['mail_password']}@127.0.0.1:{mail_port}?from=a@example.org&to=b@example.org"
        "&mode=insecure",
        "HOOK_URL": f"json://{s['hook_user']}:{s['hook_query']}@127.0.0.1:{hook_port}/{s['hook_path']}?key={s['hook_query']}",
        "OTHER_URL_FILE": str(hook),
        "AWS_ACCESS_KEY_ID": "tester",
        "AWS_SECRET_ACCESS_KEY": s["store_key"],
        "AWS_SESSION_TOKEN": s["store_token"],
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{free_port()}",
        "TILTWATCH_DASHBOARD_TOKEN": s["dashboard_token"],
        "SITE_TOKEN": s["site_token"],
        "TILTWATCH_KEEP_SERVER_S": "0",
    }


class Office:
    """Calls commands and keeps what they say."""

    def __init__(self, environment: dict[str, str]) -> None:
        self.said: dict[str, str] = {}
        inherited = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("PREFECT_", "AWS_", "TILTWATCH_SERVER"))
        }
        self._environment = {**inherited, "PYTHONPATH": str(ROOT), **environment}

    def call(self, *words: object, **more: str) -> int:
        done = subprocess.run(
            [sys.executable, "-m", "flows.cli", *map(str, words)],
            capture_output=True,
            encoding="utf-8",
            cwd=ROOT,
            env={**self._environment, **more},
            timeout=500,
            check=False,
        )
        self.said[" ".join(map(str, words))] = done.stdout + done.stderr
        return done.returncode


def assert_nothing_leaked(office: Office, folder: Path) -> None:
    (folder / "hook.secret").unlink(missing_ok=True)
    found = search(SECRETS, [folder], office.said)
    assert found == [], "\n".join(f"{one.secret} in {one.where}" for one in found)


def test_the_search_finds_what_is_there(tmp_path: Path) -> None:
    stored = stored_campaign(tmp_path)
    publish(stored, "e1", 0, reason=f"the word is {SECRETS['store_key']}")
    found = search(SECRETS, [tmp_path], {"said": f"Basic bell%3A{SECRETS['hook_user']}"})
    assert {one.secret for one in found} == {"store_key", "hook_user"}
    assert {Path(one.where).suffix for one in found} >= {".duckdb (read)", ".parquet (read)"}
    for name, secret in SECRETS.items():
        login = base64.b64encode(f"bell:{secret}@".encode()).decode()
        assert Found(name, "said") in search(SECRETS, [], {"said": login})


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    stored = stored_campaign(tmp_path)
    with stored.file.open("a", encoding="utf-8") as file:
        file.write(ALARMS)
    publish(stored, "e1", 0, FAIL)
    return stored


@pytest.mark.slow
def test_alarms_that_cannot_be_delivered_and_a_store_that_is_away_tell_no_secret(
    stored: Stored, tmp_path: Path
) -> None:
    with mail_server(with_login=True) as box, http_server() as desk:
        desk.status = 500
        office = Office(variables(box.port, desk.port, tmp_path))
        assert office.call("-vv", "alarms", stored.file, "--trial") == 3
        assert office.call("-vv", "alarms", stored.file, "--evaluate") == 6
        assert box.logins, "the wrong password was never tried"
        words = ("watch", stored.file, "--once")
        office.call("-vv", *words, "--inbox", "s3://bucket/prefix", "--interval-s", "0.1")
        office.call(
            *words, "--inbox", tmp_path / "in", "--listen", "127.0.0.1:0", "--token-env", "SITE_TOKEN"
        )
        for name in ("status", "report", "verify"):
            office.call(name, stored.file)
        office.call("-vv", "deploy", stored.file, PREFECT_API_URL=own_login(), **own_secret())
    assert_nothing_leaked(office, tmp_path)


def own_login() -> str:
    return f"http://admin:{SECRETS['server_secret']}@127.0.0.1:{free_port()}/api"


def own_secret() -> dict[str, str]:
    return {"PREFECT_API_AUTH_STRING": f"admin:{SECRETS['server_secret']}"}


@pytest.mark.slow
def test_runs_good_and_bad_keep_no_secret(tmp_path: Path) -> None:
    file = small_campaign(tmp_path / "site", stations=3, points=20_000)
    plain = file.read_text(encoding="utf-8")
    file.write_text(plain + ALARMS, encoding="utf-8")
    secret = f"admin:{SECRETS['server_secret']}"
    with mail_server(with_login=True) as box, http_server() as desk:
        desk.status = 500
        office = Office({**variables(box.port, desk.port, tmp_path), "PREFECT_API_AUTH_STRING": secret})
        assert office.call("-vv", "run", file) == 0
        for words in (("report", "--out", tmp_path / "report.pdf"), ("report", "--out", tmp_path / "r.html")):
            office.call(words[0], file, *words[1:])
        office.call("doctor")
        # a server that is not there, by its name with and without a login
        office.call("-vv", "run", file, "--anew", PREFECT_API_URL=own_login())
        (tmp_path / "bad").mkdir()
        bad = re.sub(
            r"(?m)^(\[\[epochs\]\])", '[execution]\nstore = "s3://bucket/prefix"\n\n\\1', plain, count=1
        )
        other = file.with_name("bad.toml")
        other.write_text(bad, encoding="utf-8")
        assert office.call("-vv", "run", other, "--workspace", tmp_path / "bad") == 3
    assert "s3://bucket/prefix" in " ".join(office.said.values())
    assert list(tmp_path.rglob("prefect.db")), "no database of the workflow server was searched"
    assert_nothing_leaked(office, tmp_path)


@pytest.mark.slow
def test_a_database_that_is_away_does_not_show_its_password(tmp_path: Path) -> None:
    file = small_campaign(tmp_path / "site", stations=3, points=20_000)
    database = f"postgresql+asyncpg://prefect:{SECRETS['database_password']}@127.0.0.1:{free_port()}/prefect"
    office = Office({"PREFECT_SERVER_DATABASE_CONNECTION_URL": database, "TILTWATCH_KEEP_SERVER_S": "0"})
    office.call("-vv", "run", file)
    assert_nothing_leaked(office, tmp_path)
