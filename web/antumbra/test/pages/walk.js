// Draws random frames of a baked scene twice, everything and what can be seen, and compares the pictures.
import { cull } from "antumbra/three";
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Objects with colours of their own, so that each that is missing is seen. `flat`: the colour is the node's index. */
function colour(gltf, flat) {
  const Material = flat ? THREE.MeshBasicMaterial : THREE.MeshLambertMaterial;
  let index = 0;
  gltf.scene.traverse((object) => {
    if (!object.isMesh) return;
    ++index;
    const color = flat ? gltf.parser.associations.get(object).nodes + 1 : Math.imul(index, 2654435761) & 0xffffff;
    object.material = new Material({ color });
  });
}

function addLight(world, shadows, centre) {
  const light = new THREE.DirectionalLight(0xffffff, 3);
  light.position.set(centre.x + 30, 60, centre.z + 20);
  light.target.position.copy(centre);
  world.add(light, light.target, new THREE.AmbientLight(0xffffff, 1));
  if (!shadows) return;
  light.castShadow = true;
  Object.assign(light.shadow.camera, { left: -80, right: 80, top: 80, bottom: -80, far: 200 });
  light.shadow.mapSize.set(1024, 1024);
  world.traverse((object) => Object.assign(object, object.isMesh ? { castShadow: true, receiveShadow: true } : {}));
}

function draw(renderer, world, camera, pixels) {
  const gl = renderer.getContext();
  const start = performance.now();
  renderer.render(world, camera);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return { time: performance.now() - start, calls: renderer.info.render.calls, triangles: renderer.info.render.triangles };
}

/** Up to a thousand pixels that differ: nodes in the first and the second picture, of `flat` colours. */
function listDifferent(a, b, width) {
  const list = [];
  for (let i = 0; i < a.length && list.length < 1000; i += 4)
    if (a[i] !== b[i] || a[i + 1] !== b[i + 1] || a[i + 2] !== b[i + 2]) {
      const node = (pixels) => ((pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2]) - 1;
      list.push({ x: (i / 4) % width, y: Math.floor(i / 4 / width), all: node(a), culled: node(b) });
    }
  return list;
}

function countDifferent(a, b) {
  const left = new Uint32Array(a.buffer), right = new Uint32Array(b.buffer);
  let different = 0;
  for (let i = 0; i < left.length; ++i) different += left[i] !== right[i] ? 1 : 0;
  return different;
}

const median = (list) => list.slice().sort((a, b) => a - b)[Math.floor(list.length / 2)];

window.run = async ({ scene, pvs, frames, seed = 1, shadows = false, near = 0.05, width = 480, height = 320, margin = 0.1, flat = false }) => {
  const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
  renderer.setSize(width, height);
  renderer.shadowMap.enabled = shadows;
  document.body.append(renderer.domElement);
  const gltf = await new GLTFLoader().loadAsync(scene);
  colour(gltf, flat);
  const world = new THREE.Scene();
  world.background = new THREE.Color(0x88aacc);
  world.add(gltf.scene);
  const bytes = await (await fetch(pvs)).arrayBuffer();
  let start = performance.now();
  const culling = await cull(gltf, bytes);
  const openMs = performance.now() - start;
  const { grid } = culling.pvs.info;
  const baked = [];
  for (let index = 0; index < culling.pvs.info.cellCount; ++index)
    if (culling.pvs.cell(index).kind === "baked") baked.push(culling.pvs.cell(index));
  addLight(world, shadows, new THREE.Vector3(...grid.min).add(new THREE.Vector3(...grid.max)).multiplyScalar(0.5));
  const camera = new THREE.PerspectiveCamera(60, width / height, near, 500);
  const random = randomNumbers(seed);
  const all = new Uint8Array(width * height * 4), some = all.slice();
  const rows = [];
  culling.enabled = false;
  draw(renderer, world, camera, all); // shaders and buffers
  for (let frame = -1; frame < frames; ++frame) {
    const cell = baked[Math.floor(random() * baked.length)];
    const eye = cell.min.map((least, k) => {
      const low = Math.max(least, grid.min[k] + margin), high = Math.min(cell.max[k], grid.max[k] - margin);
      return low + random() * (high - low);
    });
    camera.position.set(...eye);
    const turn = random() * 2 * Math.PI;
    camera.lookAt(eye[0] + Math.cos(turn), eye[1] + 0.4 * (random() - 0.5), eye[2] + Math.sin(turn));
    culling.enabled = true;
    start = performance.now();
    const changed = culling.update(camera);
    const update = performance.now() - start;
    const hidden = culling.hidden;
    const culled = draw(renderer, world, camera, some);
    culling.enabled = false;
    const plain = draw(renderer, world, camera, all);
    if (frame < 0) continue; // the first one uploads what the others find there
    rows.push({ frame, eye, forward: camera.getWorldDirection(new THREE.Vector3()).toArray(), changed, update, hidden, different: countDifferent(all, some), outside: culling.answer.everything,
                plainMs: plain.time, culledMs: culled.time, plainCalls: plain.calls, culledCalls: culled.calls,
                plainTriangles: plain.triangles, culledTriangles: culled.triangles,
                list: flat ? listDifferent(all, some, width) : undefined });
  }
  const of = (key) => median(rows.map((row) => row[key]));
  return { openMs, rows, objects: culling.pvs.info.objectCount,
           summary: Object.fromEntries(["plainMs", "culledMs", "plainCalls", "culledCalls", "plainTriangles", "culledTriangles",
                                        "hidden"].map((key) => [key, of(key)])) };
};
