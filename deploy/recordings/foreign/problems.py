"""What is wrong with a log: counted, with the first places, never fatal."""

from collections import Counter
from pathlib import Path

SHOWN = 5  # places per file and kind


class Problems:
    """Collects lines that could not be used, and warnings."""

    def __init__(self) -> None:
        self.counts: Counter[tuple[str, str]] = Counter()  # by file and kind
        self.places: dict[tuple[str, str], list[str]] = {}
        self.warnings: list[str] = []

    def line(self, file: Path | str, number: int, kind: str, detail: str = "") -> None:
        """Count a line (1 is the first) that is left out because of ``kind``."""
        key = (str(file), kind)
        self.counts[key] += 1
        places = self.places.setdefault(key, [])
        if len(places) < SHOWN:
            places.append(f"{file}:{number}: {kind}" + (f": {detail:.80}" if detail else ""))

    def warn(self, text: str) -> None:
        """Say something that the user should know; the same text once."""
        if text not in self.warnings:
            self.warnings.append(text)

    @property
    def lines(self) -> int:
        """Lines that were left out."""
        return self.counts.total()

    def report(self) -> list[str]:
        """Return the warnings, the first places of each kind, and how many more there are."""
        texts = list(self.warnings)
        for key, places in self.places.items():
            texts += places
            if (more := self.counts[key] - len(places)) > 0:
                texts.append(f"{key[0]}: {key[1]}: {more} more lines")
        return texts
