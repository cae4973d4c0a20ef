"""Secrets come from the environment or from files that only their owner may read; errors name the file, not the secret."""

from pathlib import Path

import pytest

from flows.alarm_targets import Letter, send
from flows.commands.dashboard import TOKEN_VARIABLE, _token
from flows.server_address import check_server_address
from flows.upload.server import listening
from storage.errors import InputError, StorageError, UsageError
from storage.places import store_at
from storage.s3_inbox import s3_files
from storage.secrets import has_login, secret_in, secret_of, without_login
from tasks.settings.notify import WebhookTarget

CANARY = "canary-0123456789abcdef"
NO_TLS = (None, None)
LETTER = Letter(title="t", body="b", severity="alarm", is_over=False, facts={})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "secret"
    path.write_text(f" {CANARY}\n")
    path.chmod(0o600)
    return path


def test_a_file_of_mode_600_is_read(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("X_FILE", str(file))
    assert secret_in("X") == secret_of(file, "--x") == CANARY


def test_the_variable_itself_goes_before_its_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("X_FILE", str(file))
    monkeypatch.setenv("X", "other")
    assert secret_in("X") == "other"


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o602, 0o644, 0o610])
def test_a_file_that_others_may_read_or_write_is_refused_with_the_way_out(file: Path, mode: int) -> None:
    file.chmod(mode)
    with pytest.raises(InputError, match=f"--x: .*mode {mode:03o}.*chmod 600") as refusal:
        secret_of(file, "--x")
    assert CANARY not in str(refusal.value)


def test_what_is_no_secret_file_is_said_without_its_content(file: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no file"):
        secret_of(tmp_path, "--x")
    with pytest.raises(InputError, match="cannot be read"):
        secret_of(tmp_path / "none", "--x")
    file.write_bytes(b"\n ")
    with pytest.raises(InputError, match="is empty"):
        secret_of(file, "--x")
    file.write_bytes(CANARY.encode() + b"\xff")
    with pytest.raises(InputError, match="is no text") as refusal:
        secret_of(file, "--x")
    assert CANARY not in repr(refusal.value.__cause__)


def test_every_secret_of_ours_may_stand_in_a_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    monkeypatch.setenv(f"{TOKEN_VARIABLE}_FILE", str(file))
    assert _token(None) == _token(file) == CANARY
    monkeypatch.setenv("SITE_TOKEN_FILE", str(file))
    assert listening("127.0.0.1:0", "SITE_TOKEN", NO_TLS, insecure_http=False).token == CANARY
    file.write_text("json://127.0.0.1:1/" + CANARY)
    monkeypatch.setenv("HOOK_FILE", str(file))
    reason = send(WebhookTarget(id="to", kind="webhook", url_env="HOOK"), LETTER, file.parent)
    assert reason is not None
    assert CANARY not in reason
    file.chmod(0o644)
    with pytest.raises(InputError, match="can be read by others"):
        _token(None)
    with pytest.raises(InputError, match="can be read by others"):
        listening("127.0.0.1:0", "SITE_TOKEN", NO_TLS, insecure_http=False)
    assert "chmod 600" in str(
        send(WebhookTarget(id="to", kind="webhook", url_env="HOOK"), LETTER, file.parent)
    )


def test_the_key_of_the_upload_server_is_private(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SITE_TOKEN", CANARY)
    file.chmod(0o644)
    with pytest.raises(InputError, match=r"--tls-key: .*chmod 600"):
        listening("127.0.0.1:0", "SITE_TOKEN", (file, file), insecure_http=False)


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        (f"http://bell:{CANARY}@host:1/api", "http://***@host:1/api"),
        (f"https://{CANARY}@host", "https://***@host"),
        (f"http://a:{CANARY}@b@host/x@y", "http://***@host/x@y"),
        ("http://127.0.0.1:4200/api", "http://127.0.0.1:4200/api"),
        ("http://host/a@b", "http://host/a@b"),
    ],
)
def test_a_login_in_a_url_is_not_shown(url: str, shown: str) -> None:
    assert without_login(url) == shown
    assert has_login(url) is (url != shown)


def test_a_login_in_the_address_of_a_server_is_refused_unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    address = f"http://bell:{CANARY}@127.0.0.1:4200/api"
    for name in ("AWS_ENDPOINT_URL", "AWS_ENDPOINT_URL_S3"):
        monkeypatch.setenv(name, address)
    for refused, use in (
        (UsageError, lambda: check_server_address(address)),
        (StorageError, lambda: store_at("s3://bucket/prefix")),
        (UsageError, s3_files),
    ):
        with pytest.raises(refused, match=r"\*\*\*@127.0.0.1:4200") as refusal:
            use()
        assert CANARY not in str(refusal.value)


@pytest.mark.parametrize("host", ["10.0.0.7", "server", "example.org", "[2001:db8::1]", "0.0.0.0"])  # noqa: S104
def test_a_workflow_server_elsewhere_is_used_only_with_a_secret(
    host: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("PREFECT_API_AUTH_STRING", "PREFECT_API_KEY", "PREFECT_CLIENT_CUSTOM_HEADERS"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(UsageError, match=r"no secret is set.*PREFECT_SERVER_API_AUTH_STRING"):
        check_server_address(f"http://{host}:4200/api")
    monkeypatch.setenv("PREFECT_API_AUTH_STRING", f"tiltwatch:{CANARY}")
    check_server_address(f"http://{host}:4200/api")


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]"])
def test_one_on_this_machine_may_be_without(host: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PREFECT_API_AUTH_STRING", raising=False)
    check_server_address(f"http://{host}:4200/api")
    check_server_address(None)


@pytest.mark.parametrize("url", ["nonsense", "http://", "http://[half/api"])
def test_what_is_no_address_is_refused(url: str) -> None:
    with pytest.raises(UsageError, match="needs an address"):
        check_server_address(url)


def test_a_login_before_a_host_without_http_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PREFECT_API_AUTH_STRING", raising=False)
    with pytest.raises(UsageError, match=r"needs an address as .*, got '\*\*\*@host:4200/api'") as told:
        check_server_address("user:canary@host:4200/api")
    assert "canary" not in str(told.value)
