"""Words that must not come back, each with the term of the field (issue 27), and where they may stay, each with a reason."""

# Parts of names: `share` is found in `share`, `try_share` and `SideShare`, and not in `shared`.
NAMES = {
    "calming": "damping",
    "foresight": "prediction",
    "judge": "check, estimate, compare",
    "judged": "checked, estimated, compared",
    "knowledge": "cache, state",
    "knows": "has",
    "lately": "recent",
    "rails": "prescribed motion",
    "remembered": "cached, history",
    "share": "fraction, weight, scale, part",
    "shares": "fractions, weights",
    "way": "exit, direction, displacement, method, mode",
    "ways": "exits, directions, displacements, methods, modes",
    "worn": "stale",
}

# In comments, messages, docstrings and pages: a regular expression, and the term.
TEXT = {
    r"calming": "chatter damping",
    r"foresight": "search at predicted positions",
    r"side shares?": "rim falloff",
    r"remembered planes?": "cached plane",
    r"what is known of (?:a|the|each) (?:contact|cluster)s?": "cached plane, state",
    r"know nothing|knows? of no plane": "without a cached plane",
    r"in vain": "without success",
    r"on rails": "prescribed, with a prescribed motion",
    r"turned frames?": "corotated or rotated frame",
    r"straight ways?": "path, line, displacement",
    r"worn out": "stale",
    r"(?:its|their|own|a|the|this|that) shares? of": "fraction of, part of",
    r"finds? (?:its|their) way out|ways? out": "exit",
    r"lets? go of": "release, separate",
    r"scenes by chance": "random scenes",
    r"is told at once": "is reported",
    r"of late|lately": "recent",
    r"hangs? together": "connected",
    r"takes? no part": "left out",
    r"told apart": "distinguished",
    r"in place of": "instead of",
    r"(?:at present|present (?:positions?|steps?|frames?|times?|states?|places?|velocity|velocities|contacts?))": "current, now",
    r"(?:throws|raises) (?:an? )?\w+ where": "Throws X if",
    r"anew": "again, from scratch",
    r"wants": "needs",
    r"(?:goes|going|go) on(?: from)?(?! to)": "continues, resumes from",
    r"parallel shares?": "parallel fraction",
    r"(?:equal|same|right) to rounding": "equal up to rounding",
    r"in turns": "alternately",
    r"clusters asked": "clusters queried",
    r"second tries": "retries",
    r"time that passed": "wall time",
    r"as we have (?:it|them)": "our version of",
    r"not found anew": "not recomputed",
    r"answers that are not ours": "independent solutions",
}

# What is not checked: history keeps the words of its time.
HISTORY = ["CHANGELOG.md", "docs/notes/*", "tests/house/words.py", "tests/house/test_words.py"]
# (files, word or phrase, reason)
ALLOWED = [
    ("docs/glossary.md", "*", "it maps these words to the terms"),
    ("tests/python/test_world.py", "shares_memory", "a function of NumPy"),
    ("tests/report/*", "share", "data that the report under test reads by this name"),
]
