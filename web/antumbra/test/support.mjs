// What the tests share: the built program, the files that tests/web/make_files.sh makes, random numbers that repeat.
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";

const root = new URL("../../../", import.meta.url);
const path = (relative) => new URL(relative, root).pathname;

export const program = process.env.ANTUMBRA ?? path("build/release/antumbra");
export const peer = process.env.CULL_PEER ?? path("build/release/tests/web/cull_peer");
export const files = process.env.WEB_FILES ?? path("build/release/web-files");
export const modules = process.env.WEB_MODULES ?? path("build/release/bindings/wasm");
export const packageFolder = path("web/antumbra/");
export const bin = path("web/antumbra/bin/antumbra.js");

export const fileOf = (name) => `${files}/${name}`;
export const bytesOf = (name) => new Uint8Array(readFileSync(fileOf(name)));

export function run(command, args, options) {
  const done = spawnSync(command, args, { encoding: "utf8", maxBuffer: 1 << 28, ...options });
  if (done.error) throw done.error;
  return { code: done.status, out: done.stdout, err: done.stderr };
}

export function native(...args) {
  const { code, out, err } = run(program, args);
  if (code !== 0) throw new Error(`antumbra ${args.join(" ")}: ${err}`);
  return JSON.parse(out);
}

/** Numbers from [0, 1), the same in every run (mulberry32). */
export function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

export function randomPoint(random, min, max, margin = 0) {
  return min.map((least, k) => least - margin + random() * (max[k] - least + 2 * margin));
}

export function loadGltf(THREE, GLTFLoader, bytes) {
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new Promise((resolve, reject) => new GLTFLoader().parse(buffer, "", resolve, reject));
}
