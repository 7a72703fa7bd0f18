"""What can be wrong with a robot's description."""

from collections.abc import Sequence


class DescriptionError(ValueError):
    """A robot cannot be loaded; ``problems`` lists every mismatch that was found."""

    def __init__(self, source: str, problems: Sequence[str]):
        self.source = source
        self.problems = tuple(problems)
        super().__init__(f"{source}: " + "; ".join(self.problems))
