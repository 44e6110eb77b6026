#!/usr/bin/env python3
"""Writes the tables of docs/benchmarks.md from the JSON of palpate_bench_dynamics.

Usage: dynamics_table.py JSON [MARKDOWN]   (without MARKDOWN: prints)

In MARKDOWN the text between the two marks 'dynamics table' is replaced.
"""

import page

PRECONDITIONERS = ("jacobi", "two-level", "auto")


def update_rows(cases):
    yield "| work | Eigen ms | ours ms | ratio |"
    yield "|---|---:|---:|---:|"
    for case in cases:
        name = f"{case['name']} ({case['points']} points, {case['tets']} tets)"
        eigen = case["eigen"]
        ours = case["update_ms"]
        yield f"| {name}: rotations, forces, assembly | {eigen['update_ms']:.2f} | {ours:.2f} | {eigen['update_ms'] / ours:.1f}× |"
        solves = case["solve"]
        best = min(PRECONDITIONERS, key=lambda key: solves[key]["ms"])
        time = solves[best]["ms"]
        yield f"| {name}: solution, {best} | {eigen['solve_ms']:.2f} | {time:.2f} | {eigen['solve_ms'] / time:.1f}× |"
        whole = eigen["update_ms"] + eigen["solve_ms"]
        yield f"| {name}: both | {whole:.2f} | {ours + time:.2f} | {whole / (ours + time):.1f}× |"


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
    yield "| product with the matrix | MB | ms | GB/s | of reading as many bytes |"
    yield "|---|---:|---:|---:|---:|"
    for case in cases:
        product = case["product"]
        share = product["GB_per_s"] / product["read_GB_per_s"]
        yield (f"| {case['name']} | {product['bytes'] / 1e6:.1f} | {product['ms']:.3f} | {product['GB_per_s']:.1f} | "
               f"{100 * share:.0f} % |")


def table(report):
    context = report["context"]
    references = report["references"]
    lines = [
        f"{context['cpu']}, {context['cores']} cores, one used; {context['compiler']}; commit `{context['commit']}`. memcpy of 64 MiB "
        f"{references['memcpy_GB_per_s']:.1f} GB/s, `std::sort` of a million floats {references['sort_ms']:.0f} ms, 20 million dependent "
        f"multiply-adds {references['multiply_add_ms']:.0f} ms.",
        "",
    ]
    for rows in (update_rows, solve_rows, product_rows):
        lines += [*rows(report["cases"]), ""]
    return "\n".join(lines[:-1]) + "\n"


if __name__ == "__main__":
    page.write_table(__doc__, "dynamics", table)
