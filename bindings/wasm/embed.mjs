// node embed.mjs MODULE.wasm OUT.js: a module as text that every bundler understands. Refuses a module that imports.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";

const [input, output] = process.argv.slice(2);
const bytes = readFileSync(input);
const imports = WebAssembly.Module.imports(new WebAssembly.Module(bytes));
if (imports.length > 0)
  throw new Error(`${input} imports ${imports.map((i) => `${i.module}.${i.name}`).join(", ")}; it must import nothing`);
mkdirSync(dirname(output), { recursive: true });
writeFileSync(output, `// Made by the build from src/.\nexport const wasm =\n  "${bytes.toString("base64")}";\n`);
