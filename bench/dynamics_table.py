#!/usr/bin/env python3
"""Writes the tables of the dynamics in docs/benchmarks-steps.md from dynamics.json of `palpate bench speed`.

Usage: dynamics_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'dynamics table' is replaced.
"""

import page

# Those that a result has; before multigrid there were two others.
PRECONDITIONERS = ("jacobi", "two-level", "factor", "multigrid", "auto")


def update_rows(cases):
    yield "| work | Eigen, ms | Palpate, ms | ratio |"
    yield "|---|---:|---:|---:|"
    for case in cases:
        name = f"{case['name']} ({case['points']} points, {case['tets']} tets)"
        eigen = case["eigen"]
        best = min((name for name in PRECONDITIONERS if name in case["solve"]), key=lambda key: case["solve"][key]["ms"])
        update, solve = (eigen["update_ms"], case["update_ms"]), (eigen["solve_ms"], case["solve"][best]["ms"])
        whole = [a + b for a, b in zip(update, solve)]
        for words, (other, ours) in (("rotations, forces, assembly", update), (f"solution, {best}", solve), ("both", whole)):
            yield f"| {name}: {words} | {other:.2f} | {ours:.2f} | {other / ours:.1f}× |"


def solve_rows(cases):
    yield "| solution | preconditioner | ms | iterations | largest error |"
    yield "|---|---|---:|---:|---:|"
    for case in cases:
        eigen = case["eigen"]
        yield (f"| {case['name']} | Eigen, {eigen['preconditioner']} | {eigen['solve_ms']:.2f} | {eigen['iterations']} | "
               f"{eigen['largest_error']:.1e} |")
        for key in (name for name in PRECONDITIONERS if name in case["solve"]):
            run = case["solve"][key]
            yield f"| {case['name']} | {key} | {run['ms']:.2f} | {run['iterations']} | {run['largest_error']:.1e} |"


def product_rows(cases):
    yield "| product with the matrix | MB | ms | GB/s | fraction of the speed of plain reading |"
    yield "|---|---:|---:|---:|---:|"
    for case in cases:
        product = case["product"]
        fraction = product["GB_per_s"] / product["read_GB_per_s"]
        yield f"| {case['name']} | {product['bytes'] / 1e6:.1f} | {product['ms']:.3f} | {product['GB_per_s']:.1f} | {100 * fraction:.0f} % |"


def table(report):
    lines = [page.machine(report), ""]
    for rows in (update_rows, solve_rows, product_rows):
        lines += [*rows(report["cases"]), ""]
    return "\n".join(lines[:-1]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "dynamics", table)
