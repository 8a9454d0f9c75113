// node update.mjs SCENE.glb FILE.pvs: what the three.js helper costs per frame, without drawing. CSV on stdout. A change is a
// jump to a random cell, far more than a walk asks for.
import { readFileSync } from "node:fs";
import * as THREE from "../../web/antumbra/node_modules/three/build/three.module.js";
import { cull } from "../../web/antumbra/src/three.js";
import { randomNumbers, randomPoint } from "../../web/antumbra/test/support.mjs";

globalThis.self ??= globalThis;
const { GLTFLoader } = await import("../../web/antumbra/node_modules/three/examples/jsm/loaders/GLTFLoader.js");
const [scene, file] = process.argv.slice(2);
const glb = readFileSync(scene), bytes = readFileSync(file);
const gltf = await new Promise((resolve, reject) =>
  new GLTFLoader().parse(glb.buffer.slice(glb.byteOffset, glb.byteOffset + glb.byteLength), "", resolve, reject));

const start = performance.now();
const culling = await cull(gltf, bytes);
const attach = performance.now() - start;
const { grid, objectCount } = culling.pvs.info;
const camera = new THREE.PerspectiveCamera(60, 1.6, 0.1, 1000);
const random = randomNumbers(1);
const quantile = (list, share) => list.sort((a, b) => a - b)[Math.floor(share * (list.length - 1))];

const baked = Array.from({ length: culling.pvs.info.cellCount }, (_, index) => culling.pvs.cell(index)).filter(({ kind }) => kind === "baked");
const changes = [], moved = [];
for (let i = 0; i < 4000; ++i) {
  const cell = baked[Math.floor(random() * baked.length)];
  const inside = (k) => [Math.max(cell.min[k], grid.min[k] + 0.2), Math.min(cell.max[k], grid.max[k] - 0.2)];
  const low = [0, 1, 2].map((k) => inside(k)[0]), high = [0, 1, 2].map((k) => inside(k)[1]);
  camera.position.set(...randomPoint(random, low, high));
  const begin = performance.now();
  const changed = culling.update(camera);
  const took = performance.now() - begin;
  if (!changed || i < 200) continue;
  changes.push(took);
  moved.push(culling.answer.shown.length + culling.answer.hidden.length);
}
const same = [];
for (let i = 0; i < 4000; ++i) {
  camera.rotation.y += 0.001;
  const begin = performance.now();
  for (let k = 0; k < 10; ++k) culling.update(camera);
  same.push((performance.now() - begin) / 10);
}
console.log("objects,cells,guarantee,attach_ms,same_cell_median_ms,same_cell_p99_ms,change_median_ms,change_p99_ms,changed_objects_median,drawn_median");
console.log([objectCount, baked.length, culling.pvs.info.guarantee, attach.toFixed(1), quantile(same, 0.5).toFixed(5), quantile(same, 0.99).toFixed(5),
  quantile(changes, 0.5).toFixed(4), quantile(changes, 0.99).toFixed(4), quantile(moved, 0.5), culling.drawn].join());
