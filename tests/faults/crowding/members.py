"""The members of the crowd that call the command line."""

import random
from typing import Final

from tests.faults.crowding.crowd import STATES, Crowd, Member
from tests.faults.crowding.site import SETTINGS

SETTINGS_CHANGE: Final = 0.5
"""Share of the runs before which somebody changes the settings."""


def run_with_changes(crowd: Crowd, rng: random.Random) -> None:
    """Process everything, now and then with other settings."""
    if rng.random() < SETTINGS_CHANGE:
        crowd.site.set_up(rng.randrange(len(SETTINGS)))
    _run(crowd, "run", crowd.site.file, "--json")


def run_what_is_new(crowd: Crowd, rng: random.Random) -> None:
    """Process what is new."""
    _run(crowd, "run", crowd.site.file, "--only-new", "--json")
    crowd.end.wait(rng.uniform(0.0, 1.0))


def verify(crowd: Crowd, rng: random.Random) -> None:
    """Look at everything, now and then at every artifact's bytes."""
    deep = ["--deep"] if rng.random() < 0.3 else []
    crowd.call("verify", crowd.site.file, "--json", *deep)
    crowd.end.wait(rng.uniform(0.0, 2.0))


def report(crowd: Crowd, rng: random.Random) -> None:
    """Ask for the state, a comparison and a report, in turn."""
    site = crowd.site
    crowd.call("status", site.file, "--json", codes=STATES)
    crowd.call("compare", site.file, site.epochs[1]["id"], site.epochs[0]["id"], "--json")
    if rng.random() < 0.5:
        crowd.call("report", site.file, "--html", site.reports / "report.html")
    else:
        crowd.call("report", site.file, "--epoch", site.epochs[0]["id"], "--pdf", site.reports / "report.pdf")


def look_after_alarms(crowd: Crowd, rng: random.Random) -> None:
    """Acknowledge, mute and unmute alarms, and export what is on record."""
    site = crowd.site
    told = crowd.call("alarms", site.file, "--all", "--json", codes=STATES).answer
    open_ones = [one for one in told["alarms"] if one["state"] != "closed"]
    for alarm in rng.sample(open_ones, min(2, len(open_ones))):
        action, words = _deed(alarm["muted_until"] is not None or alarm["state"] == "muted", rng)
        note = f"seen in turn {rng.getrandbits(48):012x}"
        # it may have been closed by a run meanwhile, which is told as wrong usage and is no fault
        named = [alarm["alarm"], "--name", "A. Surveyor", "--note", note]
        done = crowd.call(words, site.file, *named, "--json", codes=frozenset({0, 2}))
        if done.code == 0:
            crowd.deeds.append((alarm["alarm"], action, note))
        elif "closed already" not in done.err:
            crowd.find(f"{words} {alarm['alarm']}: {done.err}")
    kind = rng.choice(("csv", "json", "parquet"))
    crowd.call(
        "export",
        site.file,
        rng.choice(("tilt", "slices", "alarms")),
        "--format",
        kind,
        "--out",
        site.reports / f"x.{kind}",
    )


def _run(crowd: Crowd, *words: object) -> None:
    done = crowd.call(*words)
    # one that asked for no stage is not in the ledger
    if done.code == 0 and sum(done.answer["stages"].values()):
        crowd.runs.append(done.answer["run"])


def _deed(muted: bool, rng: random.Random) -> tuple[str, str]:
    if muted:
        return "unmuted", "unmute"
    return rng.choice((("acknowledged", "acknowledge"), ("muted", "mute")))


MEMBERS: Final[tuple[Member, ...]] = (run_with_changes, run_what_is_new, verify, report, look_after_alarms)
