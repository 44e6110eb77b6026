"""Progress of long calls, by tqdm where it is wanted."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Protocol

from ._error import Error


class Bar(Protocol):
    """What a progress bar can do here."""

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
    """The error of a call that needs a package that is not installed."""
    return Error(what, "", f"no package {package}", f"it to be installed: pip install 'palpate[{extra}]'")


def bar(shown: bool, total: int, unit: str, done: int = 0) -> Bar:
    """A bar of `total` units of which `done` are done; one that shows nothing where it is not wanted."""
    if not shown:
        return _Hidden()
    try:
        from tqdm import tqdm
    except ImportError:
        raise needed("tqdm", "progress", "study") from None
    progress: Bar = tqdm(total=total, unit=unit, initial=done)
    return progress
