// npx antumbra: the same answers, keys and exit codes as the program in C++.
import assert from "node:assert/strict";
import { test } from "node:test";
import { bin, fileOf, native, run } from "./support.mjs";

const antumbra = (...args) => run(process.execPath, [bin, ...args]);

test("query answers as the program does", () => {
  const town = [fileOf("town.pvs"), "--eye", "-4,1.7,3"], rooms = [fileOf("clusters.pvs"), "--eye", "1.5,1.5,1.5"];
  for (const asked of [town, [...town, "--dir", "-1,0,0.5"], [...town, "--radius", "0.5"], rooms, [...rooms, "--dir", "-1,0,0.5"]]) {
    const args = ["query", ...asked, "--json"];
    const { code, out } = antumbra(...args);
    assert.equal(code, 0);
    const { volumes_visible: _, ...truth } = native(...args);
    assert.deepEqual(JSON.parse(out), truth);
  }
  const text = antumbra("query", fileOf("town.pvs"), "--eye=-4,1.7,3");
  assert.match(antumbra("query", ...rooms).out, /\nclusters {3}[1-9]\d* of \d+\n/);
  assert.match(text.out, /^cell {7}\d+\nguarantee {2}aggressive\nvisible {4}\d+ of 749 objects\n {7,}\d+ {2}node \d+/);
});

test("info and inspect tell what the program's inspect tells", () => {
  const truth = native("inspect", fileOf("square.pvs"), "--json");
  for (const command of ["info", "inspect"]) {
    const { code, out } = antumbra(command, fileOf("square.pvs"), "--json");
    assert.equal(code, 0);
    for (const [key, value] of Object.entries(JSON.parse(out))) assert.deepEqual(value, truth[key], key);
  }
  const text = antumbra("inspect", fileOf("square.pvs"), "--worst", "1").out;
  assert.match(text, /guarantee {4}exact\n/);
  assert.equal(text.match(/worst cell/g).length, 1);
});

test("wrong usage exits 2 and shows the help, all else 1 and one line", () => {
  for (const args of [[], ["bake", "x"], ["info"], ["info", "a", "b"], ["query", fileOf("town.pvs")],
                      ["query", fileOf("town.pvs"), "--eye", "1,2"], ["query", fileOf("town.pvs"), "--eye", "1,2,x"],
                      ["info", fileOf("town.pvs"), "--frobnicate"]]) {
    const { code, err, out } = antumbra(...args);
    assert.equal(code, 2, args.join(" "));
    assert.equal(out, "");
    assert.match(err, /usage: antumbra/);
  }
  for (const [file, said] of [["/no/such.pvs", /\/no\/such\.pvs/], [fileOf("town.glb"), /town\.glb: .*not a \.pvs/]]) {
    const { code, err } = antumbra("info", file);
    assert.equal(code, 1);
    assert.match(err, said);
    assert.equal(err.trimEnd().split("\n").length, 1);
  }
  assert.equal(antumbra("--help").code, 0);
  assert.match(antumbra("--version").out, /^\d+\.\d+\.\d+\n$/);
});
