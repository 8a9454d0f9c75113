// The package in node: against the answers of the program in C++, and against damage.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { AntumbraError, open, version } from "../src/index.js";
import { bytesOf, fileOf, modules, native, packageFolder, randomNumbers, randomPoint } from "./support.mjs";

const bounds = { min: [-72, -0.5, -72], max: [72, 39.5, 72] };
const comma = (vector) => vector.join(",");

test("each module is below 64 KB as a server sends it, and imports nothing", () => {
  for (const name of ["query", "cull-simd", "cull-plain"]) {
    const bytes = readFileSync(`${modules}/${name}.wasm`);
    assert.ok(gzipSync(bytes, { level: 9 }).length < 65536, `${name} has ${gzipSync(bytes, { level: 9 }).length} bytes`);
    assert.deepEqual(WebAssembly.Module.imports(new WebAssembly.Module(bytes)), []);
  }
});

test("the version is that of the package and of the header", () => {
  const { version: stated } = JSON.parse(readFileSync(`${packageFolder}package.json`));
  const header = readFileSync(`${packageFolder}../../include/antumbra/antumbra.h`, "utf8");
  const part = (name) => header.match(new RegExp(`ANT_VERSION_${name} (\\d+)`))[1];
  assert.equal(version, stated);
  assert.equal(version, `${part("MAJOR")}.${part("MINOR")}.${part("PATCH")}`);
});

test("the lock file names no registry, and the package needs nothing", () => {
  assert.doesNotMatch(readFileSync(`${packageFolder}package-lock.json`, "utf8"), /"resolved"/);
  const { dependencies, peerDependenciesMeta } = JSON.parse(readFileSync(`${packageFolder}package.json`));
  assert.equal(dependencies, undefined);
  assert.equal(peerDependenciesMeta.three.optional, true);
});

for (const name of ["town.pvs", "tree.pvs", "square.pvs"])
  test(`${name}: random questions get the answers of the program`, async () => {
    const pvs = await open(pathToFileURL(fileOf(name)));
    const random = randomNumbers(7);
    const box = pvs.info.grid ?? bounds;
    for (let i = 0; i < 16; ++i) {
      const eye = randomPoint(random, box.min, box.max, i % 4 === 0 ? 2 : 0);
      const direction = randomPoint(random, [-1, -1, -1], [1, 1, 1]);
      const extra = [
        [{}, []],
        [{ radius: 0.25 }, ["--radius", "0.25"]],
        [{ direction, fov: 50, aspect: 1.5 }, ["--dir", comma(direction), "--fov", "50", "--aspect", "1.5"]],
      ][i % 3];
      const answer = pvs.query({ eye, ...extra[0] });
      const truth = native("query", fileOf(name), "--eye", comma(eye), ...extra[1], "--json");
      assert.deepEqual(Array.from(answer.ids), truth.visible.map(({ id }) => id));
      assert.equal(answer.count, truth.count);
      const cell = answer.cell === -3 && pvs.info.grid ? pvs.cellAt(eye) : answer.cell; // as the program does
      assert.equal(cell < 0 ? null : cell, truth.cell);
      assert.equal(answer.guarantee, truth.guarantee);
      assert.equal(answer.everything, truth.everything);
    }
    pvs.dispose();
  });

test("objects and the file's description are those of the program", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const truth = native("inspect", fileOf("town.pvs"), "--json");
  const { info } = pvs;
  assert.equal(info.objectCount, truth.objects);
  assert.equal(info.cellCount, truth.cells);
  assert.deepEqual(info.grid.count, truth.grid.count);
  assert.deepEqual([info.grid.min, info.grid.max], truth.grid.bounds);
  assert.equal(info.guarantee, truth.guarantee);
  assert.equal(info.sceneFingerprint, truth.scene_fingerprint);
  assert.equal(info.structureFingerprint.toString(16).padStart(16, "0"), truth.structure_fingerprint);
  assert.equal(info.fileBytes, truth.bytes);
  assert.equal(info.volumeCount, truth.volumes);
  assert.deepEqual(info.options, truth.options);
  const { visible } = native("query", fileOf("town.pvs"), "--eye", "0,-1000,0", "--json"); // outside: all
  assert.equal(visible.length, info.objectCount);
  for (const { id, node, primitive, instance, name } of visible) {
    const object = pvs.object(id);
    assert.deepEqual([object.node, object.primitive, object.instance, object.name], [node, primitive, instance, name]);
    assert.ok(pvs.find({ node, primitive }).includes(id));
  }
});

test("clusters are those of the program, and index buffers can be sorted by them", async () => {
  const pvs = await open(bytesOf("clusters.pvs"));
  const leaves = pvs.cells();
  assert.deepEqual(leaves.map((leaf) => pvs.cell(leaf).kind).filter((kind) => kind === "baked").length, 2);
  for (const leaf of leaves) {
    const { min, max, kind } = pvs.cell(leaf);
    const eye = [0, 1, 2].map((k) => (min[k] + max[k]) / 2);
    if (kind !== "baked") continue;
    assert.equal(pvs.cellAt(eye), leaf);
    const view = pvs.createView();
    const answer = view.query({ eye });
    const truth = native("query", fileOf("clusters.pvs"), "--eye", comma(eye), "--json");
    assert.equal(pvs.info.clusterCount, truth.cluster_count);
    const bits = view.clusterBits();
    const seen = Array.from({ length: pvs.info.clusterCount }, (_, c) => c).filter((c) => view.seesCluster(c));
    assert.deepEqual(seen, truth.clusters);
    assert.deepEqual(seen, Array.from({ length: pvs.info.clusterCount }, (_, c) => c).filter((c) => (bits[c >> 3] >> (c & 7)) & 1));
    assert.ok(seen.length > 0 && seen.length < pvs.info.clusterCount && answer.count < pvs.info.objectCount);
    view.dispose();
  }
  let total = 0;
  for (let id = 0; id < pvs.info.objectCount; ++id) {
    const clusters = pvs.clustersOf(id);
    assert.equal(clusters.length, pvs.object(id).triangles); // none without area here
    const index = Uint16Array.from({ length: 3 * clusters.length }, (_, k) => k);
    const sorted = pvs.sortByCluster(id, index);
    assert.ok(sorted.index instanceof Uint16Array);
    assert.deepEqual(Array.from(sorted.index).sort((a, b) => a - b), Array.from(index));
    for (const { cluster, start, count } of sorted.ranges) {
      assert.ok(count > 0 && count <= 12);
      for (let k = start; k < start + count; k += 3) assert.equal(clusters[sorted.index[k] / 3], cluster);
    }
    total += sorted.ranges.length;
    assert.throws(() => pvs.sortByCluster(id, new Uint16Array(3 * clusters.length + 3)), { code: "mismatch" });
  }
  assert.equal(total, pvs.info.clusterCount);
  const plain = await open(bytesOf("town.pvs"));
  assert.equal(plain.info.clusterCount, 0);
  assert.throws(() => plain.clustersOf(0), { code: "usage" });
});

test("bits, ids and sees() agree; differences add up to the answer", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const random = randomNumbers(3);
  const shown = new Set(Array.from({ length: pvs.info.objectCount }, (_, id) => id));
  let changes = 0;
  for (let i = 0; i < 200; ++i) {
    const answer = pvs.query({ eye: randomPoint(random, bounds.min, bounds.max, 5) });
    changes += answer.changed ? 1 : 0;
    for (const id of answer.shown) assert.ok(!shown.has(id) && shown.add(id));
    for (const id of answer.hidden) assert.ok(shown.delete(id));
    assert.deepEqual([...shown].sort((a, b) => a - b), Array.from(answer.ids));
    for (let id = 0; id < pvs.info.objectCount; ++id) {
      assert.equal(answer.sees(id), shown.has(id));
      assert.equal((answer.bits[id >> 3] >> (id & 7)) & 1, shown.has(id) ? 1 : 0);
    }
  }
  assert.ok(changes > 100);
  const again = pvs.query({ eye: [4, 18, 4] });
  assert.equal(pvs.query({ eye: [4, 18, 4] }), again); // live
  assert.ok(!again.changed && again.shown.length === 0 && again.hidden.length === 0);
});

test("views are independent of each other", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const left = pvs.createView(), right = pvs.createView();
  const a = left.query({ eye: [-60, 1, -60] }).ids, b = right.query({ eye: [60, 1, 60] }).ids;
  assert.notDeepEqual(a, b);
  assert.deepEqual(left.query({ eye: [-60, 1, -60] }).ids, a);
  left.dispose();
  assert.throws(() => left.query({ eye: [0, 0, 0] }), { code: "usage" });
  assert.deepEqual(right.query({ eye: [60, 1, 60] }).ids, b);
});

test("a box of viewpoints sees what its viewpoints see", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const min = [-10, 1, -10], max = [10, 2, 10], random = randomNumbers(5);
  const union = new Set(pvs.query({ box: { min, max } }).ids);
  for (let i = 0; i < 50; ++i)
    for (const id of pvs.query({ eye: randomPoint(random, min, max) }).ids) assert.ok(union.has(id));
});

test("moving boxes are asked by volumes", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const view = pvs.createView();
  assert.throws(() => view.seesBox([0, 0, 0], [1, 1, 1]), { code: "usage" }); // nothing asked yet
  const random = randomNumbers(9);
  const said = [0, 0];
  for (let i = 0; i < 200; ++i) {
    view.query({ eye: randomPoint(random, bounds.min, [72, 5, 72]) });
    const at = randomPoint(random, [-70, 0, -70], [70, 3, 70]);
    ++said[view.seesBox(at, at.map((value) => value + 1)) ? 1 : 0];
  }
  assert.ok(said[0] > 10 && said[1] > 10, String(said));
  assert.ok(view.seesBox([0, 0, 0], [1000, 1, 1])); // partly outside of the volumes
});

test("cells tell where they are", async () => {
  const pvs = await open(bytesOf("square.pvs"));
  const cell = pvs.cell(pvs.cellAt([3, 2, 0]));
  assert.equal(cell.kind, "baked");
  assert.ok(cell.min.every((least, k) => least <= [3, 2, 0][k] && [3, 2, 0][k] <= cell.max[k]));
  assert.equal(pvs.cellAt([3, 200, 0]), -1);
  assert.throws(() => pvs.cell(2), { code: "usage" });
  assert.throws(() => pvs.object(pvs.info.objectCount), { code: "usage" });
});

test("senseless eyes see everything, senseless questions are refused", async () => {
  const pvs = await open(bytesOf("square.pvs"));
  for (const eye of [[NaN, 0, 0], [Infinity, 2, 0], [0, -1e300, 0]]) {
    const answer = pvs.query({ eye });
    assert.ok(answer.everything && answer.count === pvs.info.objectCount && answer.guarantee === "conservative");
  }
  for (const question of [{}, { eye: [1, 2] }, { eye: "1,2,3" }, { box: {} }, { eye: [1, 2, 3], direction: 4 }])
    assert.throws(() => pvs.query(question), (error) => error instanceof AntumbraError && error.code === "usage");
});

test("bytes come from everywhere", async () => {
  const bytes = bytesOf("square.pvs");
  const sources = {
    ArrayBuffer: bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength),
    "view of a larger buffer": new Uint8Array([0, ...bytes, 0]).subarray(1, bytes.length + 1),
    DataView: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength),
    URL: pathToFileURL(fileOf("square.pvs")),
    "text of a URL": String(pathToFileURL(fileOf("square.pvs"))),
    Blob: new Blob([bytes]),
    Response: new Response(bytes),
    ReadableStream: new Blob([bytes]).stream(),
    "stream in pieces": (async function* () {
      for (let at = 0; at < bytes.length; at += 1000) yield bytes.subarray(at, at + 1000);
    })(),
  };
  for (const [name, source] of Object.entries(sources))
    assert.equal((await open(source)).info.objectCount, 749, name);
});

test("what cannot be loaded says where", async () => {
  await assert.rejects(open(pathToFileURL("/no/such.pvs")), { code: "io", message: /no\/such\.pvs/ });
  await assert.rejects(open(new Response("", { status: 404 })), { code: "io", message: /404/ });
  await assert.rejects(open(42), { code: "usage", message: /ArrayBuffer/ });
  const controller = new AbortController();
  controller.abort();
  await assert.rejects(open(pathToFileURL(fileOf("town.pvs")), { signal: controller.signal }), { code: "cancelled" });
});

test("damage is found, wherever it is, and named", async () => {
  const bytes = bytesOf("square.pvs");
  const random = randomNumbers(11);
  const codes = new Set();
  for (let i = 0; i < 300; ++i) {
    const damaged = i % 3 === 0 ? bytes.slice(0, Math.floor(random() * bytes.length)) : bytes.slice();
    if (i % 3 !== 0) damaged[Math.floor(random() * bytes.length)] ^= 1 << Math.floor(random() * 8);
    await assert.rejects(open(damaged), (error) => {
      codes.add(error.code);
      return error instanceof AntumbraError && error.message.length > 20;
    });
  }
  assert.ok(codes.has("corrupt"));
  assert.ok([...codes].every((code) => code === "corrupt" || code === "unsupported"), [...codes].join());
  const text = bytes.slice();
  text[text.length - 1] ^= 1;
  await assert.rejects(open(text), { message: /ROWS.*checksum/ });
});

test("files are independent; a disposed one refuses, and its memory goes", async () => {
  const bytes = bytesOf("town.pvs");
  const keep = await open(bytes);
  for (let i = 0; i < 300; ++i) {
    const pvs = await open(bytes);
    pvs.query({ eye: [0, 2, 0] });
    pvs.dispose();
    assert.throws(() => pvs.query({ eye: [0, 2, 0] }), { code: "usage" });
    assert.throws(() => pvs.object(0), { code: "usage" });
  }
  assert.ok(keep.query({ eye: [0, 2, 0] }).count > 0);
  assert.deepEqual(keep.bytes(), bytes);
});

test("many threads may load it", async () => {
  const { Worker } = await import("node:worker_threads");
  const code = `
    import { parentPort, workerData } from "node:worker_threads";
    const { open } = await import(workerData.package);
    const pvs = await open(workerData.bytes);
    parentPort.postMessage(Array.from(pvs.query({ eye: [4, 18, 4] }).ids));`;
  const workerData = { package: new URL("../src/index.js", import.meta.url).href, bytes: bytesOf("town.pvs") };
  const worker = new Worker(new URL(`data:text/javascript,${encodeURIComponent(code)}`), { workerData });
  const ids = await new Promise((resolve, reject) => worker.once("message", resolve).once("error", reject));
  const pvs = await open(bytesOf("town.pvs"));
  assert.deepEqual(ids, Array.from(pvs.query({ eye: [4, 18, 4] }).ids));
});
