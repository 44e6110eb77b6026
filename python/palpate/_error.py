"""The one exception of the package, and its one warning."""

from __future__ import annotations

from typing import Any


def typed(value: Any) -> str:
    """The type of a value with its article: "an int"."""
    name = type(value).__name__
    return f"{'an' if name[0] in 'aeioAEIO' else 'a'} {name}"


class Error(ValueError):
    """A bad file, mesh, scene, array or parameter, or a simulation that cannot continue.

    Its text is one line, "SOURCE: WHERE: found FOUND, expected EXPECTED" (WHERE is left out when empty); the four parts
    are attributes.
    """

    source: str
    """The file, or the function or parameter set that was given the bad value."""
    where: str
    """Line, index or key inside the source; may be empty."""
    found: str
    """What was there."""
    expected: str
    """What would have been right."""

    def __init__(self, source: str, where: str, found: str, expected: str) -> None:
        place = f"{source}: {where}" if where else source
        super().__init__(f"{place}: found {found}, expected {expected}")
        self.source, self.where, self.found, self.expected = source, where, found, expected

    def __reduce__(self) -> tuple[type[Error], tuple[str, str, str, str]]:
        return type(self), (self.source, self.where, self.found, self.expected)


class NotConverged(UserWarning):
    """Steps of a simulation were not solved to the tolerance of the scene: its positions may be wrong."""
