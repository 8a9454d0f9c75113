#!/usr/bin/env python3
"""What clusters list: triangles per cell by objects, by clusters along the file's order, by compact clusters, triangle by triangle.

usage: exact_clusters.py ANTUMBRA SCENE [--share 0.05] [--triangles 64] [--height 0.4] [--seconds 120]
Three cubes of `share` of the scene's longest side, at `height` of its height, are baked exactly, four times. Prints CSV.
"""
import argparse
import json
import os
import subprocess
import tempfile


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("antumbra")
    parser.add_argument("scene")
    parser.add_argument("--share", type=float, default=0.05)
    parser.add_argument("--triangles", type=int, default=64)
    parser.add_argument("--height", type=float, default=0.4)
    parser.add_argument("--seconds", type=float, default=120)
    arguments = parser.parse_args()

    def run(*options):
        done = subprocess.run([arguments.antumbra, *map(str, options), "--json"], capture_output=True, text=True, check=True,
                              timeout=arguments.seconds)
        return json.loads(done.stdout)

    low, high = run("info", arguments.scene)["bounds"]
    size = [b - a for a, b in zip(low, high)]
    half = max(size) * arguments.share / 2
    boxes = []
    for x, z in ((0.3, 0.35), (0.5, 0.5), (0.7, 0.62)):
        centre = [low[k] + share * size[k] for k, share in enumerate((x, arguments.height, z))]
        boxes.append({"min": [c - half for c in centre], "max": [c + half for c in centre]})
    print("scene,listed,units,cells,units_per_cell,triangles_per_cell,undecided,cpu_seconds,bytes")
    with tempfile.TemporaryDirectory() as folder:
        where, pvs = os.path.join(folder, "where.json"), os.path.join(folder, "baked.pvs")
        with open(where, "w") as file:
            json.dump(boxes, file)
        cluster = ("--granularity", "cluster", "--cluster-triangles", arguments.triangles, "--cluster-order")
        for name, options in (("objects", ()), ("file", (*cluster, "file")), ("compact", (*cluster, "compact")),
                              ("triangles", ("--granularity", "triangle"))):
            try:
                baked = run("bake", arguments.scene, "-o", pvs, "--method", "exact", "--subdivision", "boxes", "--where", where,
                            "--rays-per-cell", 30000, *options)
            except subprocess.TimeoutExpired:
                print(f"{os.path.basename(arguments.scene)},{name},,,,,,,", flush=True)
                continue
            listed = run("compare", arguments.scene, pvs, pvs, "--samples", 0)
            print(f"{os.path.basename(arguments.scene)},{name},{listed['unit_count']},{baked['cells_baked']},"
                  f"{listed['a']['mean_objects']:.1f},{listed['a']['mean_triangles']:.1f},{baked['undecided']},"
                  f"{baked['cpu_seconds']:.1f},{baked['bytes']}", flush=True)


if __name__ == "__main__":
    main()
