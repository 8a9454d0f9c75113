// One instance of the WebAssembly module, and how to talk to it. Each opened file has an instance of its own, so that
// closing it gives all of its memory back, and so that nothing which goes wrong in one reaches another.
import { AntumbraError, codeOf } from "./errors.js";

const SCRATCH_BYTES = 4096;
const ERROR_AT = 1024; // within the scratch memory; structs lie before it
const ERROR_BYTES = 1024;
const TEXT = new TextDecoder();

function decodeBase64(text) {
  if (typeof Uint8Array.fromBase64 === "function") return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** Compiles a module that lies in a script as base64. */
export async function compile(base64) {
  if (typeof WebAssembly === "undefined")
    throw new AntumbraError("unsupported", "this JavaScript engine has no WebAssembly, which Antumbra needs");
  try {
    return await WebAssembly.compile(decodeBase64(base64));
  } catch (cause) {
    throw new AntumbraError(
      "unsupported",
      `WebAssembly could not be compiled (${cause.message}); if the page has a Content-Security-Policy, its script-src ` +
        "must contain 'wasm-unsafe-eval'",
      { cause },
    );
  }
}

export class Instance {
  constructor(module) {
    this.exports = new WebAssembly.Instance(module, {}).exports;
    this.exports._initialize();
    this.buffer = null;
    this.refresh();
    this.scratch = this.allocate(SCRATCH_BYTES);
  }

  /** Views of memory die when it grows: call before touching memory after any call that may allocate. */
  refresh() {
    const buffer = this.exports.memory.buffer;
    if (buffer === this.buffer) return;
    this.buffer = buffer;
    this.u8 = new Uint8Array(buffer);
    this.u32 = new Uint32Array(buffer);
    this.f64 = new Float64Array(buffer);
    this.view = new DataView(buffer);
  }

  allocate(bytes) {
    const address = this.exports.malloc(Math.max(bytes, 1)) >>> 0;
    if (address === 0)
      throw new AntumbraError("limit", `${bytes} bytes of WebAssembly memory were asked for and refused`);
    this.refresh();
    return address;
  }

  free(address) {
    this.exports.free(address);
  }

  /** Calls an exported function; turns its status, or its trap, into an error. */
  call(name, ...args) {
    let status;
    try {
      status = this.exports[name](...args);
    } catch (cause) {
      this.refresh();
      const full = this.view.getInt32(this.exports.ant_wasm_out_of_memory.value, true) !== 0;
      throw new AntumbraError(
        full ? "limit" : "internal",
        full ? "there is no WebAssembly memory left" : `${name} has failed (${cause.message}); please report`,
        { cause },
      );
    }
    this.refresh();
    if (status !== 0) throw new AntumbraError(codeOf(status), `${name}: ${codeOf(status)}`);
  }

  /** The same for functions whose last two arguments take the text of an error. */
  callWithText(name, ...args) {
    this.refresh();
    const text = this.scratch + ERROR_AT;
    this.u8[text] = 0;
    try {
      this.call(name, ...args, text, ERROR_BYTES);
    } catch (error) {
      this.refresh();
      const end = this.u8.indexOf(0, text);
      if (error.cause === undefined && end > text)
        throw new AntumbraError(error.code, TEXT.decode(this.u8.subarray(text, end)));
      throw error;
    }
  }

  vector(address) {
    const at = address >> 3;
    return [this.f64[at], this.f64[at + 1], this.f64[at + 2]];
  }

  putVector(address, vector) {
    const at = address >> 3;
    this.f64[at] = vector[0];
    this.f64[at + 1] = vector[1];
    this.f64[at + 2] = vector[2];
  }

  /** Reads a text by a function whose last three arguments are buffer, capacity and length. */
  readText(name, ...args) {
    const length = this.scratch;
    this.call(name, ...args, 0, 0, length);
    const size = this.view.getUint32(length, true);
    const buffer = size + 1 <= ERROR_BYTES ? this.scratch + ERROR_AT : this.allocate(size + 1);
    this.call(name, ...args, buffer, size + 1, length);
    const text = TEXT.decode(this.u8.slice(buffer, buffer + size));
    if (buffer !== this.scratch + ERROR_AT) this.free(buffer);
    return text;
  }

  /** Memory for the ids of up to `count` objects, three times: shown, hidden, visible. */
  makeLists(count) {
    const bytes = Math.max(count, 1) * 4;
    const base = this.allocate(bytes * 3);
    return { count, shown: base, hidden: base + bytes, visible: base + 2 * bytes };
  }

  ids(address, count) {
    return this.u32.slice(address >> 2, (address >> 2) + count);
  }
}

const NONE = new Uint32Array(0);

/** That many ones. */
function packed(count) {
  const bytes = new Uint8Array(Math.ceil(count / 8)).fill(255);
  if (count % 8) bytes[bytes.length - 1] = (1 << count % 8) - 1;
  return bytes;
}

/** The answer to a question, live: it changes with the next one. Shared by views of files and of cull scenes. */
export class Answer {
  constructor(instance, functions, handle, objectCount) {
    this._instance = instance;
    this._functions = functions;
    this._handle = handle;
    this._lists = instance.makeLists(objectCount);
    this._ids = null;
    this._bits = null;
    this.objectCount = objectCount;
    this.changed = false;
    this.shown = NONE;
    this.hidden = NONE;
    this.count = objectCount;
    this.everything = true;
    this.hasBeenAsked = false;
    this.guarantee = "conservative";
  }

  /** After a question: reads what is different. */
  _same() {
    this.changed = false;
    this.shown = this.hidden = NONE;
  }

  _differences() {
    const { _instance: instance, _lists: lists } = this;
    const counts = instance.scratch;
    instance.call(this._functions.changes, this._handle, lists.shown, lists.count, counts, lists.hidden, lists.count, counts + 4);
    const shown = instance.view.getUint32(counts, true);
    const hidden = instance.view.getUint32(counts + 4, true);
    this.shown = shown ? instance.ids(lists.shown, shown) : NONE;
    this.hidden = hidden ? instance.ids(lists.hidden, hidden) : NONE;
    this.changed = shown + hidden > 0;
    this.hasBeenAsked = true;
    this._ids = this._bits = null;
  }

  get ids() {
    if (this._ids) return this._ids;
    if (!this.hasBeenAsked) return Uint32Array.from({ length: this.objectCount }, (_, id) => id);
    const { _instance: instance, _lists: lists } = this;
    instance.call(this._functions.ids, this._handle, lists.visible, lists.count, instance.scratch);
    return (this._ids = instance.ids(lists.visible, instance.view.getUint32(instance.scratch, true)));
  }

  get bits() {
    if (this._bits) return this._bits;
    if (!this.hasBeenAsked) return packed(this.objectCount);
    const { _instance: instance, _lists: lists } = this;
    instance.call(this._functions.bits, this._handle, lists.visible, lists.count * 4, instance.scratch);
    const bytes = instance.view.getUint32(instance.scratch, true);
    return (this._bits = instance.u8.slice(lists.visible, lists.visible + bytes));
  }

  sees(object) {
    return ((this.bits[object >> 3] >> (object & 7)) & 1) === 1;
  }
}
