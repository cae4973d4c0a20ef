"""Uploads come into the inbox of a watch whole, under a name of ours, and from those who may."""

import hashlib
import http.client
import io
import ssl
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from tusclient.exceptions import TusCommunicationError

from flows.upload.server import FOLDER, listening
from storage.errors import UsageError
from tests.flows.uploads import (
    CONTENT,
    TOKEN,
    ask,
    begun,
    client,
    files,
    metadata_of,
    scan_file,
    send,
    serving,
)


def test_an_upload_comes_into_the_inbox_whole_and_under_its_name(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        send(url, scan_file(tmp_path), sha256=hashlib.sha256(CONTENT).hexdigest())
        assert files(inbox) == ["ST01.laz"]
    assert (inbox / "ST01.laz").read_bytes() == CONTENT


def test_an_empty_marker_can_be_sent(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        assert begun(url, 0, "2026-03.complete").status == 201
    assert files(inbox) == ["2026-03.complete"]


def test_without_the_token_nothing_is_created_and_no_byte_is_written(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        with pytest.raises(TusCommunicationError) as refused:
            client(url, "another-token-of-length").uploader(
                file_stream=io.BytesIO(CONTENT), metadata={"filename": "ST01.laz"}
            ).upload()
        assert refused.value.status_code == 401
        place = str(begun(url, len(CONTENT)).getheader("Location"))
        patch = {"Upload-Offset": "0", "Content-Type": "application/offset+octet-stream", "Authorization": ""}
        assert ask(place, "PATCH", patch, CONTENT).status == 401
        assert ask(place, "POST", {**patch, "X-HTTP-Method-Override": "PATCH"}, CONTENT).status == 401
        assert ask(place, "HEAD", {}).getheader("Upload-Offset") == "0"
    (data,) = (inbox / FOLDER).glob("*.data")
    assert data.stat().st_size == 0
    assert files(inbox) == []


@pytest.mark.parametrize(
    "name",
    [
        "../ST01.laz",
        "/etc/ST01.laz",
        "a/b.laz",
        "..",
        ".hidden.laz",
        "ST01.exe",
        "NUL.laz",
        "",
        "a\\b.laz",
        "x" * 80 + ".laz",
    ],
)
def test_a_name_that_is_no_plain_name_of_a_scan_is_refused(tmp_path: Path, name: str) -> None:
    with serving(tmp_path / "inbox") as url:
        assert begun(url, 10, name).status == 400
    assert not list(tmp_path.rglob("*.data"))


def test_what_is_not_offered_is_refused(tmp_path: Path) -> None:
    with serving(tmp_path / "inbox", max_bytes=1000) as url:
        assert begun(url, 1001).status == 413
        assert begun(url, -1).status == 400
        assert begun(url, 10, **{"Upload-Concat": "partial"}).status == 400
        assert (
            ask(
                url, "POST", {"Upload-Length": "4", "Upload-Metadata": metadata_of(filename="a.laz")}, b"data"
            ).status
            == 400
        )
        offer = ask(url, "OPTIONS", {})
        assert offer.getheader("Tus-Extension") == "creation,expiration,termination"
        assert ask(f"{url}..%2f..%2fetc", "HEAD", {}).status == 404


def test_more_than_was_announced_is_not_taken(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        place = str(begun(url, 100).getheader("Location"))
        patch = {"Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}
        assert ask(place, "PATCH", patch, b"x" * 101).status == 400
    assert files(inbox) == []


def test_bytes_that_are_not_those_of_the_digest_do_not_come_into_the_inbox(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        with pytest.raises(TusCommunicationError) as refused:
            send(url, scan_file(tmp_path), sha256="0" * 64)
        assert refused.value.status_code == 460
    assert files(inbox) == []
    (kept,) = (inbox / FOLDER).glob("*.wrong-digest")
    assert kept.read_bytes() == CONTENT


def test_a_file_of_the_same_name_is_set_aside_and_not_lost(tmp_path: Path) -> None:
    inbox = tmp_path / "inbox"
    with serving(inbox) as url:
        send(url, scan_file(tmp_path, b"first"), "ST01.toml")
        send(url, scan_file(tmp_path, b"second"), "ST01.toml")
    assert (inbox / "ST01.toml").read_bytes() == b"second"
    assert [path.read_bytes() for path in (inbox / ".superseded").iterdir()] == [b"first"]


@pytest.mark.parametrize(
    ("address", "token", "told"),
    [
        ("0.0.0.0:8443", TOKEN, "the token would travel readable"),
        ("example.org:80", TOKEN, "the token would travel readable"),
        ("127.0.0.1:8443", "short", "needs a token of 16 characters"),
        ("127.0.0.1:8443", None, "needs a token of 16 characters"),
        ("8443", TOKEN, "needs HOST:PORT"),
        ("127.0.0.1:99999", TOKEN, "needs HOST:PORT"),
    ],
)
def test_a_server_that_would_not_be_safe_does_not_start(
    monkeypatch: pytest.MonkeyPatch, address: str, token: str | None, told: str
) -> None:
    if token is not None:
        monkeypatch.setenv("UPLOAD_TOKEN", token)
    with pytest.raises(UsageError, match=told):
        listening(address, "UPLOAD_TOKEN", (None, None), insecure_http=False)


def test_it_is_the_users_to_listen_without_tls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UPLOAD_TOKEN", TOKEN)
    assert listening("0.0.0.0:80", "UPLOAD_TOKEN", (None, None), insecure_http=True).host == "0.0.0.0"  # noqa: S104
    assert listening("[::1]:80", "UPLOAD_TOKEN", (None, None), insecure_http=False).host == "::1"


def test_with_a_certificate_the_server_speaks_tls(tmp_path: Path) -> None:
    cert, key = certificate(tmp_path)
    with serving(tmp_path / "inbox", tls_cert=cert, tls_key=key) as url:
        port = int(url.split(":")[2].split("/")[0])
        trusted = ssl.create_default_context(cafile=str(cert))
        connection = http.client.HTTPSConnection("localhost", port, context=trusted, timeout=30)
        headers = {"Tus-Resumable": "1.0.0", "Authorization": f"Bearer {TOKEN}", "Upload-Length": "5"}
        connection.request(
            "POST", "/files/", None, {**headers, "Upload-Metadata": metadata_of(filename="ST01.laz")}
        )
        answer = connection.getresponse()
        answer.read()
        connection.close()
        assert (answer.status, str(answer.getheader("Location"))[:17]) == (201, "https://localhost")


def certificate(folder: Path) -> tuple[Path, Path]:
    """A certificate of localhost that signs itself, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "localhost")])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), critical=False)
        .sign(key, hashes.SHA256())
    )
    form = (serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    (folder / "cert.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    (folder / "key.pem").write_bytes(key.private_bytes(*form))
    return folder / "cert.pem", folder / "key.pem"
