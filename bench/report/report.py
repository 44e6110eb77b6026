#!/usr/bin/env python3
"""Writes report.html and one PNG a chart from what 'palpate bench' measured: report.py REPORT.json FOLDER

The page is one file that needs no network and no script: tables, texts and charts (Vega-Lite, drawn to SVG by vl-convert).
"""

import html
import json
import pathlib
import re
import sys

import vl_convert

# Okabe and Ito's colours tell apart for all eyes; dashes and marks do so in grey.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#999999"]
DASHES = [[1, 0], [6, 3], [2, 2], [8, 3, 2, 3], [4, 4], [10, 2], [1, 3], [12, 4]]

STYLE = """
:root { color-scheme: light; font: 16px/1.5 system-ui, sans-serif; }
body { max-width: 60rem; margin: 0 auto; padding: 1rem; color: #1a1a1a; background: #fff; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; border-top: 1px solid #ccc; padding-top: 1rem; }
table { border-collapse: collapse; font-size: 0.9rem; } .wide { overflow-x: auto; }
th, td { padding: 0.2rem 0.7rem; text-align: right; border-bottom: 1px solid #e4e4e4; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } td.text { text-align: left; }
.verdict { display: inline-block; padding: 0.1rem 0.6rem; border: 1.5px solid; border-radius: 0.4rem; font-weight: 600; }
.agrees { color: #00563f; } .differs { color: #8a3200; } .not-comparable { color: #555; }
dt { font-weight: 600; } dd { margin: 0 0 0.5rem 0; } svg { max-width: 100%; height: auto; }
nav li { margin: 0.1rem 0; }
"""


def slug(text):
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def cell(value):
    if value is None:
        return "<td>–</td>"
    if isinstance(value, str):
        return f'<td class="text">{html.escape(value)}</td>'
    if isinstance(value, float):
        return f"<td>{value:.4g}</td>"
    return f"<td>{value}</td>"


def table(section):
    columns = section["table"]["columns"]
    if not columns:
        return ""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    rows = "".join("<tr>" + "".join(cell(value) for value in row) + "</tr>" for row in section["table"]["rows"])
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def chart_spec(chart):
    names = [series["name"] for series in chart["series"]]
    values = [{"series": series["name"], "x": x, "y": y}
              for series in chart["series"] for x, y in zip(series["x"], series["y"])]
    scale = {"type": "log"} if chart["logarithmic"] else {"zero": True}
    few = all(len(series["x"]) <= 30 for series in chart["series"])
    return {
        "$schema": "https://vega.github.io/schema/vega-lite/v5.json",
        "title": chart["title"],
        "width": 640, "height": 320,
        "config": {"font": "sans-serif", "axis": {"labelFontSize": 13, "titleFontSize": 14},
                   "legend": {"labelFontSize": 13, "labelLimit": 300, "title": None}, "title": {"fontSize": 16}},
        "data": {"values": values},
        "mark": {"type": "line", "point": few, "strokeWidth": 2 if few else 1},
        "encoding": {
            "x": {"field": "x", "type": "quantitative", "title": chart["x_label"],
                  "scale": {"type": "log"} if chart["logarithmic"] else {"zero": False, "nice": False}},
            "y": {"field": "y", "type": "quantitative", "title": chart["y_label"], "scale": scale},
            "color": {"field": "series", "type": "nominal", "sort": names,
                      "scale": {"domain": names, "range": COLOURS[:len(names)]}, "legend": {"orient": "bottom", "columns": 2}},
            "strokeDash": {"field": "series", "type": "nominal", "sort": names,
                           "scale": {"domain": names, "range": DASHES[:len(names)]}},
        },
    }


def draw(chart, folder, place):
    spec = json.dumps(chart_spec(chart))
    (folder / f"{place:02d}-{slug(chart['title'])}.png").write_bytes(vl_convert.vegalite_to_png(spec, scale=2))
    return vl_convert.vegalite_to_svg(spec)


def section_html(section, svgs):
    verdict = section["verdict"]
    return (f'<section id="{section["id"]}"><h2>{html.escape(section["title"])}</h2>'
            f'<p><span class="verdict {slug(verdict)}">{verdict}</span> {html.escape(section["why"])}.</p>'
            f'<dl><dt>The paper</dt><dd>{html.escape(section["paper"])}</dd>'
            f'<dt>Here</dt><dd>{html.escape(section["ours"])}</dd></dl>{"".join(svgs)}{table(section)}</section>')


def page(report, bodies):
    machine = report["machine"]
    links = "".join(f'<li><a href="#{s["id"]}">{html.escape(s["title"])}</a>: {s["verdict"]}</li>' for s in report["sections"])
    facts = html.escape(f'{machine["cpu"]}, {machine["cores"]} cores; {machine["compiler"]}, {machine["build_type"]}; '
                        f'commit {machine["commit"]}; {report["effort"]}')
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1"><title>Palpate and the paper</title>'
            f"<style>{STYLE}</style></head><body><h1>The paper's results, measured anew</h1>"
            "<p>“Efficient uniform grids for collision handling in medical simulators”, item by item. Times are medians or least "
            f"times of this machine; all ways measure the same positions in turns.</p><p>{facts}</p>"
            f"<nav><ul>{links}</ul></nav>{''.join(bodies)}</body></html>\n")


def main(arguments):
    if len(arguments) != 2:
        raise SystemExit(__doc__)
    report = json.loads(pathlib.Path(arguments[0]).read_text())
    folder = pathlib.Path(arguments[1])
    folder.mkdir(parents=True, exist_ok=True)
    place = 0
    bodies = []
    for section in report["sections"]:
        svgs = []
        for chart in section["charts"]:
            place += 1
            svgs.append(draw(chart, folder, place))
        bodies.append(section_html(section, svgs))
    beside = folder / "report.html.new"
    beside.write_text(page(report, bodies))
    beside.rename(folder / "report.html")


if __name__ == "__main__":
    main(sys.argv[1:])
