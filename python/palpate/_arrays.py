"""Converts arguments to the arrays of the compiled part: float64 or int32, C order. No copy if they are that already."""

from __future__ import annotations

import operator
import os
from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._error import Error, shown

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]

_LARGEST = int(np.iinfo(np.int32).max)


def array_of(values: ArrayLike, name: str) -> NDArray[Any]:
    """An array of any shape and type."""
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise Error(name, "", f"{type(values).__name__} that is not an array ({error})", "an array of numbers") from None
    if array.shape == () and array.dtype.kind not in "fiub":
        raise Error(name, "", shown(values), "numbers, or an array of them")
    return array


def _check_columns(array: NDArray[Any], columns: int, name: str, row: str) -> None:
    if array.ndim == 2 and array.shape[1] == columns:
        return
    found = f"an array of shape {array.shape}"
    if array.ndim == 2 and array.shape[0] == columns:
        raise Error(name, "", found, f"shape (n, {columns}), with a row for each {row}: give {name}.T")
    raise Error(name, "", found, f"shape (n, {columns}), with a row for each {row}")


def reals(array: NDArray[Any], name: str) -> Floats:
    """The same array with real numbers. The compiled part checks that they are finite."""
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise Error(name, "", f"numbers of type {array.dtype}", "real numbers (float64, float32 or integers)")
    return np.ascontiguousarray(array, dtype=np.float64)


def points(values: ArrayLike, name: str) -> Floats:
    """An (n, 3) array of positions. The compiled part checks that they are finite."""
    array = array_of(values, name)
    _check_columns(array, 3, name, "point")
    return reals(array, name)


def finite_vector(values: ArrayLike, name: str) -> tuple[float, float, float]:
    """Three finite numbers."""
    found = vector(values, name)
    if not np.isfinite(found).all():
        raise Error(name, "", f"({', '.join(map(str, found))})", "finite numbers")
    return found


def vector(values: ArrayLike, name: str) -> tuple[float, float, float]:
    """Three numbers. The compiled part checks that they are finite."""
    array = array_of(values, name)
    if array.shape != (3,):
        raise Error(name, "", f"an array of shape {array.shape}", "three numbers")
    x, y, z = reals(array, name).tolist()
    return x, y, z


def number(value: Any, name: str) -> float:
    """One real number. The compiled part checks that it is finite."""
    array = array_of(value, name)
    if array.shape != ():
        raise Error(name, "", f"an array of shape {array.shape}", "one number")
    return float(reals(array.reshape(1), name)[0])


def path(value: Any, name: str) -> str:
    """The path of a file."""
    try:
        return os.fsdecode(value)
    except TypeError:
        raise Error(name, "", shown(value), "a path") from None


def integer(value: Any, name: str) -> int:
    """One integer."""
    try:
        return operator.index(value)
    except TypeError:
        raise Error(name, "", shown(value), "an integer") from None


def vectors(values: ArrayLike, name: str, count: int) -> Floats:
    """A (count, 3) array, or three numbers for all rows."""
    array = array_of(values, name)
    if array.shape == (3,):
        return np.ascontiguousarray(np.broadcast_to(reals(array, name), (count, 3)))
    return points(array, name)


def rows(values: ArrayLike, name: str, chosen: Indices, all_rows: slice) -> NDArray[Any]:
    """The chosen rows of an array that has all of them; another array as it is, to be checked by vectors()."""
    array = array_of(values, name)
    whole = array.ndim == 2 and len(array) == all_rows.stop - all_rows.start
    return array[chosen - all_rows.start] if whole else array


def numbers(values: ArrayLike, name: str, count: int) -> Floats:
    """One real number, shape (), or `count` of them. The compiled part checks that they are finite."""
    array = array_of(values, name)
    if array.shape not in ((), (count,)):
        raise Error(name, "", f"an array of shape {array.shape}", f"one number, or shape ({count},)")
    return reals(array.reshape(-1), name).reshape(array.shape)


def _integers(array: NDArray[Any], name: str) -> Indices:
    if array.dtype.kind not in "iu":
        if array.size > 0 or array.dtype.kind not in "f":
            raise Error(name, "", f"numbers of type {array.dtype}", "integers (int32 or int64)")
    if array.dtype == np.int32:
        return np.ascontiguousarray(array)
    if array.size > 0 and (array.min() < -1 or array.max() > _LARGEST):
        outside = array.min() if array.min() < -1 else array.max()
        raise Error(name, "", f"index {outside}", f"indices from 0 to at most {_LARGEST}")
    return np.ascontiguousarray(array, dtype=np.int32)


def tets(values: ArrayLike, name: str) -> Indices:
    """An (m, 4) array of point indices. The compiled part checks their range."""
    array = array_of(values, name)
    _check_columns(array, 4, name, "tet")
    return _integers(array, name)


def mesh(points_given: ArrayLike, tets_given: ArrayLike) -> tuple[Floats, Indices]:
    """Arrays `points` and `tets` of a mesh. Checks the range of indices."""
    positions, corners = points(points_given, "points"), tets(tets_given, "tets")
    outside = np.flatnonzero(((corners < 0) | (corners >= len(positions))).any(axis=1))
    if outside.size > 0:
        raise Error("tets", f"tet {outside[0]}", f"corners {corners[outside[0]].tolist()}", f"0 to {len(positions) - 1}")
    return positions, corners


def indices(values: ArrayLike, name: str, length: int | None = None) -> Indices:
    """An (n) array of indices, of a given length if any."""
    array = array_of(values, name)
    if array.ndim != 1 or (length is not None and array.shape[0] != length):
        raise Error(name, "", f"an array of shape {array.shape}", f"shape ({'n' if length is None else length},)")
    return _integers(array, name)


def selection(values: ArrayLike, name: str, count: int) -> Indices:
    """Indices from a list of indices, or from a mask of `count` truth values."""
    array = array_of(values, name)
    if array.dtype == np.bool_:
        if array.shape != (count,):
            raise Error(name, "", f"a mask of shape {array.shape}", f"shape ({count},), or indices")
        return np.flatnonzero(array).astype(np.int32)
    chosen = indices(array, name)
    if chosen.size > 0 and (chosen.min() < 0 or chosen.max() >= count):
        outside = chosen.min() if chosen.min() < 0 else chosen.max()
        raise Error(name, "", f"index {outside}", f"0 to {count - 1}")
    return chosen


def joined(parts: Sequence[ArrayLike], name: str, counts: Sequence[int]) -> Floats:
    """The points of bodies that have so many points each, one after the other."""
    if len(parts) != len(counts):
        raise Error(name, "", f"{len(parts)} arrays", f"{len(counts)}, one for each body")
    arrays = [points(part, f"{name}[{i}]") for i, part in enumerate(parts)]
    for i, (array, count) in enumerate(zip(arrays, counts)):
        if len(array) != count:
            raise Error(f"{name}[{i}]", "", f"{len(array)} points", f"{count}, as many as body {i} has")
    return np.concatenate(arrays)
