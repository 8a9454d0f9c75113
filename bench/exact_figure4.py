#!/usr/bin/env python3
"""Query time over effective occluders (Nirenstein, Blake, Gain 2002, figure 4), from what bench_exact_cells --queries wrote.

usage: exact_figure4.py QUERIES.csv OUT.csv [OUT.svg]

QUERIES.csv: scene, triangles, cell, effective occluders, queries, mean microseconds; no header. OUT.csv: per scene the mean time
of queries with about 5, 20 and 60 effective occluders (within a fifth), and the exponent fitted to all bins of at least five
queries, least squares on logarithms (published: 1.15).
"""
import csv
import math
import sys


def read(path):
    scenes = {}
    with open(path, newline="") as stream:
        for scene, triangles, cell, effective, queries, microseconds in csv.reader(stream):
            bins = scenes.setdefault((scene, triangles, cell), {})
            count, total = bins.get(int(effective), (0, 0.0))
            bins[int(effective)] = (count + int(queries), total + int(queries) * float(microseconds))
    return scenes


def exponent(bins):
    points = [(math.log(m), math.log(total / count)) for m, (count, total) in bins.items() if count >= 5 and m > 0]
    mean_x = sum(x for x, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / sum((x - mean_x) ** 2 for x, _ in points)


def near(bins, wanted):
    count = sum(c for m, (c, _) in bins.items() if abs(m - wanted) <= wanted / 5)
    total = sum(t for m, (_, t) in bins.items() if abs(m - wanted) <= wanted / 5)
    return count, (total / count if count else None)


def plot(scenes, path):
    width, height, left, bottom = 640, 420, 60, 40
    most, low, high = 500, 10, 100000
    x = lambda m: left + (width - left - 20) * math.log(m) / math.log(most)
    y = lambda us: height - bottom - (height - bottom - 20) * math.log(us / low) / math.log(high / low)
    colours = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd"]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for us in (10, 100, 1000, 10000, 100000):
        out.append(f'<path d="M{left} {y(us):.1f}H{width - 20}" stroke="#ddd"/><text x="4" y="{y(us) + 4:.1f}">{us:,} us</text>')
    for m in (1, 5, 20, 60, 200):
        out.append(f'<path d="M{x(m):.1f} 20V{height - bottom}" stroke="#ddd"/><text x="{x(m) - 6:.1f}" y="{height - 22}">{m}</text>')
    out.append(f'<text x="{width / 2 - 60}" y="{height - 6}">effective occluders</text>')
    for k, ((scene, triangles, cell), bins) in enumerate(sorted(scenes.items())):
        colour = colours[k % len(colours)]
        for m, (count, total) in bins.items():
            if m > 0 and total > 0:
                out.append(f'<circle cx="{x(m):.1f}" cy="{y(max(low, total / count)):.1f}" r="{1.5 if count < 5 else 2.5}" fill="{colour}"/>')
        out.append(f'<text x="{left + 12}" y="{34 + 16 * k}" fill="{colour}">{scene} {triangles}, {cell}: exponent '
                   f'{exponent(bins):.2f}</text>')
    out.append("</svg>")
    with open(path, "w") as stream:
        stream.write("\n".join(out) + "\n")


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    scenes = read(sys.argv[1])
    with open(sys.argv[2], "w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["scene", "triangles", "cell", "queries", "us_at_5", "queries_at_5", "us_at_20", "queries_at_20", "us_at_60",
                        "queries_at_60", "exponent", "published_exponent"])
        for key, bins in sorted(scenes.items()):
            row = [*key, sum(c for c, _ in bins.values())]
            for wanted in (5, 20, 60):
                count, mean = near(bins, wanted)
                row += [f"{mean:.0f}" if mean else "", count]
            table.writerow([*row, f"{exponent(bins):.2f}", "1.15"])
    if len(sys.argv) == 4:
        plot(scenes, sys.argv[3])


if __name__ == "__main__":
    main()
