// The package in a real browser (software GL): not one pixel may be missing, with shadows, too; workers; a strict
// Content-Security-Policy; damaged files.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { chromiumPath, launch, runPage, serve } from "./browser.mjs";
import { bytesOf, files, packageFolder } from "./support.mjs";

const IMPORTS = JSON.stringify({
  imports: {
    three: "/package/node_modules/three/build/three.module.js",
    "three/addons/": "/package/node_modules/three/examples/jsm/",
    antumbra: "/package/src/index.js",
    "antumbra/cull": "/package/src/cull.js",
    "antumbra/three": "/package/src/three.js",
  },
});
const walkPage = `<!doctype html><script type="importmap">${IMPORTS}</script>
<body><script type="module" src="/package/test/pages/walk.js"></script>`;
const openScript = `import { open } from "/package/src/index.js";
  import { CullScene } from "/package/src/cull.js";
  window.run = async (url) => {
    try {
      const pvs = await open(url);
      const scene = await CullScene.fromPvs(pvs);
      const culled = scene.createCuller("pvs").cull({ eye: [2, 2, 0], target: [0, 2, 0] }).count;
      return { count: pvs.query({ eye: [2, 2, 0] }).count, culled };
    } catch (error) { return { code: error.code, message: error.message }; }
  };`;
const workerScript = `import { open } from "/package/src/index.js";
  import { CullScene } from "/package/src/cull.js";
  const pvs = await open("/files/square.pvs");
  const scene = await CullScene.fromPvs(pvs);
  postMessage([pvs.query({ eye: [2, 2, 0] }).count, scene.createCuller("pvs").cull({ eye: [2, 2, 0], target: [0, 2, 0] }).count]);`;
const policy = (scripts) => ({ "content-security-policy": `default-src 'self'; script-src 'self' ${scripts}` });
const openPage = '<!doctype html><script type="module" src="/open.js"></script>';

const PAGES = {
  "/walk.html": walkPage,
  "/open.html": { body: openPage, headers: policy("'wasm-unsafe-eval'") },
  "/strict.html": { body: openPage, headers: policy("") },
  "/open.js": openScript,
  "/worker.js": workerScript,
  "/worker.html": `<!doctype html><script>window.run = () => new Promise((resolve, reject) => {
    const worker = new Worker("/worker.js", { type: "module" });
    worker.onmessage = ({ data }) => resolve(data);
    worker.onerror = reject;
  });</script>`,
  "/damaged.pvs": { body: Buffer.from(bytesOf("square.pvs").map((byte, i) => (i === 40000 ? byte ^ 1 : byte))), type: "x/y" },
};

test("in a browser", { skip: chromiumPath ? false : "there is no chromium" }, async (t) => {
  const server = await serve(PAGES, { "/package/": packageFolder, "/files/": files });
  const browser = await launch();
  const town = { scene: "/files/town.glb", pvs: "/files/square.pvs" };
  try {
    await t.test("ten random frames: every pixel is that of drawing everything, with fewer calls", async () => {
      const { result, said } = await runPage(browser, `${server.url}/walk.html`, { ...town, frames: 10 });
      assert.deepEqual(said, []);
      assert.equal(result.rows.length, 10);
      for (const row of result.rows) {
        assert.equal(row.different, 0, JSON.stringify(row));
        assert.ok(!row.outside && row.hidden > 100 && row.culledCalls <= row.plainCalls && row.culledCalls > 5);
      }
      const { summary } = result;
      assert.ok(summary.culledCalls < summary.plainCalls, JSON.stringify(summary));
      t.diagnostic(JSON.stringify(summary));
    });
    await t.test("shadows of what is hidden stay", async () => {
      const { result, said } = await runPage(browser, `${server.url}/walk.html`, { ...town, frames: 3, shadows: true, seed: 2 });
      assert.deepEqual(said, []);
      for (const row of result.rows) assert.ok(row.different === 0 && row.hidden > 100, JSON.stringify(row));
    });
    await t.test("under a Content-Security-Policy with wasm-unsafe-eval", async () => {
      const { result, said } = await runPage(browser, `${server.url}/open.html`, "/files/square.pvs");
      assert.deepEqual(said, []);
      assert.ok(result.count > 200 && result.culled > 10 && result.culled < result.count, JSON.stringify(result));
    });
    await t.test("without it the error names the cure", async () => {
      const { result } = await runPage(browser, `${server.url}/strict.html`, "/files/square.pvs");
      assert.equal(result.code, "unsupported");
      assert.match(result.message, /wasm-unsafe-eval/);
    });
    await t.test("in a worker", async () => {
      const { result, said } = await runPage(browser, `${server.url}/worker.html`);
      assert.deepEqual(said, []);
      assert.ok(result[0] > 200 && result[1] > 10 && result[1] < result[0], JSON.stringify(result));
    });
    await t.test("damaged and missing files give clear errors", async () => {
      const damaged = await runPage(browser, `${server.url}/open.html`, "/damaged.pvs");
      assert.equal(damaged.result.code, "corrupt");
      assert.match(damaged.result.message, /damaged\.pvs: chunk '[A-Z]+'/);
      const missing = await runPage(browser, `${server.url}/open.html`, "/missing.pvs");
      assert.equal(missing.result.code, "io");
      assert.match(missing.result.message, /missing\.pvs: .*404/);
    });
  } finally {
    await browser.close();
    server.close();
  }
});
