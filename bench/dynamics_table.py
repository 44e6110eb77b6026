#!/usr/bin/env python3
"""Writes the tables of docs/benchmarks.md from the JSON of palpate_bench_dynamics.

Usage: dynamics_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'dynamics table' is replaced.
"""

import page

PRECONDITIONERS = ("jacobi", "two-level", "factor", "auto")
# What we set out to reach, times Eigen: update and solution.
MUST = {"stacking": (20, 20), "skull": (22, 30), "block": (12, 8)}
MUST_PRODUCT = 70  # % of the bandwidth of reading


def verdict(found, must):
    return f"{must}×, {'met' if found >= must else 'missed'}"


def update_rows(cases):
    yield "| work | Eigen ms | ours ms | ratio | must |"
    yield "|---|---:|---:|---:|---|"
    for case in cases:
        name = f"{case['name']} ({case['points']} points, {case['tets']} tets)"
        eigen = case["eigen"]
        ours = case["update_ms"]
        must_update, must_solve = MUST[case["name"]]
        ratio = eigen["update_ms"] / ours
        yield f"| {name}: rotations, forces, assembly | {eigen['update_ms']:.2f} | {ours:.2f} | {ratio:.1f}× | {verdict(ratio, must_update)} |"
        solves = case["solve"]
        best = min(PRECONDITIONERS, key=lambda key: solves[key]["ms"])
        time = solves[best]["ms"]
        ratio = eigen["solve_ms"] / time
        yield f"| {name}: solution, {best} | {eigen['solve_ms']:.2f} | {time:.2f} | {ratio:.1f}× | {verdict(ratio, must_solve)} |"
        whole = eigen["update_ms"] + eigen["solve_ms"]
        yield f"| {name}: both | {whole:.2f} | {ours + time:.2f} | {whole / (ours + time):.1f}× | |"


def solve_rows(cases):
    yield "| solution | preconditioner | ms | iterations | largest error |"
    yield "|---|---|---:|---:|---:|"
    for case in cases:
        eigen = case["eigen"]
        yield (f"| {case['name']} | Eigen, {eigen['preconditioner']} | {eigen['solve_ms']:.2f} | {eigen['iterations']} | "
               f"{eigen['largest_error']:.1e} |")
        for key in PRECONDITIONERS:
            run = case["solve"][key]
            yield f"| {case['name']} | {key} | {run['ms']:.2f} | {run['iterations']} | {run['largest_error']:.1e} |"


def product_rows(cases):
    yield "| product with the matrix | MB | ms | GB/s | of reading as many bytes | must |"
    yield "|---|---:|---:|---:|---:|---|"
    for case in cases:
        product = case["product"]
        share = product["GB_per_s"] / product["read_GB_per_s"]
        yield (f"| {case['name']} | {product['bytes'] / 1e6:.1f} | {product['ms']:.3f} | {product['GB_per_s']:.1f} | "
               f"{100 * share:.0f} % | {MUST_PRODUCT} %, {'met' if 100 * share >= MUST_PRODUCT else 'missed'} |")


def table(report):
    lines = [page.machine(report), ""]
    for rows in (update_rows, solve_rows, product_rows):
        lines += [*rows(report["cases"]), ""]
    return "\n".join(lines[:-1]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "dynamics", table)
