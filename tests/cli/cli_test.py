#!/usr/bin/env python3
"""The command line as a script meets it: exit codes, messages, JSON keys, files; then every real scene, if there.

usage: cli_test.py ANTUMBRA SOURCE_DIR [TEST..]
"""
import http.client
import json
import math
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

ANTUMBRA = sys.argv[1]
SOURCE = pathlib.Path(sys.argv[2])
SCENES = pathlib.Path(os.environ.get("ANTUMBRA_SCENES", SOURCE.parent / "shared" / "scenes"))


def run(*arguments, code=0):
    """Runs a command; returns (stdout, stderr). Fails unless it exits with `code`."""
    done = subprocess.run([ANTUMBRA, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    if done.returncode != code:
        raise AssertionError(f"{arguments}: exit {done.returncode}, not {code}\n{done.stdout}\n{done.stderr}")
    return done.stdout, done.stderr


def run_json(*arguments):
    return json.loads(run(*arguments, "--json")[0])


def two_turned_walls(steps):
    """A GLB of two walls that meet along a ragged seam, each a node with a rotation of its own, so that a vertex of the seam is
    rounded to floats in two systems of coordinates."""
    seam = [(2.1 + 0.1 * math.sin(k), 0.037 * k, 3.3 + 0.1 * math.cos(3 * k)) for k in range(steps + 1)]
    nodes, chunks, accessors, views = [], [], [], []

    def put(data, target, **accessor):
        views.append({"buffer": 0, "byteOffset": sum(map(len, chunks)), "byteLength": len(data), "target": target})
        accessors.append({"bufferView": len(views) - 1, **accessor})
        chunks.append(data)
        return len(accessors) - 1

    for side, angle in ((-3, 0.3), (4, -1.1)):
        cos, sin = math.cos(angle), math.sin(angle)
        local = lambda p: (cos * p[0] - sin * p[2], p[1], sin * p[0] + cos * p[2]) # turned back
        points = [local(p) for p in seam] + [local((side, p[1], p[2])) for p in seam]
        floats = [struct.unpack("<3f", struct.pack("<3f", *p)) for p in points]
        faces = [t for k in range(steps) for t in ((k, k + 1, steps + 1 + k), (k + 1, steps + 2 + k, steps + 1 + k))]
        bounds = {"min": [min(p[k] for p in floats) for k in range(3)], "max": [max(p[k] for p in floats) for k in range(3)]}
        position = put(b"".join(struct.pack("<3f", *p) for p in floats), 34962, componentType=5126, count=len(floats), type="VEC3", **bounds)
        index = put(b"".join(struct.pack("<3H", *t) for t in faces), 34963, componentType=5123, count=3 * len(faces), type="SCALAR")
        nodes.append(({"attributes": {"POSITION": position}, "indices": index}, [0, math.sin(angle / 2), 0, math.cos(angle / 2)]))
    data = b"".join(chunks)
    document = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": k, "rotation": turn, "name": f"wall {k}"} for k, (_, turn) in enumerate(nodes)],
        "meshes": [{"primitives": [primitive]} for primitive, _ in nodes],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data)}]}).encode()
    document += b" " * (-len(document) % 4)
    data += bytes(-len(data) % 4)
    return (struct.pack("<4sIII4s", b"glTF", 2, 28 + len(document) + len(data), len(document), b"JSON") + document +
            struct.pack("<I4s", len(data), b"BIN\0") + data)


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.scene = os.path.join(cls.folder.name, "apartment.glb")
        cls.pvs = os.path.join(cls.folder.name, "apartment.pvs")
        run("generate", "apartment", "-o", cls.scene)
        cls.baked = run_json("bake", cls.scene, "-o", cls.pvs, "--cells", "6x1x4", "--rays-per-cell", 4096)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def assert_one_line_error(self, code, *arguments, saying=()):
        out, err = run(*arguments, code=code)
        lines = [line for line in err.splitlines() if line.startswith("antumbra:")]
        self.assertEqual(len(lines), 1, err)
        self.assertEqual(out, "")
        for text in saying:
            self.assertIn(text, lines[0])

    def test_every_command_has_help_with_an_example(self):
        for command in ("info", "generate", "bake", "query", "verify", "walk", "inspect", "cull", "explain", "prove",
                        "compare", "occluders", "prepare",
                        "merge", "split"):
            self.assertIn("Example:", run(command, "--help")[0], command)

    def test_prepare_stores_what_cull_and_walk_use(self):
        alone, both = (os.path.join(self.folder.name, name) for name in ("alone.pvs", "both.pvs"))
        made = run_json("prepare", self.scene, "-o", alone, "--first-hit-leaves", 4)
        self.assertEqual([chunk["name"] for chunk in made["chunks"]][:4], ["OCCL", "OGRP", "CTRE", "OSET"])
        run("prepare", self.scene, "--pvs", self.pvs, "-o", both, "--first-hit-leaves", 4)
        names = [chunk["name"] for chunk in run_json("inspect", both)["chunks"]]
        self.assertEqual(names[-4:], ["OCCL", "OGRP", "CTRE", "OSET"])
        self.assertEqual(run_json("inspect", alone)["cells"], 0)
        view = ("--method", "planes", "--eye", "3,1.5,2", "--dir", "1,0,0.2")
        found = run_json("cull", self.scene, *view)
        self.assertEqual(run_json("cull", self.scene, *view, "--pvs", alone), found)
        seeing = run_json("cull", self.scene, *view, "--pvs", both)  # takes its candidates from what the cell sees
        self.assertEqual(seeing["visible"], found["visible"])
        self.assertNotEqual(seeing["counters"]["occluders_used"], found["counters"]["occluders_used"])
        walked = run_json("walk", self.scene, "--pvs", both, "--cull", "frustum,planes,pvs", "--frames", 5, "--no-draw")
        self.assertEqual([method["false_invisible_pixels"] for method in walked["methods"]][1], 0)
        mos = os.path.join(self.folder.name, "mos.pvs")
        made = run_json("prepare", self.scene, "-o", mos, "--mos", "--mos-grid", "2x1x2")
        self.assertEqual(made["chunks"][-1]["name"], "MOSD")
        self.assertFalse(os.path.exists(mos + ".mos-checkpoint"))
        walked = run_json("walk", self.scene, "--pvs", mos, "--cull", "frustum,opacity,opacity-published", "--frames", 5, "--no-draw")
        self.assertEqual([method["false_invisible_pixels"] for method in walked["methods"]], [0, 0, 0])
        self.assert_one_line_error(2, "prepare", self.scene, "-o", mos, "--mos", "--mos-grid", "2", saying=("--mos-grid",))
        other = os.path.join(self.folder.name, "other.glb")
        run("generate", "office", "-o", other)
        self.assert_one_line_error(1, "prepare", other, "--pvs", self.pvs, "-o", alone, saying=("another scene",))
        self.assert_one_line_error(2, "prepare", self.scene, saying=("--output",))

    def test_wrong_usage_exits_2(self):
        self.assert_one_line_error(2)
        self.assert_one_line_error(2, "frobnicate")
        self.assert_one_line_error(2, "bake", self.scene)
        self.assert_one_line_error(2, "bake", self.scene, "-o", "x.pvs", "--cells", "3x3", saying=["--cells"])
        self.assert_one_line_error(2, "query", self.pvs, "--eye", "1,2", saying=["--eye"])
        self.assert_one_line_error(2, "generate", "castle", "-o", "x.glb", saying=["apartment"])

    def test_a_number_out_of_range_is_a_short_line(self):
        for value in ("-1", "nan", "1e300"):
            done = subprocess.run([ANTUMBRA, "info", self.scene, f"--crack-width={value}"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, value)
            self.assertLess(len(done.stderr), 200)

    def test_bad_files_exit_1_and_name_the_file(self):
        self.assert_one_line_error(1, "info", "/no/such.glb", saying=["/no/such.glb"])
        bad = os.path.join(self.folder.name, "bad.glb")
        data = pathlib.Path(self.scene).read_bytes()
        pathlib.Path(bad).write_bytes(data[: len(data) // 2])
        self.assert_one_line_error(1, "info", bad, saying=["bad.glb"])
        damaged = os.path.join(self.folder.name, "damaged.pvs")
        data = bytearray(pathlib.Path(self.pvs).read_bytes())
        data[len(data) // 2] ^= 4
        pathlib.Path(damaged).write_bytes(data)
        self.assert_one_line_error(1, "query", damaged, "--eye", "1,1,1", saying=["damaged.pvs"])

    def test_explain_says_why(self):
        picture = os.path.join(self.folder.name, "why.glb")
        arguments = ("explain", self.scene, self.pvs, "--eye", "2,1.5,2", "--object")
        seen = run_json(*arguments, "floor")
        self.assertEqual((seen["object"]["id"], seen["from_eye"]["answer"], seen["pvs"]["listed"]), (0, "visible", True))
        self.assertEqual(seen["from_eye"]["witness"]["from"], [2, 1.5, 2])
        hidden = run_json(*arguments, "study/bookshelf/row 1/book 1", "--glb", picture)
        self.assertEqual((hidden["from_eye"]["answer"], hidden["pvs"]["listed"]), ("hidden", False))
        self.assertTrue(hidden["from_cell"]["certificate"]["verified"])
        self.assertIn("wall/inner", [hider["name"] for hider in hidden["from_eye"]["hiders"]])
        self.assertEqual(hidden["words"], run(*arguments, "150")[0].rstrip("\n"))
        self.assertGreater(run_json("info", picture)["triangles"], 10)
        self.assert_one_line_error(2, *arguments, "nobody", saying=["nobody"])
        self.assert_one_line_error(2, "explain", self.scene, self.pvs, "--eye", "2,1", "--object", "0", saying=["--eye"])

    def test_compare_finds_what_a_sampler_missed(self):
        exact, other = (os.path.join(self.folder.name, name) for name in ("exact.pvs", "other.pvs"))
        run("bake", self.scene, "-o", exact, "--cells", "6x1x4", "--rays-per-cell", 4096, "--method", "exact")
        run("bake", self.scene, "-o", other, "--cells", "3x1x2", "--rays-per-cell", 4096, "--method", "exact")
        same = run_json("compare", self.scene, self.pvs, exact)
        self.assertTrue(same["same_cells"])
        self.assertEqual((same["a"]["pairs_only"], same["contradictions"]), (0, 0))
        self.assertGreater(same["b"]["pairs_only"], 0)
        coarse = run_json("compare", self.scene, exact, other)
        self.assertFalse(coarse["same_cells"])
        self.assertGreaterEqual(coarse["pieces"], 24) # the counts are nested, the edges are whole grid steps
        self.assertGreater(coarse["pieces_bound"], 0)
        self.assertEqual(coarse["contradictions"], 0)
        self.assertGreater(coarse["b"]["mean_only"], 10 * coarse["a"]["mean_only"])
        self.assert_one_line_error(1, "compare", self.scene, exact, exact + ".missing", saying=["exact.pvs.missing"])

    def test_compare_knows_clusters_of_every_size(self):
        folder = self.folder.name
        cells = ("--cells", "3x1x2", "--rays-per-cell", 2048)
        files = {name: os.path.join(folder, name + ".pvs") for name in ("sampled", "objects", "compact", "file", "triangles")}
        run("bake", self.scene, "-o", files["sampled"], *cells)
        exact = ("--method", "exact", *cells)
        run("bake", self.scene, "-o", files["objects"], *exact)
        small = ("--granularity", "cluster", "--cluster-triangles", 4)
        run("bake", self.scene, "-o", files["compact"], *exact, *small)
        run("bake", self.scene, "-o", files["file"], *exact, *small, "--cluster-order", "file")
        run("bake", self.scene, "-o", files["triangles"], *exact, "--granularity", "triangle")

        def compare(a, b):
            result = run_json("compare", self.scene, files[a], files[b], "--samples", 8)
            self.assertEqual(result["contradictions"], 0)
            self.assertEqual(result["pixels_neither"], 0)
            return result

        same = compare("compact", "compact")
        self.assertEqual((same["units"], same["unit_count"]), ("clusters", same["a"]["clusters"]))
        self.assertEqual((same["a"]["pairs_only"], same["b"]["pairs_only"]), (0, 0))
        fine = compare("compact", "triangles") # both exact: the same, seen as coarsely as the coarser one
        self.assertEqual((fine["units"], fine["unit_count"]), ("groups", fine["a"]["clusters"]))
        self.assertEqual((fine["a"]["pairs_only"], fine["b"]["pairs_only"]), (0, 0))
        self.assertLess(fine["b"]["mean_triangles"], fine["a"]["mean_triangles"])
        self.assertIn("compared as", fine["words"][0])
        across = compare("compact", "file")
        self.assertEqual((across["a"]["pairs_only"], across["b"]["pairs_only"]), (0, 0))
        self.assertLess(across["unit_count"], across["b"]["clusters"])
        missed = compare("sampled", "triangles")
        self.assertEqual((missed["units"], missed["a"]["pairs_only"]), ("objects", 0))
        self.assertGreater(missed["b"]["pairs_only"], 0)
        self.assertIn("missed", missed["words"][-1])
        self.assertLess(missed["b"]["mean_triangles"], compare("objects", "triangles")["a"]["mean_triangles"])
        # Each file answers for the eye, too.
        answer = run_json("query", files["compact"], "--eye", "2,1.5,2")
        self.assertEqual(answer["cluster_count"], same["a"]["clusters"])
        self.assertTrue(0 < len(answer["clusters"]) < answer["cluster_count"])
        told = run_json("explain", self.scene, files["compact"], "--eye", "2,1.5,2", "--object", "floor")
        self.assertLessEqual(told["pvs"]["clusters_listed"], told["pvs"]["clusters"])

    def test_compare_across_crack_widths_speaks_of_objects(self):
        plain, closed = (os.path.join(self.folder.name, name) for name in ("open.pvs", "closed.pvs"))
        cells = ("--method", "exact", "--cells", "2x1x2", "--rays-per-cell", 512)
        run("bake", self.scene, "-o", plain, *cells)
        run("bake", self.scene, "-o", closed, *cells, "--crack-width", 0.01, "--granularity", "triangle")
        result = run_json("compare", self.scene, plain, closed, "--samples", 4)
        self.assertEqual((result["units"], result["contradictions"]), ("objects", 0))
        self.assertIn("cracks closed up to 0.01", result["words"][0])
        other = run_json("compare", self.scene, plain, closed, "--samples", 4, "--crack-width", 0.01)
        self.assertEqual(other["b"]["pairs"], result["b"]["pairs"])
        self.assert_one_line_error(1, "compare", self.scene, closed, closed, saying=["--crack-width"])

    def test_cracks_between_turned_nodes_are_counted_and_closed(self):
        path = os.path.join(self.folder.name, "turned.glb")
        pathlib.Path(path).write_bytes(two_turned_walls(200))
        found = {one["kind"]: one["count"] for one in run_json("info", path)["findings"]}
        opened = found.get("crack opened by snapping", 0)
        self.assertTrue(5 < opened < 200, opened)
        bounds = run_json("info", path)["bounds"]
        size = max(high - low for low, high in zip(*bounds))
        baked = os.path.join(self.folder.name, "turned.pvs")
        cells = ("--method", "exact", "--cells", "1x1x1", "--rays-per-cell", 64)
        self.assertEqual(run_json("bake", path, "-o", baked, *cells)["cracks_opened_by_snapping"], opened)
        self.assertEqual(run_json("inspect", baked)["options"]["cracks_opened_by_snapping"], opened)
        closed = run_json("info", path, "--crack-width", size * 2**-20) # some steps of the grid
        found = {one["kind"]: one["count"] for one in closed["findings"]}
        self.assertGreaterEqual(found["corner moved to close a crack"], opened / 2)

    def test_shards_merge_to_the_same_bytes(self):
        options = ("--cells", "6x1x4", "--rays-per-cell", 4096)
        parts = [os.path.join(self.folder.name, f"part{k}.pvs") for k in (1, 2)]
        for k, part in enumerate(parts):
            run("bake", self.scene, "-o", part, "--shard", f"{k + 1}/2", *options)
        whole = os.path.join(self.folder.name, "merged.pvs")
        self.assertEqual(run_json("merge", *reversed(parts), "-o", whole)["parts"], 2)
        self.assertEqual(pathlib.Path(whole).read_bytes(), pathlib.Path(self.pvs).read_bytes())
        self.assert_one_line_error(1, "merge", parts[1], "-o", whole, saying=["missing: 1"])
        self.assert_one_line_error(1, "merge", *parts, self.pvs, "-o", whole, saying=[self.pvs])
        self.assert_one_line_error(2, "bake", self.scene, "-o", whole, "--shard", "3/2", saying=["--shard"])

    def test_split_keeps_every_triangle(self):
        split = os.path.join(self.folder.name, "split.glb")
        made = run_json("split", self.scene, "-o", split, "--most-triangles", 20)
        before, after = run_json("info", self.scene), run_json("info", split)
        self.assertEqual((after["triangles"], after["bounds"]), (before["triangles"], before["bounds"]))
        self.assertEqual(after["objects"], made["objects"])
        self.assertGreater(after["objects"], before["objects"])

    def test_stored_certificates_are_checked(self):
        exact = os.path.join(self.folder.name, "proved.pvs")
        run("bake", self.scene, "-o", exact, "--cells", "2x1x1", "--rays-per-cell", 4096, "--method", "exact", "--certificates")
        checked = run_json("verify", self.scene, exact, "--certificates")
        self.assertEqual((checked["pairs"], checked["rejected"], checked["disagree"]), (2 * 159, 0, 0))
        self.assertGreater(checked["proved_hidden"], 10)
        self.assert_one_line_error(1, "verify", self.scene, self.pvs, "--certificates", "--proof", exact + ".proof",
                                   saying=["belongs to another"])
        self.assert_one_line_error(2, "bake", self.scene, "-o", exact, "--certificates", saying=["--method exact"])

    def test_info_keys(self):
        info = run_json("info", self.scene)
        self.assertEqual(info["objects"], 159)
        self.assertEqual(len(info["bounds"]), 2)
        self.assertTrue({"triangles", "vertices", "findings"} <= info.keys())
        for finding in info["findings"]:
            self.assertTrue({"kind", "count", "example"} <= finding.keys())

    def test_bake_keys(self):
        keys = {"method", "guarantee", "granularity", "cells", "objects", "seconds", "cpu_seconds", "rays", "bytes",
                "bits_per_pair", "mean_visible", "undecided", "miss_rate", "miss_rate_upper95", "pair_miss_at_s1"}
        self.assertTrue(keys <= self.baked.keys(), keys - self.baked.keys())
        self.assertEqual(self.baked["guarantee"], "aggressive")
        self.assertEqual(self.baked["cells"], 24)
        self.assertEqual(self.baked["bytes"], os.path.getsize(self.pvs))
        self.assertGreaterEqual(self.baked["miss_rate_upper95"], self.baked["miss_rate"])
        self.assertFalse(os.path.exists(self.pvs + ".part"))

    def test_same_bytes_whatever_the_threads(self):
        files = []
        for threads in (1, 2, 5):
            path = os.path.join(self.folder.name, f"threads{threads}.pvs")
            run("bake", self.scene, "-o", path, "--cells", "3x1x2", "--rays-per-cell", 1024, "--threads", threads)
            files.append(pathlib.Path(path).read_bytes())
        self.assertEqual(files[0], files[1])
        self.assertEqual(files[0], files[2])

    def test_an_interrupted_bake_keeps_its_cells_and_resumes_to_the_same_bytes(self):
        path = os.path.join(self.folder.name, "interrupted.pvs")
        options = ["bake", self.scene, "-o", path, "--cells", "16x4x16", "--rays-per-cell", "8192"]
        run(*options)
        expected = pathlib.Path(path).read_bytes()
        os.remove(path)
        bake = subprocess.Popen([ANTUMBRA, *options], stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and bake.poll() is None:
            if os.path.exists(path + ".part") and os.path.getsize(path + ".part") > 2000:
                bake.send_signal(signal.SIGINT)
                break
            time.sleep(0.005)
        err = bake.communicate(timeout=60)[1]
        self.assertEqual(bake.returncode, 1, err)
        self.assertIn("--resume", err)
        self.assertFalse(os.path.exists(path))
        self.assertGreater(run_json(*options, "--resume")["cells_resumed"], 0)
        self.assertEqual(pathlib.Path(path).read_bytes(), expected)

    def test_error_rates_give_walds_thresholds(self):
        path = os.path.join(self.folder.name, "rates.pvs")
        run("bake", self.scene, "-o", path, "--cells", "1x1x1", "--rays-per-cell", 64, "--alpha", 0.01, "--beta", 0.05)
        test = run_json("inspect", path)["options"]["sequential"]
        self.assertAlmostEqual(test["a"], 95)
        self.assertAlmostEqual(test["b"], 0.05 / 0.99)

    def test_dry_run_writes_nothing(self):
        path = os.path.join(self.folder.name, "dry.pvs")
        plan = run_json("bake", self.scene, "-o", path, "--cells", "6x1x4", "--dry-run")
        self.assertEqual(plan["cells_to_bake"], 24)
        self.assertFalse(os.path.exists(path))
        where = os.path.join(self.folder.name, "dry.json")
        pathlib.Path(where).write_text('[{"min":[1,1,1],"max":[2,2,2]},{"min":[4,1,2],"max":[5,2,3]}]')
        boxes = run_json("bake", self.scene, "-o", path, "--subdivision", "boxes", "--where", where, "--dry-run")
        self.assertEqual((boxes["cells_to_bake"], boxes["cells_estimated"]), (2, False))
        tree = ("--subdivision", "spatial", "--method", "exact", "--rays-per-cell", 256, "--min-extent", 0.25)
        grown = run_json("bake", self.scene, "-o", path, *tree, "--dry-run")
        self.assertTrue(grown["cells_estimated"])
        self.assertFalse(os.path.exists(path))
        leaves = run_json("bake", self.scene, "-o", path, *tree)["cells"]
        self.assertTrue(leaves / 4 <= grown["cells_to_bake"] <= 4 * leaves, (leaves, grown["cells_to_bake"]))

    def test_where_limits_the_cells(self):
        boxes = os.path.join(self.folder.name, "boxes.json")
        pathlib.Path(boxes).write_text('[{"min":[1,1,1],"max":[2,2,2]}]')
        path = os.path.join(self.folder.name, "where.pvs")
        baked = run_json("bake", self.scene, "-o", path, "--where", boxes, "--cell-size", 0.5, "--rays-per-cell", 256)
        self.assertEqual(baked["cells"], 8)
        self.assertIsNone(run_json("query", path, "--eye", "5,1,3")["cell"])

    def test_query_inside_and_outside(self):
        inside = run_json("query", self.pvs, "--eye", "2,1.5,2")
        self.assertIsNotNone(inside["cell"])
        self.assertEqual(inside["guarantee"], "aggressive")
        self.assertEqual(inside["count"], len(inside["visible"]))
        self.assertTrue({"id", "node", "primitive", "instance", "name"} <= inside["visible"][0].keys())
        out, err = run("query", self.pvs, "--eye", "100,0,0", "--json")
        outside = json.loads(out)
        self.assertIsNone(outside["cell"])
        self.assertEqual(outside["count"], 159)
        self.assertIn("note", err)

    def test_a_query_says_what_its_answer_is(self):
        def answer(*more):
            return run_json("query", self.pvs, "--eye", "2,1.5,2", *more)["guarantee"]

        self.assertEqual(answer(), "aggressive")
        self.assertEqual(answer("--dir", "1,0,0"), "approximate")  # also lists what is seen, but not in that frustum
        self.assertEqual(answer("--radius", "0.8"), "approximate")  # and from cells that the viewpoints only touch
        self.assertEqual(run_json("query", self.pvs, "--eye", "100,0,0")["guarantee"], "conservative")

    def test_a_file_cut_short_while_it_is_used_is_one_clear_error(self):
        if "view" not in run("--help")[0].split():
            self.skipTest("built without the viewer")
        path = os.path.join(self.folder.name, "cut.pvs")
        shutil.copyfile(self.pvs, path)
        server = subprocess.Popen([ANTUMBRA, "view", self.scene, path, "--no-open", "--json", "--port", "0"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            text = ""
            while not text.endswith("}\n"):
                text += server.stdout.readline()
            os.truncate(path, 0)
            with self.assertRaises((OSError, http.client.HTTPException)):
                urllib.request.urlopen(json.loads(text)["url"] + "api/explain?object=3&eye=2,1.5,2", timeout=60).read()
            _, errors = server.communicate(timeout=60)
        finally:
            server.kill()
        self.assertEqual(server.returncode, 1)
        self.assertIn("antumbra: a file was made shorter", errors)

    def test_verify_keys_and_another_scene_is_refused(self):
        keys = {"viewpoints", "pixels", "false_invisible_objects", "false_invisible_pixels", "false_visible_objects", "worst"}
        result = run_json("verify", self.scene, self.pvs, "--samples", 4)
        self.assertTrue(keys <= result.keys())
        mos = os.path.join(self.folder.name, "mos.pvs")
        made = run_json("prepare", self.scene, "-o", mos, "--mos", "--mos-grid", "2x1x2")
        self.assertEqual(made["chunks"][-1]["name"], "MOSD")
        self.assertFalse(os.path.exists(mos + ".mos-checkpoint"))
        walked = run_json("walk", self.scene, "--pvs", mos, "--cull", "frustum,opacity,opacity-published", "--frames", 5, "--no-draw")
        self.assertEqual([method["false_invisible_pixels"] for method in walked["methods"]], [0, 0, 0])
        self.assert_one_line_error(2, "prepare", self.scene, "-o", mos, "--mos", "--mos-grid", "2", saying=("--mos-grid",))
        other = os.path.join(self.folder.name, "other.glb")
        run("generate", "office", "-o", other, "--triangles", 20000)
        self.assert_one_line_error(1, "verify", other, self.pvs, saying=["another scene"])

    def test_prove_goes_on_from_its_table(self):
        table = os.path.join(self.folder.name, "proof.csv")
        prove = run_json("prove", self.scene, "--random-frames", 64, "--size", "32x18", "--aimed", 20, "-o", table)
        self.assertTrue(all(method["frames"] == 64 and method["lost_pixels"] == 0 for method in prove["methods"]))
        again = run_json("prove", self.scene, "--random-frames", 128, "--size", "32x18", "--aimed", 20, "-o", table)
        self.assertEqual([method["frames"] for method in again["methods"]], [128] * len(prove["methods"]))
        with open(table) as file:
            lines = file.readlines()
        self.assertEqual(len(lines), 1 + len(prove["methods"]))
        with open(table, "w") as file:
            file.writelines(["# a remark\n"] + lines)
        run_json("prove", self.scene, "--random-frames", 128, "--size", "32x18", "--aimed", 20, "-o", table)
        with open(table) as file:
            self.assertEqual(file.readlines(), ["# a remark\n"] + lines)

    def test_walk_keys(self):
        report = os.path.join(self.folder.name, "report.html")
        walk = run_json("walk", self.scene, "--pvs", self.pvs, "--frames", 4, "--report", report)
        self.assertTrue({"scene", "frames", "width", "height", "methods"} <= walk.keys())
        names = [method["name"] for method in walk["methods"]]
        self.assertTrue({"none", "frustum", "pvs"} <= set(names), names)
        keys = {"name", "guarantee", "cull_ms", "draw_ms", "frame_ms", "objects_reported", "objects_true",
                "triangles_drawn", "culled_of_frustum", "false_visible_objects", "false_invisible_objects",
                "false_invisible_pixels", "speedup_over_frustum"}
        for method in walk["methods"]:
            self.assertTrue(keys <= method.keys(), keys - method.keys())
            if method["guarantee"] in ("exact", "conservative"):
                self.assertEqual(method["false_invisible_pixels"], 0, method["name"])
        page = pathlib.Path(report).read_text()
        self.assertNotIn("src=\"http", page)
        self.assertNotIn("href=\"http", page)

    def test_trees_answer_and_are_verified(self):
        path = os.path.join(self.folder.name, "tree.pvs")
        baked = run_json("bake", self.scene, "-o", path, "--subdivision", "five", "--max-depth", 3,
                         "--rays-per-cell", 1024, "--holdout-rays", 64)
        self.assertGreater(baked["cells"], 8)
        self.assertGreater(baked["rays_reused"], 0)
        self.assertGreater(run_json("query", path, "--eye", "2,1.5,2")["count"], 10)
        self.assertEqual(run_json("verify", self.scene, path, "--samples", 2)["viewpoints"], 2)


@unittest.skipUnless(SCENES.is_dir(), "no real scenes beside the checkout")
class RealScenes(unittest.TestCase):
    def test_every_scene_goes_the_whole_way(self):
        files = sorted(f for f in SCENES.rglob("*") if f.suffix in (".glb", ".obj") and ".brushes." not in f.name)
        self.assertGreater(len(files), 10)
        with tempfile.TemporaryDirectory() as folder:
            pvs = os.path.join(folder, "scene.pvs")
            for file in files:
                with self.subTest(scene=file.name):
                    self.assertGreater(run_json("info", file)["triangles"], 0)
                    bake = run_json("bake", file, "-o", pvs, "--cells", "2x1x2", "--rays-per-cell", 1024,
                                    "--holdout-rays", 64)
                    self.assertEqual(bake["guarantee"], "aggressive")
                    bounds = run_json("info", file)["bounds"]
                    middle = ",".join(str((low + high) / 2) for low, high in zip(*bounds))
                    self.assertGreaterEqual(run_json("query", pvs, "--eye=" + middle)["count"], 0)
                    run_json("inspect", pvs)
                    run_json("verify", file, pvs, "--samples", 1)
                    walk = run_json("walk", file, "--pvs", pvs, "--frames", 2, "--size", "160x90", "--cull",
                                    "none,frustum,pvs")
                    frustum = [m for m in walk["methods"] if m["name"] == "frustum"][0]
                    self.assertEqual(frustum["false_invisible_pixels"], 0)

    def test_what_rays_see_is_in_the_visibility_that_maps_bring_along(self):
        check = pathlib.Path(ANTUMBRA).parent / "bench" / "bench_quake3_pvs"
        if not check.exists():
            self.skipTest("built without benchmarks")
        maps = [SCENES / "gamemap" / name for name in ("oa_dm2.bsp", "czest3ctf.bsp")]
        done = subprocess.run([check, "--rays", "200000", *maps], capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for line in done.stdout.splitlines()[1:]:
            pairs_seen = int(line.split(",")[4])
            self.assertGreater(pairs_seen, 10000, line)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
