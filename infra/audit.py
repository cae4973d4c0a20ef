"""Hold the locked packages against the known flaws: ``make audit``, or ``.venv/bin/python infra/audit.py``.

pip-audit asks an advisory service on the network. Where that does not answer, pip-audit itself ends with 0 and a list of
what it skipped; here that is no answer, and the exit code says so: 0 nothing is known, 3 not everything could be asked,
4 a package has a known flaw.
"""

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
LOCK: Final = ROOT / "requirements.lock"

CLEAN: Final = 0
NOT_ASKED: Final = 3
FLAWED: Final = 4

SERVICES: Final = ("pypi", "osv")


@dataclass(frozen=True, slots=True)
class Audit:
    """What became of an audit: lines on flaws, names that could not be asked for, and how many were."""

    flaws: tuple[str, ...]
    skipped: tuple[str, ...]
    asked: int

    @property
    def exit_code(self) -> int:
        """What the command ends with."""
        if self.flaws:
            return FLAWED
        return NOT_ASKED if self.skipped or not self.asked else CLEAN


def read_audit(text: str) -> Audit:
    """Read the JSON of pip-audit.

    Raises
    ------
    ValueError
        If it is none.
    """
    content = json.loads(text)
    if not isinstance(content, dict) or "dependencies" not in content:
        raise ValueError("pip-audit gave no list of dependencies")
    packages = content["dependencies"]
    asked = [package for package in packages if "skip_reason" not in package]
    flaws = tuple(
        f"{package['name']} {package['version']}: {flaw['id']}, mended in {', '.join(flaw['fix_versions']) or 'none yet'}"
        for package in asked
        for flaw in package["vulns"]
    )
    skipped = tuple(sorted(package["name"] for package in packages if "skip_reason" in package))
    return Audit(flaws, skipped, len(asked))


def _command() -> list[str] | None:
    found = shutil.which("pip-audit")
    if found:
        return [found]
    uv = shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")
    return [uv, "tool", "run", "pip-audit"] if uv else None


def _asked(command: Sequence[str], service: str) -> Audit | str:
    """What a service says, or why it says nothing."""
    words = ["-r", str(LOCK), "--disable-pip", "--require-hashes", "-f", "json", "-s", service]
    words += ["--progress-spinner", "off", "--timeout", "15"]
    try:
        done = subprocess.run([*command, *words], capture_output=True, text=True, check=False, timeout=900)
        return read_audit(done.stdout)
    except subprocess.TimeoutExpired:
        return "no answer within 15 minutes"
    except ValueError:
        return (done.stderr.strip().splitlines() or ["it said nothing"])[-1]


def together(audits: Sequence[Audit]) -> Audit | None:
    """What several services say: a flaw that one knows is one, and a package that one was asked for is asked for.

    None where none knew any package.
    """
    told = [audit for audit in audits if audit.asked]
    if not told:
        return None
    flaws = dict.fromkeys(flaw for audit in told for flaw in audit.flaws)
    skipped = frozenset.intersection(*(frozenset(audit.skipped) for audit in told))
    return Audit(tuple(flaws), tuple(sorted(skipped)), max(audit.asked for audit in told))


def _answer(command: Sequence[str]) -> Audit | None:
    """What the services know together; the next is asked where one did not know all packages."""
    audits: list[Audit] = []
    for service in SERVICES:
        audit = _asked(command, service)
        if isinstance(audit, str):
            sys.stdout.write(f"{service}: {audit}\n")
            continue
        sys.stdout.write(f"{service}: {audit.asked} packages asked for, {len(audit.skipped)} not\n")
        audits.append(audit)
        if audit.asked and not audit.skipped:
            break
    return together(audits)


def main() -> int:
    """Ask, and say what came; gives the exit code."""
    command = _command()
    if command is None:
        sys.stdout.write("not audited: neither pip-audit nor uv is installed; `make setup` brings uv\n")
        return NOT_ASKED
    found = _answer(command)
    if found is None:
        sys.stdout.write("not audited: no advisory service answered; try where the network reaches one\n")
        return NOT_ASKED
    for line in found.flaws:
        sys.stdout.write(f"{line}\n")
    if found.skipped:
        sys.stdout.write(f"could not be asked for: {', '.join(found.skipped)}\n")
    return found.exit_code


if __name__ == "__main__":
    sys.exit(main())
