#!/usr/bin/env python3
"""The Quake III bracket for maps whose .bsp is not at hand, only what was read from it: sampled within exact within baked.

usage: quake3_bracket_arrays.py ANTUMBRA FOLDER MAP [--cells N] [--seed N]
Reads FOLDER/MAP.glb (a node for each drawn surface), MAP.brushes.glb (the solid brushes) and MAP.pvs.npz (BSP tree, leaves,
surfaces of leaves, the compiler's set). Boxes inscribed in random leaves become cells of two bakes of the scene with its brushes;
what rays list must be listed exactly, and what is listed exactly must lie in some leaf that the compiler's set holds. Prints a
line of CSV as bench_quake3_bracket does; exceptions go to stderr, each with its distance from the cell: a map that was compiled
with a far plane has them beyond that distance, and only there.
"""
import argparse
import array
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
import zipfile

TYPES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q", "f4": "f", "f8": "d", "b1": "B"}


def read_arrays(path):
    """The arrays of a .npz file as (shape, flat list)."""
    arrays = {}
    with zipfile.ZipFile(path) as file:
        for name in file.namelist():
            data = file.read(name)
            assert data[:6] == b"\x93NUMPY", name
            wide = data[6] > 1
            length = struct.unpack_from("<I" if wide else "<H", data, 8)[0]
            begin = 12 if wide else 10
            head = eval(data[begin:begin + length], {"__builtins__": {}}, {"True": True, "False": False})
            assert not head["fortran_order"], name
            if head["descr"][1:] not in TYPES:
                continue  # text
            values = array.array(TYPES[head["descr"][1:]])
            values.frombytes(data[begin + length:])
            arrays[name[:-4]] = (head["shape"], values)
    return arrays


def read_glb(path):
    with open(path, "rb") as file:
        data = file.read()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + size])
    at = 20 + size
    binary = struct.unpack_from("<I", data, at)[0]
    return document, data[at + 8:at + 8 + binary]


def join(scene, brushes, path):
    """Writes the scene with the opaque brushes behind it; nodes of the scene keep their numbers. How many brushes there are."""
    (a, data_a), (b, data_b) = scene, brushes
    data_a += bytes(-len(data_a) % 4)
    views, accessors, meshes, materials, nodes = (len(a[k]) for k in ("bufferViews", "accessors", "meshes", "materials", "nodes"))
    for view in b["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + len(data_a)
    for accessor in b["accessors"]:
        accessor["bufferView"] += views
    for mesh in b["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"] = {k: v + accessors for k, v in primitive["attributes"].items()}
            primitive["indices"] += accessors
            primitive["material"] += materials
    opaque = [n for n in b["nodes"] if "mesh" in n and n["extras"]["contentFlags"] & 1 and not n["extras"]["translucent"]]
    for number, node in enumerate(opaque):
        assert "children" not in node
        node["mesh"] += meshes
        node["name"] = f"brush {number}"
    for key in ("bufferViews", "accessors", "meshes", "materials"):
        a[key] += b[key]
    a["nodes"] += opaque
    a["scenes"][0]["nodes"] += range(nodes, nodes + len(opaque))
    data = data_a + data_b
    data += bytes(-len(data) % 4)
    a["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(a).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON"))
        file.write(text + struct.pack("<I4s", len(data), b"BIN\0") + data)
    return len(opaque)


class Map:
    def __init__(self, arrays):
        self.arrays = {name: values for name, (_, values) in arrays.items()}
        self.row_bytes = arrays["pvs_bits"][0][1]
        self.clusters = len(self.arrays["pvs_bits"]) // self.row_bytes
        self.faces_of, offsets = {}, self.arrays["leaf_face_offset"]
        self.leaves_of_face = {}
        for leaf, cluster in enumerate(self.arrays["leaf_cluster"]):
            if cluster >= 0:
                for face in self.arrays["leaf_faces"][offsets[leaf]:offsets[leaf + 1]]:
                    self.leaves_of_face.setdefault(face, set()).add(cluster)
        self.face_of_node = {node: face for face, node in enumerate(self.arrays["face_node"]) if node >= 0}
        self.open_leaves = []
        self.collect(0, [])

    def collect(self, node, sides):
        """Leaves with a cluster, and the half-spaces that bound them (normal, distance: inside above)."""
        stack = [(node, sides)]
        a = self.arrays
        while stack:
            node, sides = stack.pop()
            if node < 0:
                leaf = -1 - node
                if a["leaf_cluster"][leaf] >= 0:
                    low, high = a["leaf_min"][3 * leaf:3 * leaf + 3], a["leaf_max"][3 * leaf:3 * leaf + 3]
                    box = [(tuple(s * (k == axis) for k in range(3)), s * (low, high)[s < 0][axis]) for axis in range(3) for s in (1, -1)]
                    self.open_leaves.append((leaf, sides + box))
                continue
            plane = a["node_plane"][node]
            normal, distance = tuple(a["plane_n"][3 * plane:3 * plane + 3]), a["plane_d"][plane]
            front, back = a["node_children"][2 * node:2 * node + 2]
            stack.append((back, sides + [(tuple(-x for x in normal), -distance)]))
            stack.append((front, sides + [(normal, distance)]))

    def inscribed(self, leaf, sides, chance):
        """The middle and half the edge of a cube within the leaf, a margin away from its sides, or None."""
        low, high = (self.arrays[k][3 * leaf:3 * leaf + 3] for k in ("leaf_min", "leaf_max"))
        best, margin = None, 2.0
        for _ in range(64):
            middle = [chance.uniform(low[k], high[k]) for k in range(3)]
            half = min((sum(n[k] * middle[k] for k in range(3)) - d) / sum(map(abs, n)) for n, d in sides) - margin
            if half > (best[1] if best else 1):
                best = (middle, half)
        return best

    def sees(self, a, b):
        bits = self.arrays["pvs_bits"]
        seen = lambda x, y: bits[x * self.row_bytes + y // 8] >> y % 8 & 1
        return a == b or seen(a, b) or seen(b, a)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("antumbra")
    parser.add_argument("folder")
    parser.add_argument("map")
    parser.add_argument("--cells", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    base = os.path.join(arguments.folder, arguments.map)
    scene, reference = read_glb(base + ".glb"), Map(read_arrays(base + ".pvs.npz"))
    chance, cells = random.Random(arguments.seed), []
    while len(cells) < arguments.cells:
        leaf, sides = chance.choice(reference.open_leaves)
        box = reference.inscribed(leaf, sides, chance)
        if box and all(other != leaf for other, _ in cells):
            cells.append((leaf, box))
    with tempfile.TemporaryDirectory() as folder:
        path = lambda name: os.path.join(folder, name)
        brushes = join(scene, read_glb(base + ".brushes.glb"), path("map.glb"))
        run = lambda *args: json.loads(subprocess.run([arguments.antumbra, *map(str, args), "--json"], check=True, capture_output=True).stdout)
        to_scene = lambda p: (p[0], p[2], -p[1])
        where = []
        for _, (middle, half) in cells:
            centre = to_scene(middle)
            where.append({"min": [x - half for x in centre], "max": [x + half for x in centre]})
        with open(path("where.json"), "w") as file:
            json.dump(where, file)
        common = ("--where", path("where.json"), "--subdivision", "boxes", "--rays-per-cell", 20000, "--holdout-rays", 1000)
        run("bake", path("map.glb"), "-o", path("sampled.pvs"), *common)
        exact = run("bake", path("map.glb"), "-o", path("exact.pvs"), *common, "--method", "exact")
        bounds = {}
        for number, node in enumerate(scene[0]["nodes"]):
            if "mesh" in node:
                accessor = scene[0]["accessors"][scene[0]["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"]]
                bounds[number] = (accessor["min"], accessor["max"])
        sums = dict.fromkeys(("solid", "sampled", "exact", "not_exact", "surfaces", "baked", "exceptions"), 0)
        solved = 0
        for leaf, (middle, half) in cells:
            eye = ",".join(repr(x) for x in to_scene(middle))
            answers = [run("query", path(name), "--eye", eye) for name in ("sampled.pvs", "exact.pvs")]
            if any(answer["everything"] for answer in answers):
                sums["solid"] += 1
                continue
            solved += 1
            seen = [{one["node"] for one in answer["visible"]} for answer in answers]
            sums["sampled"] += len(seen[0])
            sums["exact"] += len(seen[1])
            sums["not_exact"] += len(seen[0] - seen[1])
            own = reference.arrays["leaf_cluster"][leaf]
            held = {face for face, clusters in reference.leaves_of_face.items() if any(reference.sees(own, c) for c in clusters)}
            sums["baked"] += sum(reference.arrays["face_node"][face] >= 0 for face in held)
            for node in seen[1]:
                face = reference.face_of_node.get(node)
                if face is None or reference.arrays["face_model"][face] != 0 or face not in reference.leaves_of_face:
                    continue
                sums["surfaces"] += 1
                if face not in held:
                    sums["exceptions"] += 1
                    centre, (low, high) = to_scene(middle), bounds[node]
                    gap = [max(0, low[k] - centre[k] - half, centre[k] - half - high[k]) for k in range(3)]
                    print(f"{arguments.map} leaf {leaf} cluster {own} surface {face} distance {sum(g * g for g in gap) ** 0.5:.0f}",
                          file=sys.stderr)
        n = max(solved, 1)
        print("map,leaves,brushes,cells,solid,sampled_per_cell,exact_per_cell,sampled_not_exact,surfaces_exact,surfaces_baked,"
              "undecided,exceptions,unnamed")
        print(f"{arguments.map},{len(reference.open_leaves)},{brushes},{solved},{sums['solid']},{sums['sampled'] / n:.1f},"
              f"{sums['exact'] / n:.1f},{sums['not_exact']},{sums['surfaces'] / n:.1f},{sums['baked'] / n:.1f},"
              f"{exact['undecided']},{sums['exceptions']},{sums['exceptions']}")


if __name__ == "__main__":
    main()
