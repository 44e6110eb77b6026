"""The Python reference: of each name in palpate.__all__ its signature, with types, and its docstring.

Read from the sources of the package and the stub of its compiled part, without importing them.
"""

import re

import griffe

GROUPS = [  # title and names of its section; the others are found by what they are
    ("Detection", ["detect", "World"]),
    ("Simulation", ["Simulation", "SimulationBodies", "SimulationBody", "Grab", "Model", "Material", "Fibres", "Viscosity", "Motion",
                    "Keyframe", "Ramp"]),
]
SPOKEN = ("__len__", "__getitem__", "__iter__", "__contains__")  # methods that calls do not name
TYPES = {}  # see names_of_types()
CODE = re.compile(r"(`[^`]*`)")
SPECIAL = re.compile(r"([\\*_<>\[\]|$#~])")


def escaped(text):
    """Plain text as Markdown: all but `code` means itself."""
    return "".join(part if part.startswith("`") else SPECIAL.sub(r"\\\1", part) for part in CODE.split(text))


def blocks(docstring):
    """The paragraphs of a docstring, each in one line."""
    return [" ".join(block.split()) for block in re.split(r"\n\s*\n", docstring.strip())]


def fields(docstring, parameters):
    """Splits a docstring into paragraphs and (names, text) of parameters: "name: text" at the begin of a sentence."""
    if not parameters:
        return [("", block) for block in blocks(docstring)]
    name = "|".join(map(re.escape, parameters))
    start = re.compile(rf"(?:^|(?<=[.)] )|(?<=\n))((?:{name})(?:, (?:{name}))*): ")
    found = []
    for block in re.split(r"\n\s*\n", docstring.strip()):
        block = re.sub(r"\n\s*(?=\S)", "\n", block)
        parts = start.split(block)
        found.append(("", parts[0]))
        for names, text in zip(parts[1::2], parts[2::2]):
            text, raises, error = text.partition("Raises Error") if re.search(r"[.)]\sRaises Error", text) else (text, "", "")
            found.append((names, text))
            found.append(("", raises + error))
    return [(names, " ".join(text.split())) for names, text in found if text.strip()]


def body_of(docstring, parameters=()):
    """A docstring as Markdown, with the parameters that it explains as a list in a field."""
    lines, listed = [], False
    for names, text in fields(docstring, parameters):
        if names and not listed:
            lines += ["", ":Parameters:"]
        if names:
            lines += [f"  - **{escaped(names)}** – {escaped(text)}"]
        else:
            lines += ["", escaped(text), ""]
        listed = bool(names)
    return lines


def names_of_types(package):
    """What our own names of types stand for: Structure, Floats and so on, which a user does not meet."""
    found = [each for module in ("_names", "_arrays", "_sweep") for each in package[module].attributes.values()]
    return {each.name: str(each.value) for each in found if each.name[0].isupper() and each.value}


def annotation(expression):
    """A type as it reads: without the modules that it comes from."""
    text = re.sub(r"\b[A-Z]\w*\b(?!\()", lambda name: TYPES.get(name[0], name[0]), str(expression or ""))
    text = re.sub(r"Annotated\[(NDArray\[[\w.]+\]), dict\([^]]*\)\]", r"\1", text)
    return re.sub(r"\b(?:numpy\.typing|numpy|np|_core|_arrays|palpate|os|_object)\.", "", text)


def signature(function, is_method):
    """The parameters and the result of a function."""
    shown, star = [], False
    for number, parameter in enumerate(function.parameters):
        kind = parameter.kind.value
        if is_method and number == 0 and parameter.name in ("self", "cls"):
            continue
        if kind == "keyword-only" and not star:
            shown.append("*")
            star = True
        star = star or kind == "variadic positional"
        text = {"variadic positional": "*", "variadic keyword": "**"}.get(kind, "") + parameter.name
        if parameter.annotation:
            text += f": {annotation(parameter.annotation)}"
        if parameter.default is not None and not kind.startswith("variadic"):
            text += f" = {parameter.default}" if parameter.annotation else f"={parameter.default}"
        shown.append(text)
        if kind == "positional-only" and number + 1 == len([p for p in function.parameters if p.kind.value == kind]):
            shown.append("/")
    result = annotation(function.returns)
    return f"({', '.join(shown)})" + (f" -> {result}" if result and result != "None" else "")


def directive(kind, name, options, body, fence):
    """A directive of Sphinx's Python domain."""
    return [f"{fence}{{py:{kind}}} {name}", *options, "", *body, fence, ""]


def docstring_of(thing):
    return thing.docstring.value if thing.docstring else ""


def function_lines(name, overloads, fence, is_method=False):
    """A function; each of its overloads, with the docstring of the first."""
    kind = "method" if is_method else "function"
    options = [f":{label}:" for label in ("classmethod", "staticmethod") if label in overloads[0].labels]
    lines = []
    for number, each in enumerate(overloads):
        text = docstring_of(each) if number == 0 else ""
        shown = f"{name}{signature(each, is_method and 'staticmethod' not in each.labels)}"
        lines += directive(kind, shown, options + [":no-index:"] * (number > 0),
                           body_of(text, [parameter.name for parameter in each.parameters]), fence)
    return lines


def is_public(name, member):
    return not name.startswith("_") or name in SPOKEN and bool(docstring_of(member))


def class_lines(name, found):
    """A class with its members: its own, and those that it has from the compiled part."""
    overloads = {each: functions for each, functions in found.overloads.items() if functions}
    members = {**found.inherited_members, **{each: overloads[each][0] for each in overloads}, **found.members}
    maker = members.get("__init__")
    bases = [str(base) for base in found.bases]
    is_error = any("Error" in base or "Warning" in base for base in bases)
    text = docstring_of(found)
    made = docstring_of(maker) if maker is not None else ""
    names = [parameter.name for parameter in maker.parameters] if maker is not None and maker.is_function else []
    body = body_of(text, names) + (body_of(made, names) if made != text else [])
    own = [member for member in members if member in found.members or member in overloads]
    for member in own + [member for member in members if member not in own]:
        each = members[member]
        if not is_public(member, each) or is_error and member not in found.members:
            continue
        if each.is_function:
            body += function_lines(member, overloads.get(member, [each]), ":::", is_method=True)
        elif each.is_attribute:
            options = [f":type: {annotation(each.annotation)}"] if each.annotation else []
            body += directive("property" if "property" in each.labels else "attribute", member, options,
                              body_of(docstring_of(each)), ":::")
    head = name
    if maker is not None and maker.is_function and not is_error:
        head += signature(maker, True).split(" -> ")[0]
    return directive("exception" if is_error else "class", head, [], body, "::::")


def add_reference(pages, folder):
    """The page; folder: where the package `palpate` is, with the stub of its compiled part."""
    package = griffe.load("palpate", search_paths=[folder], allow_inspection=False)
    TYPES.update(names_of_types(package))
    public = [name for name in package.exports if not str(name).startswith("__")]
    found = {str(name): package[str(name)].final_target for name in public}
    grouped = [name for _, names in GROUPS for name in names]
    errors = [name for name in found if found[name].is_class and any("Error" in str(base) or "Warning" in str(base)
                                                                     for base in found[name].bases)]
    functions = [name for name in found if found[name].is_function and name not in grouped]
    results = [name for name in found if name not in [*grouped, *errors, *functions]]
    lines = ["# Python", "", *body_of(docstring_of(package)), "", "```{py:module} palpate", "```", ""]
    for title, names in [*GROUPS, ("Functions", functions), ("What they return", results), ("Errors", errors)]:
        lines += [f"## {title}", ""]
        for name in names:
            thing = found[name]
            lines += [f"### {name}", ""]
            lines += class_lines(name, thing) if thing.is_class else function_lines(name, [thing], ":::")
    pages.add("reference/python.md", "\n".join(lines))
