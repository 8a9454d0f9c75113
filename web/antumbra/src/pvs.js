// An opened .pvs file and its views.
import { AntumbraError } from "./errors.js";
import { Answer } from "./runtime.js";

const GUARANTEES = [undefined, "exact", "conservative", "aggressive", "approximate"];
const KINDS = ["baked", "not-baked", "solid"];
const INFO_BYTES = 168;
const OCCLUDES = 1, DOUBLE_SIDED = 2, ALWAYS_VISIBLE = 4, MOVES = 8;
const CURSOR = { ids: "ant_cursor_read_ids", bits: "ant_cursor_read_bits", changes: "ant_cursor_read_changes" };
const DEGREES = Math.PI / 180;

export function guaranteeOf(number) {
  return GUARANTEES[number] ?? "approximate";
}

function isVector(value) {
  return value != null && value.length === 3 && typeof value[0] === "number";
}

function needVector(value, what) {
  if (!isVector(value)) throw new AntumbraError("usage", `query: ${what} is not an array of three numbers`);
  return value;
}

/** The answer for an eye or a range of eyes. */
export class PvsAnswer extends Answer {
  constructor(instance, handle, objectCount) {
    super(instance, CURSOR, handle, objectCount);
    this.cell = -2;
  }
}

/** One view of a file: a camera, an eye of a headset, a shadow cascade. Remembers its last answer. */
export class PvsView {
  constructor(pvs) {
    this._pvs = pvs;
    const instance = pvs._alive();
    instance.call("ant_cursor_create", pvs._handle, instance.scratch);
    this._cursor = instance.view.getUint32(instance.scratch, true);
    this._in = instance.allocate(128);
    this.answer = new PvsAnswer(instance, this._cursor, pvs.info.objectCount);
  }

  query(question) {
    const instance = this._alive();
    const { eye, box, radius, direction } = question;
    const at = this._in;
    const changed = at + 120;
    if (box === undefined && direction === undefined && radius === undefined) {
      instance.putVector(at, needVector(eye, "eye"));
      instance.call("ant_cursor_query", this._cursor, at, changed);
    } else {
      this._putRange(instance, question);
      const tangent = Math.tan(((question.fov ?? 60) * DEGREES) / 2);
      const hasDirection = direction !== undefined;
      instance.call("ant_cursor_query_range", this._cursor, at, at + 24, hasDirection ? at + 48 : 0,
                    hasDirection ? at + 72 : 0, tangent, question.aspect ?? 16 / 9, changed);
    }
    if (instance.view.getInt32(changed, true) === 0) {
      this.answer._same();
      return this.answer;
    }
    return this._read(instance);
  }

  _putRange(instance, { eye, box, radius = 0, direction, up }) {
    const low = [0, 0, 0], high = [0, 0, 0];
    if (box !== undefined) {
      const least = needVector(box.min, "box.min"), greatest = needVector(box.max, "box.max");
      for (let k = 0; k < 3; ++k) [low[k], high[k]] = [least[k], greatest[k]];
    } else {
      needVector(eye, "eye");
      for (let k = 0; k < 3; ++k) [low[k], high[k]] = [eye[k] - radius, eye[k] + radius];
    }
    instance.putVector(this._in, low);
    instance.putVector(this._in + 24, high);
    if (direction === undefined) return;
    instance.putVector(this._in + 48, needVector(direction, "direction"));
    instance.putVector(this._in + 72, up === undefined ? [0, 1, 0] : needVector(up, "up"));
  }

  _read(instance) {
    const { answer } = this;
    const at = instance.scratch;
    instance.call("ant_cursor_describe", this._cursor, at);
    const { view } = instance;
    answer.cell = Number(view.getBigInt64(at, true));
    answer.guarantee = guaranteeOf(view.getInt32(at + 8, true));
    answer.everything = view.getInt32(at + 12, true) !== 0;
    answer.count = view.getUint32(at + 16, true);
    answer._differences();
    return answer;
  }

  /** Can something of a cluster be seen, by the last answer? */
  seesCluster(cluster) {
    const instance = this._alive();
    instance.call("ant_cursor_sees_cluster", this._cursor, cluster, this._in);
    return instance.view.getInt32(this._in, true) !== 0;
  }

  /** Of the last answer: cluster c is bit c % 8 of byte c / 8. */
  clusterBits() {
    this._alive();
    return this._pvs._read("ant_cursor_read_cluster_bits", 1, this._cursor);
  }

  /** Can something that moves within this box be seen, by the last answer? */
  seesBox(min, max) {
    const instance = this._alive();
    instance.putVector(this._in, needVector(min, "min"));
    instance.putVector(this._in + 24, needVector(max, "max"));
    instance.call("ant_cursor_sees_box", this._cursor, this._in, this._in + 24, this._in + 48);
    return instance.view.getInt32(this._in + 48, true) !== 0;
  }

  dispose() {
    if (this._cursor && this._pvs._instance) {
      const instance = this._pvs._instance;
      instance.exports.ant_cursor_destroy(this._cursor);
      instance.free(this._in);
      instance.free(this.answer._lists.shown);
    }
    this._cursor = 0;
  }

  _alive() {
    const instance = this._pvs._alive();
    if (!this._cursor) throw new AntumbraError("usage", "this view has been disposed of");
    return instance;
  }
}

export class Pvs {
  /** For open(). Copies the bytes into the instance. */
  constructor(instance, bytes) {
    this._instance = instance;
    const file = instance.allocate(bytes.byteLength);
    instance.u8.set(bytes, file);
    instance.callWithText("ant_pvs_open_memory", file, bytes.byteLength, instance.scratch);
    this._handle = instance.view.getUint32(instance.scratch, true);
    this._file = { address: file, length: bytes.byteLength };
    this._nodes = null;
    this._view = null;
    this.info = this._describe(instance);
  }

  _describe(instance) {
    const at = instance.scratch;
    instance.view.setUint32(at, INFO_BYTES, true);
    instance.call("ant_pvs_describe", this._handle, at);
    const { view } = instance;
    const cells = Number(view.getBigUint64(at + 16, true));
    const fingerprint = instance.u8.slice(at + 112, at + 128);
    const info = {
      guarantee: guaranteeOf(view.getInt32(at + 4, true)),
      objectCount: view.getUint32(at + 8, true),
      cellCount: cells,
      grid: cells === 0 ? null : {
        count: [24, 28, 32].map((offset) => view.getUint32(at + offset, true)),
        min: instance.vector(at + 40),
        max: instance.vector(at + 64),
      },
      doubleSided: view.getUint32(at + 36, true) !== 0,
      origin: instance.vector(at + 88),
      sceneFingerprint: Array.from(fingerprint, (byte) => byte.toString(16).padStart(2, "0")).join(""),
      structureFingerprint: view.getBigUint64(at + 128, true),
      fileBytes: Number(view.getBigUint64(at + 136, true)),
      visibilityBytes: Number(view.getBigUint64(at + 144, true)),
      volumeCount: Number(view.getBigUint64(at + 152, true)),
      treeNodes: Number(view.getBigUint64(at + 160, true)),
    };
    instance.call("ant_pvs_count_clusters", this._handle, at);
    info.clusterCount = instance.view.getUint32(at, true);
    info.method = instance.readText("ant_pvs_read_text", this._handle, 0);
    info.toolVersion = instance.readText("ant_pvs_read_text", this._handle, 1);
    const options = instance.readText("ant_pvs_read_text", this._handle, 2);
    try {
      info.options = JSON.parse(options);
    } catch {
      info.options = {};
    }
    return Object.freeze(info);
  }

  /** With the file's own view; the answer is live until the next query. */
  query(question) {
    this._view ??= this.createView();
    return this._view.query(question);
  }

  createView() {
    return new PvsView(this);
  }

  object(id) {
    const instance = this._alive();
    const at = instance.scratch;
    if (!(id >= 0 && id < this.info.objectCount))
      throw new AntumbraError("usage", `there is no object ${id}: the file has ${this.info.objectCount}`);
    instance.call("ant_object_describe", this._handle, id, at);
    const { view } = instance;
    const flags = view.getUint32(at + 12, true);
    const object = {
      id,
      node: view.getInt32(at, true),
      primitive: view.getInt32(at + 4, true),
      instance: view.getInt32(at + 8, true),
      occludes: (flags & OCCLUDES) !== 0,
      doubleSided: (flags & DOUBLE_SIDED) !== 0,
      alwaysVisible: (flags & ALWAYS_VISIBLE) !== 0,
      moves: (flags & MOVES) !== 0,
      triangles: view.getUint32(at + 16, true),
      bounds: { min: instance.vector(at + 24), max: instance.vector(at + 48) },
    };
    object.name = instance.readText("ant_object_read_name", this._handle, id);
    return object;
  }

  /** Three numbers for each object, node, primitive and instance: a quick way to match many. */
  keys() {
    const instance = this._alive();
    const keys = new Int32Array(this.info.objectCount * 3);
    for (let id = 0; id < this.info.objectCount; ++id) {
      instance.call("ant_object_describe", this._handle, id, instance.scratch);
      for (let k = 0; k < 3; ++k) keys[id * 3 + k] = instance.view.getInt32(instance.scratch + 4 * k, true);
    }
    return keys;
  }

  /** The objects of a glTF node, or of one of its primitives or instances. */
  find({ node, primitive, instance }) {
    if (!this._nodes) {
      this._keys = this.keys();
      this._nodes = new Map();
      for (let id = 0; id < this.info.objectCount; ++id) {
        const list = this._nodes.get(this._keys[id * 3]);
        if (list) list.push(id);
        else this._nodes.set(this._keys[id * 3], [id]);
      }
    }
    return (this._nodes.get(node) ?? []).filter(
      (id) =>
        (primitive === undefined || this._keys[id * 3 + 1] === primitive) &&
        (instance === undefined || this._keys[id * 3 + 2] === instance),
    );
  }

  /** Calls a function of the rule "sizes come first"; what it wrote, of so many bytes each, valid until the next call. */
  _read(name, bytes, ...args) {
    const instance = this._alive();
    const at = instance.scratch;
    instance.call(name, ...args, 0, 0, at);
    const count = instance.view.getUint32(at, true);
    if (count === 0) return new Uint8Array(0);
    const buffer = instance.allocate(count * bytes);
    try {
      instance.call(name, ...args, buffer, count, at);
      return instance.u8.slice(buffer, buffer + count * bytes);
    } finally {
      instance.free(buffer);
    }
  }

  /** For each triangle of the object in the scene's file the number of its cluster; 0xFFFFFFFF: none, never seen. */
  clustersOf(id) {
    if (!(id >= 0 && id < this.info.objectCount))
      throw new AntumbraError("usage", `there is no object ${id}: the file has ${this.info.objectCount}`);
    if (this.info.clusterCount === 0)
      throw new AntumbraError("usage", "the file lists no clusters: bake it with --granularity cluster");
    return new Uint32Array(this._read("ant_object_read_clusters", 4, this._handle, id).buffer);
  }

  /** An index buffer of the object's triangles sorted by cluster, and which part of it each cluster is. */
  sortByCluster(id, index) {
    const clusters = this.clustersOf(id);
    if (index.length !== 3 * clusters.length)
      throw new AntumbraError(
        "mismatch",
        `object ${id} has ${clusters.length} triangles in the baked scene, and here ${index.length / 3}; draw it whole`,
      );
    const order = Array.from(clusters.keys()).filter((t) => clusters[t] !== 0xffffffff);
    order.sort((a, b) => clusters[a] - clusters[b] || a - b);
    const sorted = new index.constructor(3 * order.length);
    const ranges = [];
    order.forEach((t, place) => {
      for (let k = 0; k < 3; ++k) sorted[3 * place + k] = index[3 * t + k];
      if (ranges.length === 0 || ranges.at(-1).cluster !== clusters[t])
        ranges.push({ cluster: clusters[t], start: 3 * place, count: 0 });
      ranges.at(-1).count += 3;
    });
    return { index: sorted, ranges };
  }

  cell(index) {
    const instance = this._alive();
    const cells = this.info.cellCount || this.info.treeNodes;
    const at = instance.scratch;
    if (!(Number.isInteger(index) && index >= 0 && index < cells) ||
        instance.exports.ant_cell_describe(this._handle, BigInt(index), at) !== 0)
      throw new AntumbraError("usage", `there is no cell ${index}: the file has a ${this.info.grid ? "grid" : "tree"} of ${cells}`);
    return {
      index,
      kind: KINDS[instance.view.getInt32(at, true)],
      min: instance.vector(at + 8),
      max: instance.vector(at + 32),
    };
  }

  /** The numbers of all cells: of a grid, or the leaves of a view tree. */
  cells() {
    const instance = this._alive();
    if (this.info.grid) return Array.from({ length: this.info.cellCount }, (_, index) => index);
    const leaves = [];
    for (let node = 0; node < this.info.treeNodes; ++node)
      if (instance.exports.ant_cell_describe(this._handle, BigInt(node), instance.scratch) === 0) leaves.push(node);
    return leaves;
  }

  /** The number of the cell at a point, or -1. */
  cellAt(point) {
    const instance = this._alive();
    const at = instance.scratch;
    instance.putVector(at, needVector(point, "point"));
    instance.call("ant_cell_find", this._handle, at, at + 24);
    return Number(instance.view.getBigInt64(at + 24, true));
  }

  /** A copy of the file. */
  bytes() {
    const instance = this._alive();
    return instance.u8.slice(this._file.address, this._file.address + this._file.length);
  }

  /** Gives all memory back. Views of the file are dead after it. */
  dispose() {
    this._instance = null;
    this._view = null;
  }

  _alive() {
    if (!this._instance) throw new AntumbraError("usage", "this .pvs has been disposed of");
    return this._instance;
  }
}
