"""Progress of long calls, by tqdm if requested."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Protocol

from ._error import Error


class Bar(Protocol):
    """The functions of a progress bar that are used here."""

    def update(self, n: int = 1) -> Any: ...
    def __enter__(self) -> Any: ...
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> Any: ...


class _Hidden:
    def update(self, n: int = 1) -> None:
        pass

    def __enter__(self) -> _Hidden:
        return self

    def __exit__(self, *_: object) -> None:
        pass


def needed(package: str, what: str, extra: str) -> Error:
    """The error of a call that needs a missing package."""
    return Error(what, "", f"no package {package}", f"this package: pip install 'palpate[{extra}]'")


def bar(shown: bool, total: int, unit: str, done: int = 0) -> Bar:
    """A bar of `total` units, `done` of which are complete; shows nothing unless requested."""
    if not shown:
        return _Hidden()
    try:
        from tqdm import tqdm
    except ImportError:
        raise needed("tqdm", "progress", "study") from None
    progress: Bar = tqdm(total=total, unit=unit, initial=done)
    return progress
