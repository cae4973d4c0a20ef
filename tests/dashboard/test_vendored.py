"""What was taken over from three.js is what its note says."""

import hashlib
import re
from pathlib import Path

import dashboard.three.routes

VENDOR = Path(dashboard.three.routes.__file__).parent / "vendor"


def test_vendored_files_have_the_digests_that_are_noted() -> None:
    noted = dict(
        re.findall(r"^\| `([\w.]+)` \|.*`([0-9a-f]{64})`", (VENDOR / "README.md").read_text(), re.MULTILINE)
    )
    for name, digest in noted.items():
        content = (VENDOR / name).read_bytes().replace(b"from './three.module.js'", b"from 'three'")
        assert hashlib.sha256(content).hexdigest() == digest, name
    assert set(noted) == {path.name for path in VENDOR.glob("*.js")}


def test_they_import_nothing_from_elsewhere() -> None:
    for path in [*VENDOR.glob("*.js"), *(VENDOR.parent / "page").glob("*.js")]:
        # the version mark of the same place is no import
        sources = re.findall(
            r"^(?:import|export|\})[^;\n]*from\s*['\"]([^'\"]+)['\"]", path.read_text(), re.MULTILINE
        )
        assert all(source.startswith("./") for source in sources), path.name
