"""Cases by number: a seed, what was done to it, and what is asked of it. The same number is the same case everywhere."""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from tasks.ingest import Frame, LengthUnit, ScanRequest
from tests.faults.fuzzing.byte_damage import ANYWHERE, splice
from tests.faults.fuzzing.e57_damage import IN_E57
from tests.faults.fuzzing.header_damage import IN_PCD, IN_PLY, IN_PTX
from tests.faults.fuzzing.las_damage import IN_LAS
from tests.faults.fuzzing.parquet_damage import IN_PARQUET
from tests.faults.fuzzing.seeds import SETTINGS, SEVERAL, Seed, seeds
from tests.faults.fuzzing.text_damage import IN_TEXT
from tests.faults.fuzzing.toml_damage import IN_TOML

Damage = Callable[[random.Random, bytes], bytes]

WEIGHTS: Mapping[str, int] = {
    "las": 14, "laz": 8, "e57": 18, "ptx": 10, "pts": 7, "ply": 11, "pcd": 11, "xyz": 4, "txt": 2, "csv": 5, "parquet": 4,
    "campaign": 3, "sidecar": 2, "limits": 1,
}  # fmt: skip
FAMILIES = tuple(family for family, weight in WEIGHTS.items() for _ in range(weight))
STRUCTURED: Mapping[str, tuple[Damage, ...]] = {
    "las": IN_LAS, "laz": IN_LAS, "e57": IN_E57, "ptx": (*IN_PTX, *IN_TEXT), "pts": IN_TEXT, "ply": (*IN_PLY * 8, *IN_TEXT),
    "pcd": (*IN_PCD * 8, *IN_TEXT), "xyz": IN_TEXT, "txt": IN_TEXT, "csv": IN_TEXT, "parquet": IN_PARQUET,
}  # fmt: skip
LARGEST_BYTES = 2_000_000
SOUND_SHARE = 0.9
UNITS: tuple[LengthUnit, ...] = ("metre", "metre", "metre", "metre", "metre", "foot")


@dataclass(frozen=True, slots=True)
class Case:
    """A damaged file, and how it is asked for; ``deeds`` are the names of what was done to the seed."""

    number: int
    seed: Seed
    content: bytes
    request: ScanRequest
    deeds: tuple[str, ...]

    @property
    def family(self) -> str:
        """Suffix without its dot, or the kind of settings."""
        return self.seed.family

    @property
    def is_settings(self) -> bool:
        """Whether it is a TOML file."""
        return self.family in SETTINGS


def case_of(number: int, run_seed: int) -> Case:
    """The case of a number in the run of a seed."""
    rng = random.Random(f"{run_seed}/{number}")
    family = FAMILIES[number % len(FAMILIES)]
    seed = rng.choice(_sound(family) if rng.random() < SOUND_SHARE else seeds()[family])
    content, deeds = seed.content, []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        deed, content = _damaged(rng, seed, content)
        deeds.append(deed)
    return Case(number, seed, content[:LARGEST_BYTES], _request(rng, seed), tuple(deeds))


@cache
def _sound(family: str) -> tuple[Seed, ...]:
    return tuple(seed for seed in seeds()[family] if not seed.is_broken)


def _damaged(rng: random.Random, seed: Seed, content: bytes) -> tuple[str, bytes]:
    if rng.random() < 0.04 or not content:
        other = rng.choice(seeds()[rng.choice((seed.family, seed.family, rng.choice(FAMILIES)))])
        return "splice", splice(rng, content, other.content)
    if seed.family in SETTINGS and rng.random() < 0.9:
        change = rng.choice(IN_TOML)
        return change.__name__, change(rng, content.decode("latin-1")).encode("utf-8", "surrogatepass")
    pool = ANYWHERE if seed.family in SETTINGS or rng.random() < 0.3 else STRUCTURED[seed.family]
    damage = rng.choice(pool)
    return damage.__name__, damage(rng, content)


def _request(rng: random.Random, seed: Seed) -> ScanRequest:
    """What a campaign may ask of such a file, mostly what its seed can answer."""
    is_fit = rng.random() < 0.85
    several = seed.name.rpartition("/")[2].startswith(SEVERAL)
    part: str | int | None = (
        rng.choice((None, 1, 2, "east", 99)) if seed.family in {"e57", "ptx", "pts"} else None
    )
    frame: Frame = rng.choice(("scanner", "file"))
    unit = rng.choice(UNITS)
    if is_fit:
        part = rng.choice((1, 2, None)) if several else rng.choice((None, None, 1)) if part else None
        frame = "file" if several and part is None else "scanner" if seed.family == "pcd" else frame
        unit = "metre" if seed.family == "e57" else unit
    return ScanRequest(
        coordinates="polar" if seed.name == "own-polar" and (is_fit or rng.random() < 0.5) else "cartesian",
        origin_m=rng.choice(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (100.0, -20.0, 5.0))),
        swap_axes=rng.random() < 0.15,
        unit=unit,
        frame=frame,
        part=part,
        horizontal=rng.choice((None, None, None, "local", "EPSG:25833")),
        levelling="file" if seed.family in {"e57", "ptx", "pcd"} and rng.random() < 0.08 else "scanner",
    )
