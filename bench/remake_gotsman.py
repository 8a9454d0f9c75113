#!/usr/bin/env python3
"""Re-makes the figures of Gotsman, Sudarsky, Fayman 1999, section 8, on generated scenes of the same sizes.

usage: remake_gotsman.py ANTUMBRA [--machine] [--out FOLDER]
Prints a table in Markdown and the same as CSV on stderr; with --out also FOLDER/index.html and, for each case, a page of its
cells from above: how much each sees, the worst cells, the costliest objects.

Every line carries its measured miss rate: a set that misses much is small for the wrong reason.
"""
import html
import json
import os
import subprocess
import sys
import tempfile

ANTUMBRA = sys.argv[1]
SPLIT = ["--max-depth", "8", "--rays-per-cell", "2048", "--holdout-rays", "256", "--effectiveness", "0.1"]
CODINGS = ["tree-leaves", "tree-parent", "tree-sibling"]
CASES = [
    # name, generator arguments, subdivision, further options, what the paper says
    ("apartment, eight headings", ["apartment"], "angular", SPLIT, "1,504 leaves, 26 of 159, scheme 2: 16 KB"),
    ("apartment, positions only", ["apartment"], "spatial", SPLIT, "188 leaves, 47 of 159, scheme 2: 3.2 KB"),
    ("apartment, at least 500 polygons", ["apartment"], "spatial", SPLIT + ["--min-visible", "500"],
     "schemes 1 and 2: 3,263 and 2,981 bytes"),
    ("eighteen apartments, at least 500 polygons", ["apartment", "--copies", "18"], "spatial",
     ["--max-depth", "10", "--min-visible", "500"] + SPLIT[2:], "schemes 1 and 2: 73,053 and 24,618 bytes"),
]
if "--machine" in sys.argv:
    CASES.append(("machine, eight headings", ["machine"], "angular",
                  ["--max-depth", "5", "--view-space", "4", "--node-rays", "16384", "--effectiveness", "0.03",
                   "--rays-per-cell", "16384", "--sampling", "guided", "--holdout-rays", "256"],
                  "scheme 1: 231 KB; 141 of 1,726 in a view from outside, 135 from inside"))


def run_json(*arguments):
    out = subprocess.run([ANTUMBRA, *arguments, "--json"], check=True, capture_output=True, text=True).stdout
    return json.loads(out)


def write_page(folder, head, rows):
    """The table as a page that links each case to the map of its cells."""
    def line(cells, tag):
        return "<tr>" + "".join(f"<{tag}>{cell}</{tag}>" for cell in cells) + "</tr>"

    body = [line(map(html.escape, head), "th")]
    for number, row in enumerate(rows):
        cells = [html.escape(str(cell)) for cell in row]
        cells[0] = f'<a href="cells-{number}.html">{cells[0]}</a>' if len(row) == len(head) else cells[0]
        body.append(line(cells, "td"))
    page = ("<!doctype html><html lang=en><meta charset=utf-8><title>Five-dimensional subdivision</title><style>"
            ":root{color-scheme:light dark}body{font:16px/1.5 system-ui;margin:2rem auto;max-width:80rem;padding:0 1rem}"
            "table{border-collapse:collapse;display:block;overflow-x:auto}td,th{padding:.4rem .7rem;text-align:right;"
            "border-bottom:1px solid #8886}td:first-child,th:first-child,td:last-child{text-align:left}</style>"
            "<h1>Five-dimensional subdivision, made again</h1><p>Gotsman, Sudarsky, Fayman 1999, section 8, on generated "
            "scenes of the same sizes. All sets are aggressive: the miss rate is the share of fresh random rays that first "
            "hit an unlisted object. A name leads to the map of its cells.</p><table>" + "".join(body) + "</table></html>")
    with open(os.path.join(folder, "index.html"), "w", encoding="utf-8") as file:
        file.write(page)


def main():
    out = sys.argv[sys.argv.index("--out") + 1] if "--out" in sys.argv else None
    if out:
        os.makedirs(out, exist_ok=True)
    rows = []
    head = ["case", "leaves", "mean visible", "objects", "scheme 1 bytes", "scheme 2 bytes", "scheme 3 bytes",
            "2 over 1", "miss rate", "at most (95%)", "CPU s", "paper"]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    print(",".join(head), file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        for name, kind, subdivision, options, paper in CASES:
            scene, pvs = os.path.join(folder, "scene.glb"), os.path.join(folder, "out.pvs")
            run_json("generate", *kind, "-o", scene)
            sizes = []
            for coding in CODINGS:
                baked = run_json("bake", scene, "-o", pvs, "--subdivision", subdivision, "--coding", coding, *options)
                sizes.append(baked["visibility_bytes"])
            row = [name, baked["cells"], f"{baked['mean_visible']:.1f}", baked["objects"], *sizes,
                   f"{sizes[1] / sizes[0]:.3f}", f"{baked['miss_rate']:.2g}", f"{baked['miss_rate_upper95']:.2g}",
                   f"{baked['cpu_seconds']:.2f}", paper]
            print("| " + " | ".join(map(str, row)) + " |", flush=True)
            print(",".join('"%s"' % cell for cell in row), file=sys.stderr, flush=True)
            if out:
                run_json("inspect", pvs, "--report", os.path.join(out, f"cells-{len(rows)}.html"))
            rows.append(row)
            if kind[0] == "machine":
                rows += outside_and_inside(scene, pvs)
    if out:
        write_page(out, head, rows)


def outside_and_inside(scene, pvs):
    """Objects listed for a view of the machine from outside of its housing and for one from its centre."""
    low, high = run_json("info", scene)["bounds"]
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    outside = [centre[0], centre[1], high[2] + 0.4 * (high[2] - low[2])]
    rows = []
    for where, eye in (("outside", outside), ("inside", centre)):
        seen = run_json("query", pvs, "--eye=" + ",".join(map(str, eye)), "--dir=0,0,-1", "--fov", "60", "--aspect", "1")
        rows.append([f"machine, a view from {where}", "", f"{seen['count']} listed"])
    walk = run_json("walk", scene, "--pvs", pvs, "--path", "orbit", "--frames", "12", "--cull", "frustum,pvs")
    method = [method for method in walk["methods"] if method["name"] == "pvs"][0]
    rows.append(["machine, orbit", f"{method['triangles_drawn']:.0f} triangles drawn",
                 f"{method['objects_reported']:.1f} reported, {method['objects_true']:.1f} seen",
                 f"{method['false_invisible_pixels']} pixels lost",
                 f"{method['speedup_over_frustum']:.2f} times as fast as frustum culling"])
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)
    return rows


main()
