"""The one exception of the package, and its one warning."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any


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


class WrongArgument(Error, TypeError):
    """An argument of a wrong type: an Error that is a TypeError too, as Python programmers expect it."""


class NotConverged(UserWarning):
    """Steps of a simulation were not solved to the tolerance of the scene: its positions may be wrong."""


def wrong_arguments(text: str, args: Sequence[Any], named: Mapping[str, Any], setter: str) -> WrongArgument:
    """The error for a call of the compiled part whose arguments fit none of its signatures.

    text: the error of nanobind, which has the signatures, a line each, but not which argument is wrong. setter: the
    property that was set; empty for a call.
    """
    lines = [line.split(". ", 1)[1] for line in text.splitlines()[1:] if line[:4] == "    " and ". " in line]
    name = lines[0].split("(", 1)[0].removeprefix("def ") if lines else text.split("(", 1)[0]
    parameters = [_parameters(line) for line in lines]
    own = bool(parameters) and bool(parameters[0]) and parameters[0][0][0] == "self" and bool(args)
    if own:
        owner = type(args[0]).__name__
        name = owner if name == "__init__" or setter else f"{owner}.{name}"
        args, parameters = args[1:], [all_[1:] for all_ in parameters]
    name = _public_caller() or name
    if name == "Material" and not setter and (args or "tissue" in named):
        return _wrong_material(args, named)
    found = ", ".join([shown(value) for value in args] + [f"{key}={shown(value)}" for key, value in named.items()])
    if len(parameters) == 1:
        wrong = _wrong_argument(parameters[0], args, named)
        if wrong is not None:
            return WrongArgument(name, setter or wrong[0], *wrong[1:])
    expected = " or ".join(f"({', '.join(f'{key}: {_words(kind)}' for key, kind, _ in row)})" for row in parameters)
    return WrongArgument(name, "", f"({found})", expected)


def _wrong_material(args: Sequence[Any], named: Mapping[str, Any]) -> WrongArgument:
    """The error for Material("liver") and Material(tissue="liver"), which people try first, and for Material(1e4)."""
    value = args[0] if args else named["tissue"]
    where, found = ("", f"({', '.join(map(shown, args))})") if args else ("tissue", shown(value))
    expected = f"palpate.Material.tissue({value!r})" if isinstance(value, str) else "arguments by name, as young_modulus=1e4"
    return WrongArgument("Material", where, found, expected)


def _public_caller() -> str:
    """The function of the package that was called from outside; empty where it is the compiled one."""
    name = ""
    frame = sys._getframe(2)
    while frame is not None and str(frame.f_globals.get("__name__")).partition(".")[0] == "palpate":
        here = frame.f_code.co_name
        if not here.startswith("<"):
            owner = type(frame.f_locals["self"]).__name__ if "self" in frame.f_locals else ""
            name = owner if here == "__init__" else f"{owner}.{here}".lstrip(".")
        frame = frame.f_back  # type: ignore[assignment]
    return name


_Parameter = tuple[str, str, bool]


def _parameters(signature: str) -> list[_Parameter]:
    """Name, type and whether there is a default, of the parameters of "f(self, a: int, /, b: str = '') -> None"."""
    parts, depth, part = [], 0, ""
    for letter in signature[signature.index("(") + 1 :]:
        depth += (letter in "([{") - (letter in ")]}")
        if depth < 0 or (letter == "," and depth == 0):
            parts.append(part.strip())
            part = ""
            if depth < 0:
                break
        else:
            part += letter
    rows = []
    for part in parts:
        if part in ("", "/", "*"):
            continue
        typed, has_default, _ = part.partition(" = ")
        key, _, kind = typed.partition(": ")
        rows.append((key, kind, bool(has_default)))
    return rows


# Where values are that are taken for those of a material.
_ELSEWHERE = {"friction": "it in the settings of contacts: contact={'friction': 0.3} of a Simulation or a scene"}


def _wrong_argument(parameters: list[_Parameter], args: Sequence[Any], named: Mapping[str, Any]) -> tuple[str, str, str] | None:
    """Where, found and expected of the first argument that does not fit; None where each alone would."""
    keys = [key for key, _, _ in parameters]
    unknown = [key for key in named if key not in keys]
    if unknown and unknown[0] in _ELSEWHERE:
        return unknown[0], "an argument of this name", _ELSEWHERE[unknown[0]]
    if unknown:
        near = get_close_matches(unknown[0], keys, 1)
        expected = repr(near[0]) if near else f"one of {keys}" if keys else "no argument"
        return unknown[0], "an argument of this name", expected
    if len(args) > len(parameters):
        return "", "an argument" if len(args) == 1 else f"{len(args)} arguments", f"at most {len(parameters)}"
    values = {**dict(zip(keys, args)), **named}
    for key, _, has_default in parameters:
        if key not in values and not has_default:
            return key, "nothing", "a value"
    given = [(key, kind, values[key]) for key, kind, _ in parameters if key in values]
    for key, kind, value in given:
        if not _fits(value, kind):
            return ("" if key.startswith("arg") else key), shown(value), _words(kind)
    rows = [(key, kind, value) for key, kind, value in given if "Sequence[" in kind]
    if len(rows) == 1:  # each item fits, so that their number does not
        key, kind, value = rows[0]
        return key, shown(value), f"{_words(kind)} of another length"
    return None


def _fits(value: Any, kind: str) -> bool:
    """Whether a value can be of a type, as the text of a signature has it; True for types that are not known here."""
    kind = kind.replace("collections.abc.", "").replace("typing.", "")
    if kind.endswith(" | None"):
        return value is None or _fits(value, kind.removesuffix(" | None"))
    if kind == "int":
        return hasattr(value, "__index__") and -(2**31) <= value.__index__() < 2**31
    if kind == "float":
        if type(value).__name__ in ("bool", "bool_"):  # also those of NumPy
            return False
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "str" or kind.startswith("Literal["):
        return isinstance(value, str)
    if kind == "bytes":
        return isinstance(value, bytes)
    if kind.startswith(("Sequence[", "list[")):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__len__") or not hasattr(value, "__getitem__"):
            return False
        inner = kind[kind.index("[") + 1 : -1]
        return not hasattr(value, "keys") and all(_fits(item, inner) for item in value)
    own = kind.rpartition(".")[2]
    if own.isidentifier() and own[0].isupper() and own != "Any":
        return any(one.__name__ == own for one in type(value).__mro__)
    return True


def _words(kind: str) -> str:
    """A type of a signature in words."""
    kind = kind.replace("collections.abc.", "").replace("typing.", "").replace("palpate._core.", "")
    if kind.endswith(" | None"):
        return f"{_words(kind.removesuffix(' | None'))} or None"
    if kind.startswith(("Sequence[", "list[")):
        inner = kind[kind.index("[") + 1 : -1]
        many = {"float": "numbers", "int": "integers", "str": "texts"}.get(inner, f"{inner} objects")
        return f"a sequence of {many}"
    if kind.startswith("NDArray["):
        return "an array"
    if kind.startswith("Literal["):
        return f"one of {kind[8:-1]}"
    known = {"int": "an integer", "float": "a number", "bool": "True or False", "str": "a text", "bytes": "bytes", "": "a value"}
    return known.get(kind, f"a palpate.{kind}")


def shown(value: Any) -> str:
    """A value in few letters: what it is, or its type."""
    if value is None or isinstance(value, (bool, int, float, str, list, tuple)):
        text = repr(value)
        if len(text) <= 40 and "\n" not in text:
            return text
    name = type(value).__name__
    return f"{'an' if name[0] in 'aeioAEIO' else 'a'} {name}"
