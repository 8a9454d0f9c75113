// Culling from a point, each frame, without any bake: for scenes that change, or that nobody has baked.
import { AntumbraError } from "./errors.js";
import { guaranteeOf } from "./pvs.js";
import { Answer, Instance, compile } from "./runtime.js";

export { AntumbraError };

const STATE = { ids: "ant_cull_state_read_ids", bits: "ant_cull_state_read_bits", changes: "ant_cull_state_read_changes" };
const INPUT_BYTES = 64, OPTIONS_BYTES = 24, VIEW_BYTES = 120, ANSWER_BYTES = 64;
const TEXT = new TextDecoder();

// (func (result v128) i32.const 0 i8x16.splat i8x16.popcnt)
const SIMD_PROBE = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0,
                                   253, 15, 253, 98, 11]);

/** Whether this engine has WebAssembly SIMD: then the faster of two modules with the same answers is loaded. */
export function hasSimd() {
  return typeof WebAssembly !== "undefined" && WebAssembly.validate(SIMD_PROBE);
}

const compiled = {};

async function instantiate(simd = hasSimd()) {
  const kind = simd ? "simd" : "plain";
  compiled[kind] ??= (simd ? import("../generated/cull-simd.js") : import("../generated/cull-plain.js")).then(({ wasm }) =>
    compile(wasm),
  );
  return new Instance(await compiled[kind]);
}

function needLength(array, length, what) {
  if (array?.length !== length) throw new AntumbraError("usage", `CullScene: ${what} must hold ${length} numbers`);
}

/** Copies numbers to new memory; remembers what to free. */
function put(instance, garbage, array, Type) {
  if (!array || array.length === 0) return 0;
  const address = instance.allocate(array.length * Type.BYTES_PER_ELEMENT);
  garbage.push(address);
  new Type(instance.exports.memory.buffer, address, array.length).set(array);
  return address;
}

function centreOf(bounds) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < bounds.length; ++i) {
    const value = bounds[i], k = i % 3;
    if (!Number.isFinite(value)) continue;
    if (value < low[k]) low[k] = value;
    if (value > high[k]) high[k] = value;
  }
  return low.map((value, k) => (value <= high[k] ? Math.round((value + high[k]) / 2) : 0));
}

export class CullScene {
  /** For create() and fromPvs(). */
  constructor(instance, handle, pvs) {
    this._instance = instance;
    this._handle = handle;
    this._pvs = pvs; // address of the opened file, or 0
    const at = instance.scratch;
    instance.view.setUint32(at, 12, true);
    instance.call("ant_cull_scene_describe", handle, at);
    this.objectCount = instance.view.getUint32(at + 4, true);
    this.occluderCount = instance.view.getUint32(at + 8, true);
  }

  static async create(input, options = {}) {
    const { bounds, flags, occluders } = input;
    const count = bounds.length / 6;
    if (!Number.isInteger(count)) throw new AntumbraError("usage", "CullScene: bounds must hold six numbers for each object");
    if (flags) needLength(flags, count, "flags");
    const triangles = occluders?.triangles ?? [], vertices = occluders?.vertices ?? [];
    if (triangles.length % 3 || vertices.length % 3)
      throw new AntumbraError("usage", "CullScene: occluders must hold three numbers for each vertex and each triangle");
    if (occluders?.twoSided) needLength(occluders.twoSided, triangles.length / 3, "occluders.twoSided");
    const instance = await instantiate(options.simd);
    const garbage = [];
    const boundsAt = put(instance, garbage, bounds, Float64Array);
    const flagsAt = put(instance, garbage, flags, Uint32Array);
    const verticesAt = put(instance, garbage, vertices, Float64Array);
    const trianglesAt = put(instance, garbage, triangles, Uint32Array);
    const sidesAt = put(instance, garbage, occluders?.twoSided, Uint8Array);
    const at = instance.scratch, { view } = instance;
    view.setUint32(at, INPUT_BYTES, true);
    view.setUint32(at + 4, count, true);
    view.setUint32(at + 8, boundsAt, true);
    view.setUint32(at + 12, flagsAt, true);
    instance.putVector(at + 16, input.origin ?? centreOf(bounds));
    view.setUint32(at + 40, vertices.length / 3, true);
    view.setUint32(at + 44, verticesAt, true);
    view.setUint32(at + 48, triangles.length / 3, true);
    view.setUint32(at + 52, trianglesAt, true);
    view.setUint32(at + 56, sidesAt, true);
    instance.callWithText("ant_cull_scene_create", at, at + INPUT_BYTES);
    garbage.forEach((address) => instance.free(address));
    return new CullScene(instance, instance.view.getUint32(at + INPUT_BYTES, true), 0);
  }

  /** The scene of an opened file, which is copied: its objects in their order, and the occluders that it may bring. */
  static async fromPvs(pvs, options = {}) {
    const instance = await instantiate(options.simd);
    const bytes = pvs.bytes();
    const file = instance.allocate(bytes.length), at = instance.scratch;
    instance.u8.set(bytes, file); // stays: the method "pvs" asks it
    instance.callWithText("ant_pvs_open_memory", file, bytes.length, at);
    const handle = instance.view.getUint32(at, true);
    instance.callWithText("ant_cull_scene_create_from_pvs", handle, at);
    return new CullScene(instance, instance.view.getUint32(at, true), handle);
  }

  /** What createCuller() knows. */
  get methods() {
    const instance = this._alive();
    return Array.from({ length: instance.exports.ant_culler_method_count() }, (_, i) =>
      instance.readText("ant_culler_read_method", i),
    );
  }

  createCuller(method, options = {}) {
    return new Culler(this, method, options);
  }

  /** Gives all memory back, that of cullers and views, too. */
  dispose() {
    this._instance = null;
  }

  _alive() {
    if (!this._instance) throw new AntumbraError("usage", "this cull scene has been disposed of");
    return this._instance;
  }
}

export class Culler {
  constructor(scene, method, options) {
    this._scene = scene;
    this.method = method;
    const instance = scene._alive();
    const name = new TextEncoder().encode(method + "\0");
    const at = instance.scratch;
    instance.call("ant_culler_options_init", at, OPTIONS_BYTES);
    const { view } = instance;
    if (options.occluders !== undefined) view.setUint32(at + 4, options.occluders, true);
    if (options.rasterWidth !== undefined) view.setUint32(at + 8, options.rasterWidth, true);
    if (options.polygonBudget !== undefined) view.setUint32(at + 12, options.polygonBudget, true);
    if (options.pixelsPerPolygon !== undefined) view.setFloat32(at + 16, options.pixelsPerPolygon, true);
    if (method === "pvs" && scene._pvs) view.setUint32(at + 20, scene._pvs, true);
    const nameAt = instance.allocate(name.length);
    instance.u8.set(name, nameAt);
    try {
      instance.callWithText("ant_culler_create", scene._handle, nameAt, at, at + OPTIONS_BYTES);
    } finally {
      instance.free(nameAt);
    }
    this._handle = instance.view.getUint32(at + OPTIONS_BYTES, true);
    instance.call("ant_culler_guarantee", this._handle, at);
    this.guarantee = guaranteeOf(instance.view.getInt32(at, true));
  }

  createView() {
    return new CullView(this);
  }

  /** With the culler's own view; the answer is live until the next call. */
  cull(camera) {
    this._view ??= this.createView();
    return this._view.cull(camera);
  }

  dispose() {
    if (this._handle && this._scene._instance) this._scene._instance.exports.ant_culler_destroy(this._handle);
    this._handle = 0;
  }
}

export class CullAnswer extends Answer {
  constructor(instance, handle, objectCount) {
    super(instance, STATE, handle, objectCount);
    this.reason = "";
    this.stages = { boxesTested: 0, outsideFrustum: 0, hiddenByPvs: 0, hiddenByOccluders: 0, occludersUsed: 0 };
  }
}

/** What one camera keeps from frame to frame, and its last answer. */
export class CullView {
  constructor(culler) {
    this._culler = culler;
    const instance = culler._scene._alive();
    instance.call("ant_cull_state_create", instance.scratch);
    this._state = instance.view.getUint32(instance.scratch, true);
    this._in = instance.allocate(VIEW_BYTES);
    this.answer = new CullAnswer(instance, this._state, culler._scene.objectCount);
  }

  cull(camera) {
    const instance = this._culler._scene._alive();
    if (!this._state || !this._culler._handle) throw new AntumbraError("usage", "this view has been disposed of");
    const at = this._in;
    instance.call("ant_view_init", at, VIEW_BYTES);
    const { view } = instance;
    if (camera.projection === "orthographic") view.setUint32(at + 4, 1, true);
    instance.putVector(at + 8, camera.eye);
    instance.putVector(at + 32, camera.target ?? camera.eye.map((value, k) => value + camera.direction[k]));
    if (camera.up) instance.putVector(at + 56, camera.up);
    const numbers = { fov: 80, height: 88, aspect: 96, near: 104, far: 112 };
    for (const [name, offset] of Object.entries(numbers))
      if (camera[name] !== undefined) view.setFloat64(at + offset, camera[name], true);
    instance.call("ant_culler_cull", this._culler._handle, at, this._state);
    return this._read(instance);
  }

  _read(instance) {
    const { answer } = this;
    const at = instance.scratch, { view } = instance;
    view.setUint32(at, ANSWER_BYTES, true);
    instance.call("ant_cull_state_describe", this._state, at);
    answer.guarantee = guaranteeOf(view.getInt32(at + 4, true));
    answer.everything = view.getInt32(at + 8, true) !== 0;
    const reason = view.getUint32(at + 12, true);
    answer.reason = TEXT.decode(instance.u8.subarray(reason, instance.u8.indexOf(0, reason)));
    answer.count = view.getUint32(at + 20, true);
    const counter = (offset) => Number(view.getBigUint64(at + offset, true));
    answer.stages = {
      boxesTested: counter(24),
      outsideFrustum: counter(32),
      hiddenByPvs: counter(40),
      hiddenByOccluders: counter(48),
      occludersUsed: counter(56),
    };
    answer._differences();
    return answer;
  }

  dispose() {
    const instance = this._culler._scene._instance;
    if (this._state && instance) {
      instance.exports.ant_cull_state_destroy(this._state);
      instance.free(this._in);
      instance.free(this.answer._lists.shown);
    }
    this._state = 0;
  }
}
