"""Settings with the keys of scene files (docs/scene.md), checked by the reader of scene files."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

from . import _core
from ._error import Error

_threads = 0


def set_threads(count: int) -> None:
    """Sets the number of threads of objects made from now on; 0 takes all cores.

    Results have the same bits for every number of threads.
    """
    global _threads
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= _core.most_threads:
        raise Error("set_threads", "", repr(count), f"0 (all) to {_core.most_threads}")
    _threads = count


def get_threads() -> int:
    """The number given to set_threads(); 0 means all cores."""
    return _threads


def threads_or_default(threads: int | None) -> int:
    """`threads`; if None, the number of set_threads()."""
    if threads is None:
        return _threads
    if isinstance(threads, bool) or not isinstance(threads, int) or not 0 <= threads <= _core.most_threads:
        raise Error("threads", "", repr(threads), f"0 (all) to {_core.most_threads}")
    return threads


def _plain(value: Any) -> Any:
    """Converts NumPy's numbers and arrays, and paths, to types of JSON."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} cannot be a value of a scene")


def _not_finite(value: Any, place: str = "") -> tuple[str, float] | None:
    """The first number that is not finite, and the path of its key: "bodies[0].material.density"."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, float) and not math.isfinite(value):
        return place, value
    items: Iterable[tuple[str, Any]] = ()
    if isinstance(value, Mapping):
        items = ((f"{place}.{key}".lstrip("."), item) for key, item in value.items())
    elif isinstance(value, (list, tuple)):
        items = ((f"{place}[{number}]", item) for number, item in enumerate(value))
    return next((found for key, item in items if (found := _not_finite(item, key)) is not None), None)


def scene_text(scene: Mapping[str, Any], source: str) -> str:
    """A scene as text."""
    try:
        return json.dumps(scene, default=_plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        wrong = _not_finite(scene) if "not JSON compliant" in str(error) else None
        if wrong is not None:
            raise Error(source, wrong[0], str(wrong[1]), "a finite number") from None
        raise Error(source, "", str(error), "text, finite numbers, lists and mappings of them") from None


def settings(source: str, values: Mapping[str, Any]) -> _core.Scene:
    """A scene of which only the settings are used; errors name `source` and the key."""
    stand_in = {"ball": {"radius": 1.0, "resolution": 1}, "material": {}}
    return _core.Scene.parse(scene_text({**values, "bodies": [stand_in]}, source), source)
