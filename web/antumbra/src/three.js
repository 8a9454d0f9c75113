// The three.js helper: draws what a baked file says can be seen.
//
//     import { cull } from "antumbra/three";
//     const culling = await cull(gltf, "town.pvs");
//     culling.update(camera); // each frame, before rendering
import { Box3, Group, Matrix4, Object3D, Vector3 } from "three";
import { AntumbraError } from "./errors.js";
import { structureFingerprint } from "./fingerprint.js";
import { open } from "./index.js";
import { Pvs } from "./pvs.js";
import { BatchedTargets, InstancedTargets, MeshTarget } from "./three_targets.js";

export { AntumbraError, structureFingerprint };

/** What three.js asks of an LOD as it collects what to draw: the only moment that tells which camera is drawing. */
class Sentinel extends Object3D {
  constructor(act) {
    super();
    this.isLOD = true;
    this.autoUpdate = true;
    this.layers.enableAll();
    this.matrixAutoUpdate = false;
    this.update = act;
  }
  raycast() {}
}

const matrix = new Matrix4();
const point = new Vector3();

/** The box that a camera's sight starts from: its eye and the near rectangle, in the coordinates of `toLocal`. */
function extendBySight(camera, toLocal, box, near) {
  matrix.multiplyMatrices(toLocal, camera.matrixWorld);
  const p = camera.projectionMatrix.elements, n = near ? camera.near : 0;
  const add = (x, y, z) => box.expandByPoint(point.set(x, y, z).applyMatrix4(matrix));
  if (!camera.isOrthographicCamera) add(0, 0, 0);
  if (!camera.isOrthographicCamera && n > 0) {
    for (const x of [p[8] - 1, p[8] + 1]) for (const y of [p[9] - 1, p[9] + 1]) add((n * x) / p[0], (n * y) / p[5], -n);
  } else if (camera.isOrthographicCamera) {
    for (const x of [-1, 1]) for (const y of [-1, 1]) add((x - p[12]) / p[0], (y - p[13]) / p[5], -camera.near);
  }
}

export class Culling extends EventTarget {
  constructor(root, pvs, options) {
    super();
    this.root = root;
    this.pvs = pvs;
    this.camera = null;
    this.frozen = false;
    this.near = options.near ?? true;
    this._enabled = true;
    this._view = pvs.createView();
    this._targets = new Array(pvs.info.objectCount).fill(null);
    this._groups = [];
    this._owner = new Map();
    this._toLocal = new Matrix4();
    this._box = new Box3();
    this._range = { box: { min: [0, 0, 0], max: [0, 0, 0] } };
    this._outside = false;
    this._bind(options);
    this._addStage();
  }

  /** Objects that are hidden now, and that are drawn; how many of the file's objects are not in the scene. */
  get hidden() {
    return this._enabled ? this.pvs.info.objectCount - this._view.answer.count : 0;
  }
  get drawn() {
    return this.pvs.info.objectCount - this.hidden;
  }
  get unmatched() {
    return this._targets.reduce((sum, target) => sum + (target ? 0 : 1), 0);
  }
  /** The last answer, with the guarantee, the cell and the visible ids. */
  get answer() {
    return this._view.answer;
  }

  // The hidden ones hang in a group of their own, last in the scene. It is skipped as a whole while the main camera
  // collects what to draw, and is there for shadows, reflections and other cameras.
  _addStage() {
    this._stage = new Group();
    this._stage.name = "antumbra";
    this._stage.add(
      new Sentinel((camera) => (this._hidden.visible = camera !== this.camera)),
      this._hidden,
      new Sentinel(() => (this._hidden.visible = true)),
    );
    this.root.add(this._stage);
  }

  _bind({ associations, bind }) {
    this._hidden = new Group();
    // They do not move on their own: nothing is to be done unless the whole scene has moved.
    this._hidden.updateMatrixWorld = function (force) {
      if (force) Group.prototype.updateMatrixWorld.call(this, true);
    };
    const ids = new Map();
    const keys = this.pvs.keys();
    for (let id = 0; id < keys.length / 3; ++id) {
      const key = `${keys[3 * id]}/${keys[3 * id + 1]}`;
      if (!ids.has(key)) ids.set(key, []);
      ids.get(key).push({ id, instance: keys[3 * id + 2] });
    }
    for (const claim of this._find(ids, associations)) this._bindObject(claim);
    for (const { mesh, objects } of bind ?? []) this._bindInstances(mesh, objects);
  }

  /** Which meshes are which objects. One that two meshes claim stays unbound, that is, drawn. */
  _find(ids, associations) {
    const claims = new Map();
    const visit = (object, at, node) => {
      const association = associations.get(object);
      const isNode = association?.nodes !== undefined;
      const own = isNode ? association.nodes : node;
      // GLTFLoader tells nothing about the primitives of EXT_mesh_gpu_instancing: they stand in their order.
      const primitive = association?.primitives ?? (object.isInstancedMesh ? (isNode ? 0 : at) : undefined);
      if (object.isMesh && !object.isSkinnedMesh && own !== undefined && primitive !== undefined) {
        const key = `${own}/${primitive}`;
        if (ids.has(key)) claims.set(key, claims.has(key) ? null : { object, at, found: ids.get(key) });
      }
      object.children.forEach((child, i) => visit(child, i, own));
    };
    visit(this.root, 0, undefined);
    return [...claims.values()].filter((claim) => claim && claim.object !== this.root);
  }

  _bindObject({ object, at, found }) {
    if (object.isInstancedMesh && found[0].instance >= 0) {
      if (found.length !== object.count) return;
      const objects = [];
      for (const { id, instance } of found) objects[instance] = id;
      this._bindInstances(object, objects, at);
    } else if (!object.isInstancedMesh && found.length === 1 && found[0].instance < 0) {
      this._targets[found[0].id] = new MeshTarget(object, at, this);
    }
  }

  /** objects[i]: the file's object that instance i shows; undefined: always drawn. */
  _bindInstances(mesh, objects, at = mesh.parent?.children.indexOf(mesh)) {
    const group = mesh.isBatchedMesh ? new BatchedTargets(mesh, this) : new InstancedTargets(mesh, at, this);
    this._groups.push(group);
    objects.forEach((id, instance) => {
      if (id === undefined || id === null) return;
      if (!(id >= 0 && id < this._targets.length))
        throw new AntumbraError("usage", `bind: there is no object ${id}: the file has ${this._targets.length}`);
      this._targets[id] = group.target(instance);
    });
  }

  /** Each frame, before rendering. Returns whether anything changed. */
  update(camera) {
    if (!this._view) throw new AntumbraError("usage", "this culling has been disposed of");
    this.camera = camera;
    if (!this._enabled || this.frozen) return false;
    this._locate(camera);
    const answer = this._view.query(this._range);
    if (!answer.changed && answer.everything === this._outside) return false;
    const { shown, hidden } = answer;
    for (let i = 0; i < shown.length; ++i) this._targets[shown[i]]?.show();
    for (let i = 0; i < hidden.length; ++i) this._targets[hidden[i]]?.hide();
    this._tell(answer);
    return answer.changed;
  }

  _locate(camera) {
    this.root.updateWorldMatrix(true, false);
    camera.updateWorldMatrix(true, false);
    this._toLocal.copy(this.root.matrixWorld).invert();
    this._box.makeEmpty();
    const cameras = camera.isArrayCamera && camera.cameras.length > 0 ? camera.cameras : [camera];
    for (const one of cameras) extendBySight(one, this._toLocal, this._box, this.near);
    this._box.min.toArray(this._range.box.min);
    this._box.max.toArray(this._range.box.max);
  }

  _tell(answer) {
    if (answer.everything !== this._outside) {
      this._outside = answer.everything;
      this.dispatchEvent(new Event(this._outside ? "outside" : "inside"));
    }
    if (answer.changed)
      this.dispatchEvent(Object.assign(new Event("change"), { shown: answer.shown, hidden: answer.hidden }));
  }

  /** False: everything is drawn. */
  get enabled() {
    return this._enabled;
  }
  set enabled(on) {
    if (on === this._enabled) return;
    this._enabled = on;
    const { answer } = this._view;
    for (let id = 0; id < this._targets.length; ++id)
      if (!answer.sees(id)) this._targets[id]?.[on ? "hide" : "show"]();
  }

  /** Draws everything, leaves the scene as it was found, and gives memory back. */
  dispose() {
    if (!this._view) return;
    if (this._view.answer.hasBeenAsked) this.enabled = false;
    for (const group of this._groups) group.release();
    for (const target of this._targets) target?.release();
    this._stage.removeFromParent();
    this._view.dispose();
    this._view = null;
    if (this._ownsPvs) this.pvs.dispose();
  }
}

/** Attaches a baked file to a loaded glTF: see antumbra/three in docs/web.md. */
export async function cull(gltf, source, options = {}) {
  const isOpen = source instanceof Pvs;
  const pvs = isOpen ? source : await open(source, options);
  try {
    if (!options.allowStale) checkStructure(gltf, pvs);
    const culling = new Culling(gltf.scene, pvs, { ...options, associations: gltf.parser.associations });
    culling._ownsPvs = !isOpen;
    return culling;
  } catch (error) {
    if (!isOpen) pvs.dispose();
    throw error;
  }
}

function checkStructure(gltf, pvs) {
  const found = structureFingerprint(gltf.parser.json);
  if (found !== pvs.info.structureFingerprint)
    throw new AntumbraError(
      "mismatch",
      "the .pvs was baked from another version of this scene (their structure fingerprints differ): bake it again, as the " +
        "last step after every optimisation of the glTF",
    );
}
