"""What a run found, by reader."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

COLUMNS = ("refused", "same", "as it says", "told", "undecidable", "finding", "crash", "hang")
FAULTS = frozenset({"finding", "crash", "hang"})


@dataclass(slots=True)
class Figures:
    """Counts by reader and outcome, the slowest case, the most memory, all that is a fault, and how children grew."""

    counts: dict[str, Counter[str]] = field(default_factory=dict)
    slowest: dict[str, tuple[float, int]] = field(default_factory=dict)
    peak: dict[str, int] = field(default_factory=dict)
    faults: list[Mapping[str, object]] = field(default_factory=list)
    grown: list[int] = field(default_factory=list)

    def add(self, answer: Mapping[str, object]) -> None:
        """Count the answer of one case, or what a child says when it hands over."""
        if "again" in answer:
            self.grown.append(int(str(answer["grown"])))
            return
        family, outcome = str(answer["family"]), str(answer["outcome"])
        self.counts.setdefault(family, Counter())[outcome] += 1
        seconds, number = float(str(answer["cpu"])), int(str(answer["case"]))
        self.slowest[family] = max(self.slowest.get(family, (0.0, 0)), (seconds, number))
        self.peak[family] = max(self.peak.get(family, 0), int(str(answer["peak"])))
        if outcome in FAULTS:
            self.faults.append(answer)

    @property
    def n_cases(self) -> int:
        """How many cases were counted."""
        return sum(counter.total() for counter in self.counts.values())

    def as_json(self) -> dict[str, object]:
        """All figures, for a file."""
        return {
            "cases": self.n_cases,
            "readers": {
                family: {
                    **{name: counter[name] for name in COLUMNS},
                    "cases": counter.total(),
                    "slowest_s": self.slowest[family][0],
                    "slowest_case": self.slowest[family][1],
                    "memory_above_base_mib": self.peak[family] >> 20,
                }
                for family, counter in sorted(self.counts.items())
            },
            "grown_mib_in_10000_cases": [n_bytes >> 20 for n_bytes in self.grown],
            "faults": self.faults,
        }

    def lines(self) -> Iterator[str]:
        """The table, a line a reader."""
        heads = ("reader", "cases", *COLUMNS, "slowest s", "case", "MiB")
        yield " | ".join(heads)
        total: Counter[str] = Counter()
        for family, counter in sorted(self.counts.items()):
            total.update(counter)
            seconds, number = self.slowest[family]
            yield _row(family, counter, f"{seconds:.3f}", str(number), str(self.peak[family] >> 20))
        yield _row("all", total, "", "", str(max(self.peak.values(), default=0) >> 20))


def _row(name: str, counter: Counter[str], *more: str) -> str:
    return " | ".join((name, str(counter.total()), *(str(counter[column]) for column in COLUMNS), *more))
