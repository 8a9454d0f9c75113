// Opens and asks .pvs files. From-point culling is in antumbra/cull, the three.js helper in antumbra/three.
import { wasm } from "../generated/query.js";
import { AntumbraError } from "./errors.js";
import { Pvs, PvsView } from "./pvs.js";
import { Instance, compile } from "./runtime.js";
import { readSource } from "./source.js";

export { AntumbraError, Pvs, PvsView };

/** Version of this package and of the library inside. */
export const version = "0.1.0";

let compiled = null;

export async function open(source, options) {
  const [module, { bytes, name }] = await Promise.all([(compiled ??= compile(wasm)), readSource(source, options)]);
  try {
    return new Pvs(new Instance(module), bytes);
  } catch (error) {
    if (error instanceof AntumbraError && name) throw new AntumbraError(error.code, `${name}: ${error.message}`, { cause: error.cause });
    throw error;
  }
}
