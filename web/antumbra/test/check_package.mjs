// Before packing: is everything there that the build makes, and does the version agree with the library's?
import { existsSync, readFileSync } from "node:fs";

const here = new URL("../", import.meta.url);
for (const name of ["query", "cull-plain", "cull-simd"])
  if (!existsSync(new URL(`generated/${name}.js`, here))) {
    console.error(`generated/${name}.js is missing: build the target antumbra_wasm first (cmake --build build/release)`);
    process.exit(1);
  }
const { version } = JSON.parse(readFileSync(new URL("package.json", here)));
const { version: stated } = await import(new URL("src/index.js", here));
if (version !== stated) {
  console.error(`package.json says version ${version}, src/index.js ${stated}`);
  process.exit(1);
}
