// A stranger's way: the packed tarball, a fresh folder, the page of docs/web.md, Vite, a real browser with a strict policy.
import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { chromiumPath, launch, serve } from "./browser.mjs";
import { fileOf, packageFolder, run } from "./support.mjs";

const manual = readFileSync(`${packageFolder}../../docs/web.md`, "utf8");

/** The code of the manual that stands after `name`. */
function listing(name) {
  const at = manual.indexOf(`\`${name}\``);
  return manual.slice(at).match(/```\w+\n([\s\S]*?)```/)[1];
}

function npm(args, cwd) {
  const { code, out, err } = run("npm", [...args, "--no-audit", "--no-fund", "--offline"], { cwd });
  assert.equal(code, 0, err);
  return out;
}

test("the page of the manual, from the packed tarball", { skip: chromiumPath ? false : "there is no chromium" }, async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "antumbra-project-"));
  try {
    const tarball = npm(["pack", "--pack-destination", folder], packageFolder).trim().split("\n").pop();
    await t.test("the tarball holds what it needs and nothing else", () => {
      const { out } = run("tar", ["tzf", join(folder, tarball)]);
      const names = out.trim().split("\n").map((name) => name.replace("package/", ""));
      for (const name of ["package.json", "README.md", "LICENSE", "src/index.js", "src/three.js", "src/cull.js", "bin/antumbra.js",
                          "types/index.d.ts", "types/three.d.ts", "types/cull.d.ts", "generated/query.js", "generated/cull-simd.js",
                          "generated/cull-plain.js"])
        assert.ok(names.includes(name), name);
      assert.ok(names.every((name) => !/^(test|node_modules)\//.test(name)), names.join());
    });

    const project = join(folder, "town");
    mkdirSync(join(project, "public"), { recursive: true });
    writeFileSync(join(project, "package.json"), '{ "name": "town", "private": true, "type": "module" }');
    // From the disk, so that the test needs no network; three is where a registry would have put it.
    npm(["install", join(folder, tarball), `${packageFolder}node_modules/three`, `${packageFolder}node_modules/vite`], project);
    writeFileSync(join(project, "index.html"), listing("index.html"));
    writeFileSync(join(project, "main.js"), `${listing("main.js")}\nwindow.culling = culling;\n`);
    writeFileSync(join(project, "worker.js"), `import { open } from "antumbra";
      open(new URL("/town.pvs", self.location.origin)).then((pvs) => postMessage(pvs.query({ eye: [2, 2, 0] }).count));`);
    writeFileSync(join(project, "more.js"), `import { CullScene } from "antumbra/cull";
      new Worker(new URL("./worker.js", import.meta.url), { type: "module" }).onmessage = ({ data }) => (window.fromWorker = data);
      window.methods = (await CullScene.create({ bounds: [0, 0, 0, 1, 1, 1] })).methods;`);
    writeFileSync(join(project, "index.html"), `${listing("index.html")}<script type="module" src="./more.js"></script>`);
    copyFileSync(fileOf("town.glb"), join(project, "public/town.glb"));
    copyFileSync(fileOf("town.pvs"), join(project, "public/town.pvs"));
    await t.test("Vite builds it without any setting", () => {
      const { code, out, err } = run(process.execPath, [`${packageFolder}node_modules/vite/bin/vite.js`, "build"], { cwd: project });
      assert.equal(code, 0, err + out);
    });
    await t.test("npx finds the command", () => {
      const { code, out } = run("npx", ["--no-install", "antumbra", "info", "public/town.pvs"], { cwd: project });
      assert.equal(code, 0);
      assert.match(out, /objects {6}749/);
    });
    const dist = join(project, "dist");
    const headers = { "content-security-policy": "default-src 'self' blob: data:; style-src 'unsafe-inline'; script-src 'self' 'wasm-unsafe-eval'" };
    const server = await serve({ "/": { body: readFileSync(join(dist, "index.html")), headers } }, { "/": dist });
    const browser = await launch();
    try {
      await t.test("it runs in a browser under a strict policy, and hides", async () => {
        const page = await browser.newPage({ viewport: { width: 320, height: 240 } });
        const said = [];
        page.on("console", (message) => message.type() === "error" && said.push(message.text()));
        page.on("pageerror", (error) => said.push(String(error)));
        await page.goto(server.url);
        await page.waitForFunction(() => window.culling?.hidden > 0 && window.fromWorker && window.methods, null, { timeout: 60000 });
        const { hidden, unmatched, fromWorker, methods, title } = await page.evaluate(() => ({
          hidden: culling.hidden, unmatched: culling.unmatched, fromWorker: window.fromWorker, methods: window.methods, title: document.title }));
        assert.deepEqual(said, []);
        assert.equal(unmatched, 0);
        assert.ok(hidden > 100 && fromWorker > 100, `${hidden} ${fromWorker}`);
        assert.ok(methods.includes("masked"));
        assert.match(title, /^\d+ of 749 hidden, \d+ calls$/);
      });
    } finally {
      await browser.close();
      server.close();
    }
    t.diagnostic(`dist: ${readdirSync(join(dist, "assets")).join(" ")}`);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});
