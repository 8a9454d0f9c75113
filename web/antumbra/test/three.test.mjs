// The three.js helper, in node: what is in the lists that three.js draws from.
import assert from "node:assert/strict";
import { test } from "node:test";
import * as THREE from "three";
import { open } from "../src/index.js";
import { cull, structureFingerprint } from "../src/three.js";
import { bytesOf, fileOf, loadGltf, native, packageFolder, randomNumbers, randomPoint, run } from "./support.mjs";

globalThis.self ??= globalThis; // GLTFLoader asks for it
const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");
const loadTown = () => loadGltf(THREE, GLTFLoader, bytesOf("town.glb"));
const bounds = { min: [-72, 0, -72], max: [72, 20, 72] };

/** What three.js would collect for a camera: visible meshes in the order of traversal, LODs asked on the way. */
function collect(object, camera, found = []) {
  if (!object.visible) return found;
  if (object.isLOD) object.update(camera);
  if (object.isMesh && object.layers.test(camera.layers)) found.push(object);
  for (const child of object.children) collect(child, camera, found);
  return found;
}

function nodesOf(gltf, meshes) {
  return meshes.map((mesh) => gltf.parser.associations.get(mesh).nodes).sort((a, b) => a - b);
}

function camera(position = [0, 0, 0]) {
  const made = new THREE.PerspectiveCamera(60, 1.5, 0.05, 1000);
  made.position.set(...position);
  return made;
}

test("exactly the visible objects are drawn, whatever the camera does", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  assert.equal(culling.unmatched, 0);
  culling.near = false;
  const eye = camera(), random = randomNumbers(1), pvs = await open(bytesOf("town.pvs"));
  const nodes = Array.from({ length: pvs.info.objectCount }, (_, id) => pvs.object(id).node);
  let changes = 0;
  for (let i = 0; i < 100; ++i) {
    eye.position.set(...randomPoint(random, bounds.min, bounds.max, 10));
    changes += culling.update(eye) ? 1 : 0;
    const truth = Array.from(pvs.query({ eye: eye.position.toArray() }).ids, (id) => nodes[id]).sort((a, b) => a - b);
    assert.deepEqual(nodesOf(gltf, collect(gltf.scene, eye)), truth);
    assert.equal(culling.drawn, truth.length);
    assert.equal(culling.update(eye), false);
  }
  assert.ok(changes > 50);
});

test("other cameras and shadows see everything; traversal and names still find everything", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const eye = camera([20, 1.7, 20]), other = camera();
  culling.update(eye);
  const all = culling.pvs.info.objectCount;
  assert.ok(culling.hidden > 100);
  for (let i = 0; i < 2; ++i) {
    assert.equal(collect(gltf.scene, eye).length, culling.drawn);
    // After the main camera has collected, the shadow pass walks over what is visible without asking LODs again.
    let casters = 0;
    gltf.scene.traverseVisible((object) => (casters += object.isMesh ? 1 : 0));
    assert.equal(casters, all);
    assert.equal(collect(gltf.scene, other).length, all);
  }
  let found = 0;
  gltf.scene.traverse((object) => (found += object.isMesh ? 1 : 0));
  assert.equal(found, all);
  const hidden = culling._hidden.children[0];
  assert.equal(gltf.scene.getObjectByName(hidden.name).name, hidden.name);
  assert.equal(hidden.parent, gltf.scene);
});

test("hidden objects follow a scene that moves, and so does the camera: frame, scale and turn", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const world = new THREE.Scene(), holder = new THREE.Group();
  world.add(holder.add(gltf.scene));
  const plain = camera([20, 1.7, 20]);
  culling.update(plain);
  const before = nodesOf(gltf, collect(gltf.scene, plain));
  holder.position.set(100, 20, -30);
  holder.rotation.set(0.3, 1, 0.2);
  holder.scale.setScalar(0.01);
  world.updateMatrixWorld();
  for (const object of culling._hidden.children) {
    const expected = new THREE.Matrix4().multiplyMatrices(gltf.scene.matrixWorld, object.matrix);
    assert.deepEqual(object.matrixWorld.elements, expected.elements);
  }
  const moved = camera([...holder.localToWorld(new THREE.Vector3(20, 1.7, 20))]);
  moved.near = 0.0005;
  moved.updateProjectionMatrix();
  culling.update(moved);
  assert.deepEqual(nodesOf(gltf, collect(gltf.scene, moved)), before);
});

test("the near rectangle counts: what is drawn is what any of its points sees", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const eye = camera(), random = randomNumbers(2), pvs = culling.pvs;
  eye.near = 3;
  eye.updateProjectionMatrix();
  for (let i = 0; i < 50; ++i) {
    eye.position.set(...randomPoint(random, [-60, 5, -60], [60, 20, 60]));
    eye.lookAt(...randomPoint(random, bounds.min, bounds.max));
    culling.update(eye);
    for (const [x, y] of [[0, 0], [1, 1], [-1, 1], [1, -1], [-1, -1]]) {
      const point = new THREE.Vector3(x, y, -1).unproject(eye);
      for (const id of pvs.query({ eye: point.toArray() }).ids) assert.ok(culling.answer.sees(id));
    }
    for (const id of pvs.query({ eye: eye.position.toArray() }).ids) assert.ok(culling.answer.sees(id));
  }
  const box = new THREE.OrthographicCamera(-4, 4, 3, -3, 1, 100);
  box.position.set(10, 8, 10);
  culling.update(box);
  for (const [x, y] of [[1, 1], [-1, 1], [1, -1], [-1, -1]])
    for (const id of pvs.query({ eye: new THREE.Vector3(x, y, -1).unproject(box).toArray() }).ids)
      assert.ok(culling.answer.sees(id));
});

test("outside every cell everything is drawn, and an event says so", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const told = [];
  for (const name of ["outside", "inside", "change"])
    culling.addEventListener(name, (event) => told.push(name === "change" ? event.hidden.length > 0 : name));
  const eye = camera([20, 1.7, 20]);
  culling.update(eye);
  eye.position.y = 1000;
  culling.update(eye);
  assert.equal(culling.hidden, 0);
  assert.equal(collect(gltf.scene, eye).length, culling.pvs.info.objectCount);
  eye.position.y = 1.7;
  culling.update(eye);
  assert.deepEqual(told, [true, "outside", false, "inside", true]);
});

test("enabled, frozen, dispose", async () => {
  const gltf = await loadTown();
  const before = gltf.scene.children.slice();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const eye = camera([20, 1.7, 20]);
  culling.enabled = false;
  culling.enabled = true;
  assert.equal(collect(gltf.scene, eye).length, 749);
  culling.update(eye);
  const drawn = collect(gltf.scene, eye).length;
  assert.ok(drawn < 700);
  culling.enabled = false;
  assert.equal(collect(gltf.scene, eye).length, 749);
  culling.enabled = true;
  assert.equal(collect(gltf.scene, eye).length, drawn);
  culling.frozen = true;
  eye.position.set(-60, 1.7, -60);
  assert.equal(culling.update(eye), false);
  assert.equal(collect(gltf.scene, eye).length, drawn);
  culling.dispose();
  culling.dispose();
  assert.deepEqual(new Set(gltf.scene.children), new Set(before));
  assert.equal(gltf.scene.children.length, before.length);
  assert.throws(() => culling.update(eye), { code: "usage" });
});

test("who else changes the scene does no harm", async () => {
  const gltf = await loadTown();
  const culling = await cull(gltf, bytesOf("town.pvs"));
  const eye = camera([20, 1.7, 20]), random = randomNumbers(4);
  const extra = Array.from({ length: 5 }, () => new THREE.Mesh());
  for (let i = 0; i < 50; ++i) {
    const mesh = extra[i % 5];
    if (mesh.parent) mesh.removeFromParent();
    else gltf.scene.add(mesh);
    eye.position.set(...randomPoint(random, bounds.min, bounds.max));
    culling.update(eye);
    const there = extra.filter((one) => one.parent).length;
    assert.equal(collect(gltf.scene, eye).length, culling.drawn + there);
  }
});

test("a stale bake is refused, and the fingerprint is that of the baker", async () => {
  const gltf = await loadTown();
  const pvs = await open(bytesOf("town.pvs"));
  assert.equal(structureFingerprint(gltf.parser.json), pvs.info.structureFingerprint);
  gltf.parser.json.accessors[gltf.parser.json.meshes[0].primitives[0].indices].count -= 3;
  await assert.rejects(cull(gltf, pvs), { code: "mismatch", message: /bake it again/ });
  const culling = await cull(gltf, pvs, { allowStale: true });
  culling.dispose();
  assert.ok(pvs.query({ eye: [0, 2, 0] }).count > 0); // whose file it is, may go on
});

/** A glTF of boxes: `nodes` of JSON, mesh 0 a box, mesh 1 two boxes; returns a .glb. */
function boxes(nodes, extra = {}, instances = []) {
  const positions = [], indices = [];
  for (let i = 0; i < 8; ++i) positions.push(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
  for (const [a, b, c, d] of [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])
    indices.push(a, b, c, a, c, d);
  const binary = Buffer.concat([
    Buffer.from(new Float32Array(positions).buffer),
    Buffer.from(new Uint16Array(indices).buffer),
    Buffer.from(new Float32Array(instances).buffer),
  ]);
  const primitive = { attributes: { POSITION: 0 }, indices: 1 };
  const json = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: nodes.map((_, n) => n).filter((n) => !nodes.some((node) => node.children?.includes(n))) }],
    nodes,
    meshes: [{ primitives: [primitive] }, { primitives: [primitive, { ...primitive, material: 0 }] }],
    materials: [{ doubleSided: true }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 8, type: "VEC3", min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5] },
      { bufferView: 1, componentType: 5123, count: 36, type: "SCALAR" },
      ...(instances.length ? [{ bufferView: 2, componentType: 5126, count: instances.length / 3, type: "VEC3" }] : []),
    ],
    bufferViews: [
      { buffer: 0, byteLength: 96 },
      { buffer: 0, byteOffset: 96, byteLength: 72 },
      ...(instances.length ? [{ buffer: 0, byteOffset: 168, byteLength: instances.length * 4 }] : []),
    ],
    buffers: [{ byteLength: binary.length }],
    ...extra,
  };
  const pad = (buffer, fill) => Buffer.concat([buffer, Buffer.alloc(-buffer.length & 3, fill)]);
  const text = pad(Buffer.from(JSON.stringify(json)), " "), data = pad(binary, 0);
  const head = (...words) => Buffer.from(new Uint32Array(words).buffer);
  return Buffer.concat([head(0x46546c67, 2, 28 + text.length + data.length), head(text.length, 0x4e4f534a), text,
                        head(data.length, 0x004e4942), data]);
}

/** Writes and bakes a scene of one room of viewpoints. */
async function bake(name, glb, where) {
  const { writeFileSync } = await import("node:fs");
  writeFileSync(fileOf(`${name}.glb`), glb);
  writeFileSync(fileOf(`${name}.json`), JSON.stringify(where));
  native("bake", fileOf(`${name}.glb`), "-o", fileOf(`${name}.pvs`), "--cell-size", "1", "--where", fileOf(`${name}.json`),
         "--rays-per-cell", "4096", "--json");
  return { gltf: await loadGltf(THREE, GLTFLoader, new Uint8Array(glb)), pvs: bytesOf(`${name}.pvs`) };
}

const wall = { mesh: 0, translation: [0, 0, -5], scale: [60, 60, 0.2] };
const FRONT = [{ min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5] }];

test("several primitives, shared meshes, and children of meshes that are hidden", async () => {
  const nodes = [
    wall,
    { mesh: 1, translation: [0, 0, -3], name: "before" }, // two primitives, both before the wall
    { mesh: 1, translation: [0, 0, -8], name: "behind" },
    { mesh: 0, translation: [1, 0, -9], name: "parent", children: [4] }, // hidden
    { mesh: 0, translation: [0, 0, 7], name: "child" }, // hangs below it, but in front of the wall
  ];
  const { gltf, pvs } = await bake("nested", boxes(nodes), FRONT);
  const culling = await cull(gltf, pvs);
  assert.equal(culling.unmatched, 0);
  const eye = camera();
  culling.update(eye);
  gltf.scene.updateMatrixWorld();
  const seen = collect(gltf.scene, eye);
  const places = seen.map((mesh) => mesh.getWorldPosition(new THREE.Vector3()).toArray().join()).sort();
  const visible = Array.from(culling.answer.ids, (id) => culling.pvs.object(id));
  assert.equal(seen.length, visible.length);
  assert.ok(places.includes("1,0,-2"), "the child is drawn where it was: " + places.join(" "));
  assert.ok(!places.includes("1,0,-9") && !places.includes("0,0,-8"));
  culling.dispose();
  const parent = gltf.scene.getObjectByName("parent");
  assert.equal(parent.children[0].name, "child");
  assert.equal(collect(gltf.scene, eye).length, 7);
});

test("instances: visible ones come first; other cameras and shadows get all", async () => {
  const places = [];
  for (let i = 0; i < 40; ++i) places.push((i % 5) - 2, Math.floor(i / 5) % 4 - 1.5, i % 2 ? -3 : -8);
  const instanced = { mesh: 0, scale: [0.8, 0.8, 0.8], extensions: { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: 2 } } } };
  const glb = boxes([wall, instanced], { extensionsUsed: ["EXT_mesh_gpu_instancing"] }, places);
  const { gltf, pvs } = await bake("instanced", glb, FRONT);
  const culling = await cull(gltf, pvs);
  assert.equal(culling.unmatched, 0);
  const mesh = gltf.scene.getObjectByProperty("isInstancedMesh", true);
  const original = Array.from(mesh.instanceMatrix.array);
  const eye = camera(), matrix = new THREE.Matrix4();
  const shown = (count) => {
    const list = [];
    for (let slot = 0; slot < count; ++slot) {
      mesh.getMatrixAt(slot, matrix);
      list.push(matrix.elements.slice(12, 15).join());
    }
    return list.sort();
  };
  const all = shown(40);
  culling.update(eye);
  const ids = Array.from(culling.answer.ids).map((id) => culling.pvs.object(id)).filter(({ instance }) => instance >= 0);
  assert.ok(ids.length >= 10 && ids.length <= 20, String(ids.length)); // none of those behind the wall
  const expected = ids.map(({ instance }) => places.slice(3 * instance, 3 * instance + 3).map(Math.fround).join()).sort();
  mesh.onBeforeRender(null, null, eye);
  assert.equal(mesh.count, ids.length);
  assert.deepEqual(shown(mesh.count), expected);
  mesh.onBeforeRender(null, null, camera());
  assert.equal(mesh.count, 40);
  assert.deepEqual(shown(40), all);
  mesh.onBeforeShadow();
  assert.equal(mesh.count, 40);
  mesh.onAfterShadow();
  assert.equal(mesh.count, ids.length);
  assert.ok(mesh.boundingSphere.radius > 3);
  culling.dispose();
  assert.deepEqual(Array.from(mesh.instanceMatrix.array), original);
  assert.equal(mesh.count, 40);
});

test("a BatchedMesh of one's own shows what it is bound to", async () => {
  const nodes = [wall, ...Array.from({ length: 10 }, (_, i) => ({ mesh: 0, translation: [i - 4.5, 0, i % 2 ? -3 : -8] }))];
  const { gltf, pvs } = await bake("batched", boxes(nodes), FRONT);
  const opened = await open(pvs);
  const batch = new THREE.BatchedMesh(11, 100, 200, new THREE.MeshBasicMaterial());
  const box = batch.addGeometry(new THREE.BoxGeometry());
  const objects = nodes.map((_, node) => {
    batch.addInstance(box);
    return opened.find({ node })[0];
  });
  gltf.scene.clear();
  gltf.scene.add(batch);
  const culling = await cull(gltf, opened, { bind: [{ mesh: batch, objects }] });
  assert.equal(culling.unmatched, 0);
  const eye = camera();
  culling.update(eye);
  for (let i = 0; i < 11; ++i) assert.equal(batch.getVisibleAt(i), culling.answer.sees(objects[i]));
  assert.ok(culling.hidden >= 5);
  const before = Array.from({ length: 11 }, (_, i) => batch.getVisibleAt(i));
  let during = 0;
  culling._groups[0].saved.before = () => (during = objects.filter((_, i) => batch.getVisibleAt(i)).length);
  batch.onBeforeShadow();
  assert.equal(during, 11);
  assert.deepEqual(Array.from({ length: 11 }, (_, i) => batch.getVisibleAt(i)), before);
  await assert.rejects(cull(gltf, opened, { bind: [{ mesh: batch, objects: [99] }] }), { code: "usage" });
});

test("two scenes on one page do not know of each other", async () => {
  const [first, second] = await Promise.all([loadTown(), loadTown()]);
  second.scene.position.x = 500;
  const world = new THREE.Scene();
  world.add(first.scene, second.scene);
  const [a, b] = await Promise.all([cull(first, bytesOf("town.pvs")), cull(second, bytesOf("town.pvs"))]);
  const eye = camera([20, 1.7, 20]);
  a.update(eye);
  b.update(eye);
  assert.ok(a.hidden > 0 && b.hidden === 0); // the eye is outside of the second
  assert.equal(collect(world, eye).length, a.drawn + b.drawn);
});

test("importing it does nothing, and needs no window: server-side rendering", () => {
  const code = `for (const name of ["window", "document", "self"]) delete globalThis[name];
    const before = Object.keys(globalThis).length;
    await import("${packageFolder}src/index.js"); await import("${packageFolder}src/cull.js"); await import("${packageFolder}src/three.js");
    if (Object.keys(globalThis).length !== before) process.exit(1);`;
  const { code: exit, err } = run(process.execPath, ["--input-type=module", "-e", code], { cwd: packageFolder });
  assert.equal(exit, 0, err);
});
