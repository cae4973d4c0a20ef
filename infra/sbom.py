"""Write what tiltwatch is made of, as CycloneDX 1.6: ``.venv/bin/python infra/sbom.py``.

Names, versions, hashes and who needs whom come from requirements.lock, licences from what is installed here, and what
was copied into the repository from the files themselves. Equal input gives equal bytes: no time, no chance. A package of
the lock that is not installed here (it is for another system or Python) has no licence in it, and a property says so.
"""

import hashlib
import json
import re
import sys
import tomllib
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from pathlib import Path
from typing import Final, TypeAlias

Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"

ROOT: Final = Path(__file__).resolve().parents[1]
OUT: Final = ROOT / "infra" / "sbom.cdx.json"
PROJECT: Final = "tiltwatch"

LONGEST_LICENCE: Final = 100
"""Some packages put the whole text where its name belongs."""


@dataclass(frozen=True, slots=True)
class Locked:
    """A package of the lock; ``marker`` says on which systems it is one."""

    name: str
    version: str
    marker: str
    hashes: tuple[str, ...]
    needed_by: tuple[str, ...]

    @property
    def purl(self) -> str:
        """Its address as a package of PyPI, by which advisories know it."""
        return f"pkg:pypi/{self.name}@{self.version}"


@dataclass(frozen=True, slots=True)
class Copied:
    """Files of others that lie in the repository, with the licence that lies beside them."""

    name: str
    version: str
    licence: str
    purl: str
    files: tuple[str, ...]


COPIED: Final = (
    Copied(
        "three",
        "0.187.0",
        "MIT",
        "pkg:npm/three@0.187.0",
        (
            "dashboard/three/vendor/OrbitControls.js",
            "dashboard/three/vendor/three.core.js",
            "dashboard/three/vendor/three.module.js",
        ),
    ),
    Copied(
        "inter",
        "",
        "OFL-1.1",
        "",
        (
            "dashboard/assets/inter-greek-wght-normal.woff2",
            "dashboard/assets/inter-latin-ext-wght-normal.woff2",
            "dashboard/assets/inter-latin-wght-normal.woff2",
            "dashboard/report/fonts/TiltwatchInter-Regular.otf",
            "dashboard/report/fonts/TiltwatchInter-SemiBold.otf",
        ),
    ),
    Copied(
        "noto-sans-cjk-sc",
        "",
        "OFL-1.1",
        "",
        (
            "dashboard/report/fonts/TiltwatchNotoSC-Regular.otf",
            "dashboard/report/fonts/TiltwatchNotoSC-SemiBold.otf",
        ),
    ),
)


def locked_packages(text: str) -> list[Locked]:
    """Read the packages of a lock file, in its order."""
    found = []
    for block in re.split(r"\n(?=[a-z0-9])", text):
        head = re.match(r"([a-z0-9][\w.-]*)==(\S+)(?: ; (.*?))? \\\n", block)
        if head is None:
            raise ValueError(f"needed NAME==VERSION, got {block[:60]!r}")
        hashes = tuple(sorted(re.findall(r"--hash=sha256:([0-9a-f]{64})", block)))
        via = re.search(r"# via(.*)", block, re.DOTALL)
        needed_by = tuple(re.findall(r"#?\s*([a-z0-9][\w.-]*)(?: \(.*?\))?\s*\n?", via[1])) if via else ()
        found.append(Locked(head[1], head[2], head[3] or "", hashes, needed_by))
    return found


def in_use(packages: Sequence[Locked], direct: frozenset[str]) -> frozenset[str]:
    """Names of the packages that a running tiltwatch needs: not those of tests and builds."""
    needs: dict[str, set[str]] = {}
    for package in packages:
        for user in package.needed_by:
            needs.setdefault(user, set()).add(package.name)
    found: set[str] = set()
    waiting = set(direct)
    while waiting:
        name = waiting.pop()
        found.add(name)
        waiting |= needs.get(name, set()) - found
    return frozenset(found)


def direct_dependencies(project: Mapping[str, object]) -> frozenset[str]:
    """Names that pyproject.toml asks for, with those of the extra ``dask``."""
    table = project["project"]
    if not isinstance(table, dict):
        raise TypeError("pyproject.toml has no table [project]")
    words = [*table["dependencies"], *table["optional-dependencies"]["dask"]]
    return frozenset(re.split(r"[<>=!;\[ ]", word)[0].lower() for word in words)


def licences(about: PackageMetadata) -> list[Json]:
    """Licences that a package states, as CycloneDX has them; empty where it states none."""
    expression = about.get("License-Expression")
    if expression:
        return [{"expression": expression}]
    prefix = "License :: "
    classified = [line for line in about.get_all("Classifier") or [] if line.startswith(prefix)]
    names = [line.rpartition(" :: ")[2] for line in classified if " :: " in line.removeprefix(prefix)]
    stated = (about.get("License") or "").strip().splitlines()
    if not names and stated and len(stated[0]) <= LONGEST_LICENCE:
        names = [stated[0].strip()]
    return [{"license": {"name": name}} for name in sorted(set(names))]


def _component(package: Locked, used: frozenset[str]) -> dict[str, Json]:
    component: dict[str, Json] = {
        "type": "library",
        "bom-ref": package.purl,
        "name": package.name,
        "version": package.version,
        "scope": "required" if package.name in used else "excluded",
        "hashes": [{"alg": "SHA-256", "content": digest} for digest in package.hashes],
    }
    properties = [{"name": "tiltwatch:marker", "value": package.marker}] if package.marker else []
    try:
        about = metadata(package.name)
    except PackageNotFoundError:
        about = None
    # of a package that is locked in two versions the other one is installed
    if about is not None and about["Version"] == package.version:
        stated = licences(about)
        if stated:
            component["licenses"] = stated
    else:
        properties.append({"name": "tiltwatch:licence", "value": "not installed where this was written"})
    component["purl"] = package.purl
    if properties:
        component["properties"] = properties
    return component


def _copied_component(copied: Copied) -> dict[str, Json]:
    files: list[Json] = [
        {
            "type": "file",
            "name": name,
            "hashes": [{"alg": "SHA-256", "content": hashlib.sha256((ROOT / name).read_bytes()).hexdigest()}],
        }
        for name in copied.files
    ]
    component: dict[str, Json] = {
        "type": "library",
        "bom-ref": f"copied/{copied.name}",
        "name": copied.name,
        "scope": "required",
        "licenses": [{"license": {"id": copied.licence}}],
        "components": files,
    }
    if copied.version:
        component |= {"version": copied.version, "purl": copied.purl}
    return component


def _dependencies(packages: Sequence[Locked]) -> Iterator[dict[str, Json]]:
    users: dict[str, list[str]] = {PROJECT: []}
    for package in packages:
        users.setdefault(package.name, [])
    for package in packages:
        for user in package.needed_by:
            if user in users:
                users[user].append(package.purl)
    yield {"ref": PROJECT, "dependsOn": sorted(users[PROJECT])}
    for package in packages:
        yield {"ref": package.purl, "dependsOn": sorted(users[package.name])}


def bill_of_materials() -> dict[str, Json]:
    """What tiltwatch is made of."""
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    packages = locked_packages(lock)
    used = in_use(packages, direct_dependencies(project))
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_OID, hashlib.sha256(lock.encode()).hexdigest())}",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": PROJECT,
                "name": PROJECT,
                "version": project["project"]["version"],
            },
            "properties": [
                {"name": "tiltwatch:lock-sha256", "value": hashlib.sha256(lock.encode()).hexdigest()}
            ],
        },
        "components": [
            *(_component(package, used) for package in packages),
            *(_copied_component(copied) for copied in COPIED),
        ],
        "dependencies": list(_dependencies(packages)),
    }


def as_text(bill: Mapping[str, Json]) -> str:
    """The bill as JSON, a component a line: what changes between two of them can be read in a diff."""
    parts = []
    for key, value in bill.items():
        if isinstance(value, list):
            lines = ",\n".join(json.dumps(item) for item in value)
            parts.append(f"{json.dumps(key)}: [\n{lines}\n]")
        else:
            parts.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main() -> None:
    """Write the bill."""
    bill = bill_of_materials()
    OUT.write_text(as_text(bill), encoding="utf-8")
    sys.stdout.write(f"{OUT}: {len(bill['components'])} components\n")  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
