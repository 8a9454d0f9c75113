#!/usr/bin/env python3
"""Exact bakes of a folder of scenes, with small grids: do they finish, and is nothing undecided?

usage: exact_scenes.py ANTUMBRA FOLDER OUT.csv [--cells 2x1x2] [--rays N] [--seconds LIMIT] [--only PART] [--threads N]

A row per scene: cells, objects, visible objects per cell, undecided triangles, hold-out rays that saw something unlisted
(must be 0), queries, CPU seconds. A scene that cannot be read, or takes longer than the limit, says so in `note`.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile

KINDS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".bsp")
COLUMNS = ["scene", "cells", "solid", "objects", "mean_visible", "guarantee", "undecided", "holdout_misses", "holdout_rays",
           "boxes", "triangles", "pairs", "found_by_query", "most_effective", "cpu_seconds", "note"]


def scenes_below(folder):
    for path, _, names in sorted(os.walk(folder)):
        for name in sorted(names):
            if name.lower().endswith(KINDS):
                yield os.path.join(path, name)


def bake(arguments, scene, out):
    command = [arguments.antumbra, "bake", scene, "-o", out, "--method", "exact", "--cells", arguments.cells, "--rays-per-cell",
               str(arguments.rays), "--holdout-rays", "4000", "--threads", str(arguments.threads), "--json"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=arguments.seconds)
    except subprocess.TimeoutExpired:
        return {"note": f"not finished in {arguments.seconds} s"}
    if done.returncode != 0:
        return {"note": (done.stderr.strip().splitlines() or ["failed"])[-1]}
    result = json.loads(done.stdout)
    exact = result["exact"]
    return {"cells": result["cells_baked"], "solid": result["cells_solid"], "objects": result["objects"],
            "mean_visible": round(result["mean_visible"], 1), "guarantee": result["guarantee"],
            "undecided": result["undecided"], "holdout_misses": result["holdout_misses"],
            "holdout_rays": result["holdout_rays"], "boxes": exact["box_queries"], "triangles": exact["triangle_queries"],
            "pairs": exact["pairs"], "found_by_query": exact["found_by_query"], "most_effective": exact["most_effective"],
            "cpu_seconds": round(result["cpu_seconds"], 2), "note": ""}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("antumbra")
    parser.add_argument("folder")
    parser.add_argument("out")
    parser.add_argument("--cells", default="2x1x2")
    parser.add_argument("--rays", type=int, default=4000)
    parser.add_argument("--seconds", type=int, default=300)
    parser.add_argument("--only", default="")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    bad = 0
    with open(arguments.out, "w", newline="") as stream, tempfile.TemporaryDirectory() as folder:
        table = csv.DictWriter(stream, COLUMNS)
        table.writeheader()
        for scene in scenes_below(arguments.folder):
            if arguments.only not in scene:
                continue
            row = bake(arguments, scene, os.path.join(folder, "out.pvs"))
            row["scene"] = os.path.relpath(scene, arguments.folder)
            bad += row.get("undecided", 0) + row.get("holdout_misses", 0)
            table.writerow(row)
            stream.flush()
            print(row["scene"], row.get("cpu_seconds", "-"), row.get("undecided", row["note"]), file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
