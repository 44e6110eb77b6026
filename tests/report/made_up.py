"""Invented reports with known figures."""


def measure(name, median, spread=0.02, reference=False):
    """A sample whose quartiles differ from the median by the fraction `spread`."""
    return {"name": name, "reference": reference, "samples": 41, "least": median * (1 - 2 * spread), "lower_quartile": median * (1 - spread),
            "median": median, "upper_quartile": median * (1 + spread), "most": median * (1 + 2 * spread)}


def section(name, measures, **more):
    return {"id": name, "title": name, "paper": "", "ours": "Made up.", "verdict": "not comparable", "why": "Made up.", "result_hash": "00",
            "table": {"columns": [], "rows": []}, "charts": [], "measures": measures} | more


def report(*sections, **more):
    return {"kind": "all", "date": "2026-01-01T00:00:00Z", "effort": "quick", "load": 1.0,
            "machine": {"cpu": "Abacus", "cores": 2, "compiler": "GNU 12.2.0", "build_type": "Release", "commit": "0" * 40},
            "sections": list(sections)} | more
