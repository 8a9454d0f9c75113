// Culling without a bake: the same bits as natively, with SIMD and without; nothing that a sight line reaches is lost.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { test } from "node:test";
import { CullScene, hasSimd } from "../src/cull.js";
import { open } from "../src/index.js";
import { bytesOf, peer, randomNumbers, randomPoint } from "./support.mjs";

/** Small boxes everywhere, and walls that hide some of them. */
function randomScene(seed, objects, walls) {
  const random = randomNumbers(seed);
  const bounds = [], vertices = [], triangles = [];
  for (let o = 0; o < objects; ++o) {
    const low = randomPoint(random, [-50, 0, -50], [50, 10, 50]);
    bounds.push(...low, ...low.map((value) => value + 0.2 + random() * 2));
  }
  for (let w = 0; w < walls; ++w) {
    const [x, y, z] = randomPoint(random, [-40, -1, -40], [40, 1, 40]);
    const along = random() < 0.5, length = 4 + 20 * random(), height = 4 + 10 * random(), first = vertices.length / 3;
    for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 1]])
      vertices.push(x + (along ? a * length : 0), y + b * height, z + (along ? 0 : a * length));
    for (const corners of [[0, 1, 2], [0, 2, 3]]) triangles.push(...corners.map((corner) => first + corner));
  }
  const twoSided = new Uint8Array(triangles.length / 3).fill(0);
  return { bounds, occluders: { vertices, triangles, twoSided }, origin: [0, 0, 0] };
}

function randomCameras(seed, count) {
  const random = randomNumbers(seed);
  return Array.from({ length: count }, () => ({
    eye: randomPoint(random, [-50, 1, -50], [50, 3, 50]),
    target: randomPoint(random, [-50, 0, -50], [50, 5, 50]),
  }));
}

const METHODS = ["frustum", "masked", "planes"];

for (const seed of [1, 2])
  test(`random scene ${seed}: the bits of WebAssembly, with SIMD and without, are those of the native library`, async () => {
    const input = randomScene(seed, 500, 40), cameras = randomCameras(seed + 10, 40);
    const { vertices, triangles } = input.occluders;
    const numbers = (Type, list) => Buffer.from(new Type(list).buffer);
    const sent = Buffer.concat([
      numbers(Uint32Array, [500, vertices.length / 3, triangles.length / 3, cameras.length]),
      numbers(Float64Array, input.bounds),
      numbers(Float64Array, vertices),
      numbers(Uint32Array, triangles),
      numbers(Float64Array, cameras.flatMap(({ eye, target }) => [...eye, ...target])),
    ]);
    const { status, stdout } = spawnSync(peer, { input: sent });
    assert.equal(status, 0);
    const bytes = Math.ceil(500 / 8);
    assert.equal(stdout.length, METHODS.length * cameras.length * bytes);
    for (const simd of [true, false]) {
      const scene = await CullScene.create(input, { simd });
      let at = 0, hidden = 0;
      for (const method of METHODS) {
        const view = scene.createCuller(method).createView();
        for (const camera of cameras) {
          const answer = view.cull(camera);
          assert.deepEqual(Buffer.from(answer.bits), stdout.subarray(at, at + bytes), `${method}, simd ${simd}`);
          hidden += answer.stages.hiddenByOccluders;
          at += bytes;
        }
      }
      assert.ok(hidden > 100, `only ${hidden} boxes were hidden`);
      scene.dispose();
    }
  });

/** Where the segment from p to q crosses the front of the triangle: then it is blocked. */
function blocks(p, q, a, b, c) {
  const minus = (u, v) => u.map((value, k) => value - v[k]);
  const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const d = minus(q, p), e1 = minus(b, a), e2 = minus(c, a), n = cross(e1, e2);
  const towards = -dot(d, n);
  if (towards <= 0) return false;
  const s = minus(p, a), t = dot(s, n) / towards, m = cross(s, d);
  const u = dot(e2, m) / towards, v = -dot(e1, m) / towards;
  return t > 0 && t < 1 && u >= 0 && v >= 0 && u + v <= 1;
}

test("no object is lost that a line of sight reaches", async () => {
  const input = randomScene(5, 300, 40), random = randomNumbers(6);
  const { vertices, triangles } = input.occluders;
  const corner = (i) => vertices.slice(3 * i, 3 * i + 3);
  const faces = Array.from({ length: triangles.length / 3 }, (_, t) => [0, 1, 2].map((i) => corner(triangles[3 * t + i])));
  const scene = await CullScene.create(input);
  for (const method of METHODS) {
    const view = scene.createCuller(method).createView();
    let seen = 0;
    for (const camera of randomCameras(7, 25)) {
      const frustum = scene.createCuller("frustum").cull(camera);
      const answer = view.cull(camera);
      for (const object of frustum.ids) {
        assert.equal(answer.guarantee, "conservative");
        if (answer.sees(object)) continue;
        const low = input.bounds.slice(6 * object, 6 * object + 3), high = input.bounds.slice(6 * object + 3, 6 * object + 6);
        for (let ray = 0; ray < 8; ++ray) {
          const goal = randomPoint(random, low, high);
          assert.ok(faces.some(([a, b, c]) => blocks(camera.eye, goal, a, b, c)) || isOutside(camera, goal),
                    `${method} lost object ${object}`);
          ++seen;
        }
      }
    }
    assert.ok(method === "frustum" ? seen === 0 : seen > 500, `${method}: ${seen}`);
  }
});

/** Is the point outside the view (60 degrees, 16 : 9)? */
function isOutside({ eye, target }, goal) {
  const f = target.map((value, k) => value - eye[k]), length = Math.hypot(...f);
  const forward = f.map((value) => value / length), d = goal.map((value, k) => value - eye[k]);
  const right = [-forward[2], 0, forward[0]], size = Math.hypot(...right);
  const r = right.map((value) => value / size);
  const up = [r[1] * forward[2] - r[2] * forward[1], r[2] * forward[0] - r[0] * forward[2], r[0] * forward[1] - r[1] * forward[0]];
  const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const depth = dot(d, forward), tangent = Math.tan(Math.PI / 6) + 1e-9;
  return depth <= 0.1 || Math.abs(dot(d, up)) > depth * tangent || Math.abs(dot(d, r)) > depth * tangent * (16 / 9);
}

test("a baked file culls in the frustum as it answers", async () => {
  const pvs = await open(bytesOf("town.pvs"));
  const scene = await CullScene.fromPvs(pvs);
  assert.equal(scene.objectCount, pvs.info.objectCount);
  const culler = scene.createCuller("pvs");
  assert.equal(culler.guarantee, "approximate"); // the file's own is aggressive
  for (const { eye, target } of randomCameras(8, 20)) {
    const answer = culler.cull({ eye, target, near: 0 });
    const cell = pvs.query({ eye });
    assert.ok(answer.count > 0 && answer.count < cell.count);
    for (const id of answer.ids) assert.ok(cell.sees(id));
  }
});

test("misuse is told", async () => {
  await assert.rejects(CullScene.create({ bounds: [1, 2, 3] }), { code: "usage" });
  await assert.rejects(CullScene.create({ bounds: [0, 0, 0, 1, 1, 1], flags: [1, 2] }), { code: "usage" });
  const occluders = { vertices: [0, 0, 0], triangles: [0, 1, 2] };
  await assert.rejects(CullScene.create({ bounds: [], occluders }), { code: "usage", message: /vertex/ });
  const scene = await CullScene.create({ bounds: [0, 0, 0, 1, 1, 1] });
  assert.deepEqual(scene.methods, ["none", "frustum", "masked", "planes", "pvs"]);
  assert.throws(() => scene.createCuller("guess"), { code: "usage", message: /masked/ });
  assert.throws(() => scene.createCuller("pvs"), { code: "usage" });
  assert.throws(() => scene.createCuller("masked", { rasterWidth: 3 }), { code: "usage" });
  const culler = scene.createCuller("planes");
  const answer = culler.cull({ eye: [0, 0, 5], target: [0, 0, 5] });
  assert.ok(answer.everything && answer.reason.length > 10 && answer.count === 1);
  culler.dispose();
  assert.throws(() => culler.cull({ eye: [0, 0, 5], target: [0, 0, 0] }), { code: "usage" });
  scene.dispose();
  assert.throws(() => scene.createCuller("planes"), { code: "usage" });
  assert.equal(hasSimd(), true);
});

test("memory is used again: thousands of scenes and views in one process", async () => {
  const input = randomScene(3, 200, 10);
  const scene = await CullScene.create(input);
  const before = () => scene._instance.exports.memory.buffer.byteLength;
  const cameras = randomCameras(1, 5);
  const round = () => {
    const culler = scene.createCuller("masked"), view = culler.createView();
    for (const camera of cameras) view.cull(camera);
    view.dispose();
    culler.dispose();
  };
  for (let i = 0; i < 20; ++i) round();
  const size = before();
  for (let i = 0; i < 500; ++i) round();
  assert.equal(before(), size);
});
