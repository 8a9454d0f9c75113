#!/usr/bin/env python3
"""Re-makes the figures of Gotsman, Sudarsky, Fayman 1999, section 8, on generated scenes of the same sizes.

usage: remake_gotsman.py ANTUMBRA [--machine]     prints a table in Markdown and the same as CSV on stderr

Every line carries its measured miss rate: a set that misses much is small for the wrong reason.
"""
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
    CASES.append(("machine", ["machine"], "spatial",
                  ["--max-depth", "6", "--view-space", "6", "--rays-per-cell", "8192", "--holdout-rays", "256"],
                  "scheme 1: 231 KB; 141 of 1,726 seen outside, 135 inside"))


def run_json(*arguments):
    out = subprocess.run([ANTUMBRA, *arguments, "--json"], check=True, capture_output=True, text=True).stdout
    return json.loads(out)


def main():
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
            if kind[0] == "machine":
                outside_and_inside(scene, pvs)


def outside_and_inside(scene, pvs):
    """Objects seen of the machine from a point outside of its housing and from its centre."""
    low, high = run_json("info", scene)["bounds"]
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    outside = [centre[0], centre[1], high[2] + 0.4 * (high[2] - low[2])]
    for where, eye in (("outside", outside), ("inside", centre)):
        seen = run_json("query", pvs, "--eye=" + ",".join(map(str, eye)))
        print(f"| machine, from {where} | | {seen['count']} | | | | | | | | | |")
    walk = run_json("walk", scene, "--pvs", pvs, "--path", "orbit", "--frames", "12", "--cull", "frustum,pvs")
    pvs_walk = [method for method in walk["methods"] if method["name"] == "pvs"][0]
    print(f"| machine, orbit | {pvs_walk['triangles_drawn']:.0f} triangles drawn | "
          f"{pvs_walk['objects_reported']:.1f} reported, {pvs_walk['objects_true']:.1f} seen | | | | | | "
          f"{pvs_walk['false_invisible_pixels']} pixels lost | | "
          f"{pvs_walk['speedup_over_frustum']:.2f} times frustum culling | |")


main()
