"""Settings in the words of scene files (docs/scene.md), checked by the reader of scene files."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from . import _core
from ._error import Error

_threads = 0


def set_threads(count: int) -> None:
    """How many threads what is made from now on works with: 0 takes all cores.

    Results have the same bits for every number of threads.
    """
    global _threads
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= _core.most_threads:
        raise Error("set_threads", "", repr(count), f"0 (all) to {_core.most_threads}")
    _threads = count


def get_threads() -> int:
    """The number that set_threads() was given; 0 stands for all cores."""
    return _threads


def threads_or_default(threads: int | None) -> int:
    """`threads`, or where it is None what set_threads() says."""
    if threads is None:
        return _threads
    if isinstance(threads, bool) or not isinstance(threads, int) or not 0 <= threads <= _core.most_threads:
        raise Error("threads", "", repr(threads), f"0 (all) to {_core.most_threads}")
    return threads


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays, and paths, as what JSON knows."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is no value of a scene")


def scene_text(scene: Mapping[str, Any], source: str) -> str:
    """A scene as text."""
    try:
        return json.dumps(scene, default=_plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise Error(source, "", str(error), "text, finite numbers, lists and mappings of them") from None


def settings(source: str, values: Mapping[str, Any]) -> _core.Scene:
    """A scene that stands for its settings only; errors name `source` and the key."""
    stand_in = {"ball": {"radius": 1.0, "resolution": 1}, "material": {}}
    return _core.Scene.parse(scene_text({**values, "bodies": [stand_in]}, source), source)
