// node frames.mjs SCENE.glb FILE.pvs [FRAMES]: frames in chromium (software GL) with three.js frustum culling alone, and with
// what the file says besides; every picture is compared. CSV on stdout: one line of totals. The file is to be exact.
import { dirname, basename, resolve } from "node:path";
import { launch, runPage, serve } from "../../web/antumbra/test/browser.mjs";
import { packageFolder } from "../../web/antumbra/test/support.mjs";

const [scene, file, frames = "300"] = process.argv.slice(2);
const imports = JSON.stringify({ imports: {
  three: "/package/node_modules/three/build/three.module.js",
  "three/addons/": "/package/node_modules/three/examples/jsm/",
  "antumbra/three": "/package/src/three.js",
} });
const page = `<!doctype html><script type="importmap">${imports}</script><body><script type="module" src="/package/test/pages/walk.js"></script>`;
const server = await serve({ "/walk.html": page }, {
  "/package/": packageFolder, "/scene/": dirname(resolve(scene)), "/file/": dirname(resolve(file)) });
const browser = await launch();
try {
  const question = { scene: `/scene/${basename(scene)}`, pvs: `/file/${basename(file)}`, frames: Number(frames), seed: 3 };
  const { result, said } = await runPage(browser, `${server.url}/walk.html`, question);
  if (said.length) throw new Error(said.join("\n"));
  const { rows, summary, objects, openMs } = result;
  const total = (key) => rows.reduce((sum, row) => sum + row[key], 0);
  const ratio = rows.map((row) => row.plainMs / row.culledMs).sort((a, b) => a - b);
  console.log("objects,frames,open_and_attach_ms,frustum_ms_median,culled_ms_median,ratio_of_totals,ratio_median,frustum_calls,culled_calls," +
    "frustum_triangles,culled_triangles,hidden_median,frames_outside,different_pixels");
  console.log([objects, rows.length, openMs.toFixed(1), summary.plainMs.toFixed(1), summary.culledMs.toFixed(1),
    (total("plainMs") / total("culledMs")).toFixed(2), ratio[Math.floor(ratio.length / 2)].toFixed(2), summary.plainCalls, summary.culledCalls,
    summary.plainTriangles, summary.culledTriangles, summary.hidden, rows.filter((row) => row.outside).length, total("different")].join());
} finally {
  await browser.close();
  server.close();
}
