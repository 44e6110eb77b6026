#!/usr/bin/env python3
"""Writes report.html and one PNG a chart from what 'palpate bench' measured: report.py REPORT.json FOLDER

The page is one file that needs no network and no script: tables, texts and charts (Vega-Lite, drawn to SVG by vl-convert), each chart
twice: a wide one, and a narrow one with the same size of letters that screens of a phone's width show in its place.
"""

import html
import json
import pathlib
import re
import sys

import vl_convert

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from page import number

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
nav li { margin: 0.1rem 0; } .small { color: #555; font-size: 0.85rem; overflow-wrap: anywhere; }
.narrow { display: none; } @media (max-width: 40rem) { .narrow { display: block; } .wide-chart { display: none; } }
"""


def slug(text):
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def cell(value):
    if value is None:
        return "<td>–</td>"
    if isinstance(value, str):
        return f'<td class="text">{html.escape(value)}</td>'
    if isinstance(value, float):
        return f"<td>{number(value)}</td>"
    return f"<td>{value}</td>"


def table(section):
    columns = section["table"]["columns"]
    if not columns:
        return ""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    rows = "".join("<tr>" + "".join(cell(value) for value in row) + "</tr>" for row in section["table"]["rows"])
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def palette(kinds, names):
    return [kinds[place % len(kinds)] for place in range(len(names))]


def chart_spec(chart, narrow=False):
    names = [series["name"] for series in chart["series"]]
    values = [{"series": series["name"], "x": x, "y": y}
              for series in chart["series"] for x, y in zip(series["x"], series["y"])
              if not chart["logarithmic"] or (x > 0 and y > 0)]
    scale = {"type": "log"} if chart["logarithmic"] else {"zero": True}
    few = all(len(series["x"]) <= 30 for series in chart["series"])
    whole = not chart["logarithmic"] and all(value["x"] == int(value["x"]) for value in values)
    # The same for all channels, so that one legend shows colours, dashes and marks.
    legend = {"orient": "bottom", "columns": 1 if narrow else 2, "columnPadding": 60, "symbolType": "stroke", "symbolSize": 900,
              "symbolStrokeWidth": 2}
    return {
        "$schema": "https://vega.github.io/schema/vega-lite/v5.json",
        "title": {"text": chart["title"], "anchor": "start", "limit": 330 if narrow else 680},
        "width": 270 if narrow else 640, "height": 220 if narrow else 320,
        "config": {"font": "sans-serif", "axis": {"labelFontSize": 13, "titleFontSize": 14},
                   "legend": {"labelFontSize": 13, "labelLimit": 260 if narrow else 300, "title": None}, "title": {"fontSize": 14 if narrow else 16}},
        "data": {"values": values},
        "mark": {"type": "line", "point": few, "strokeWidth": 2 if few else 1},
        "encoding": {
            "x": {"field": "x", "type": "quantitative", "title": chart["x_label"],
                  "axis": {"labelOverlap": True, **({"format": "~s"} if chart["logarithmic"] else {}), **({"tickMinStep": 1} if whole else {}),
                           **({"tickCount": 5} if narrow else {})},
                  "scale": {"type": "log", "nice": False} if chart["logarithmic"] else {"zero": False, "nice": False}},
            "y": {"field": "y", "type": "quantitative", "title": chart["y_label"], "scale": scale,
                  "axis": {"titleFontSize": 11, "titleFontWeight": "normal"} if narrow else {}},
            "color": {"field": "series", "type": "nominal", "sort": names, "legend": legend,
                      "scale": {"domain": names, "range": palette(COLOURS, names)}},
            "strokeDash": {"field": "series", "type": "nominal", "sort": names, "legend": legend,
                           "scale": {"domain": names, "range": palette(DASHES, names)}},
        },
    }


def draw(chart, folder, place):
    """Writes the PNG; returns the chart for the page."""
    spec = json.dumps(chart_spec(chart))
    (folder / f"{place:02d}-{slug(chart['title'])}.png").write_bytes(vl_convert.vegalite_to_png(spec, scale=2))
    narrow = vl_convert.vegalite_to_svg(json.dumps(chart_spec(chart, narrow=True)))
    label = html.escape(chart["title"])
    return (f'<figure aria-label="{label}" style="margin:1rem 0"><div class="wide-chart">{vl_convert.vegalite_to_svg(spec)}</div>'
            f'<div class="narrow">{narrow}</div></figure>')


def section_html(section, svgs):
    verdict = section["verdict"] if section["paper"] else ""
    badge = f'<span class="verdict {slug(verdict)}">{verdict}</span> ' if verdict else ""
    paper = f'<dt>The paper</dt><dd>{html.escape(section["paper"])}</dd>' if section["paper"] else ""
    result = f'<p class="small">Hash of the results: {html.escape(section["result_hash"])}</p>' if section.get("result_hash") else ""
    return (f'<section id="{section["id"]}"><h2>{html.escape(section["title"])}</h2>'
            f'<p>{badge}{html.escape(section["why"].rstrip("."))}.</p>'
            f'<dl>{paper}<dt>Here</dt><dd>{html.escape(section["ours"])}</dd></dl>{"".join(svgs)}{table(section)}{result}</section>')


def facts(report):
    machine = report["machine"]
    return (f'{machine["cpu"]}, {machine["cores"]} cores; {machine["compiler"]}, {machine["build_type"]}; commit {machine["commit"]}; '
            f'{report["effort"]}, {report["date"]}; load of the machine up to {report["load"]:.1f}. {report.get("remarks", "")}')


def page(report, bodies):
    links = "".join(f'<li><a href="#{s["id"]}">{html.escape(s["title"])}</a>{": " + s["verdict"] if s["paper"] else ""}</li>'
                    for s in report["sections"])
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1"><title>Palpate, measured</title>'
            f"<style>{STYLE}</style></head><body><h1>Palpate, measured</h1>"
            "<p>The results of “Efficient uniform grids for collision handling in medical simulators”, item by item; the same work by other "
            "libraries; growth with size and threads. Times are medians or least times of this machine; all ways measure the same "
            f"positions alternately.</p><p class=\"small\">{html.escape(facts(report))}</p>"
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
