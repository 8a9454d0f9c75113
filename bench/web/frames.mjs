// node frames.mjs SCENE.glb FILE.pvs [FRAMES [OPTIONS]]: frames in chromium (software GL) with three.js frustum culling alone,
// and with what the file (exact, else it means little) says besides. Every pair of pictures is compared; for each pixel that
// differs `antumbra explain` is asked about the object that is only in the full picture: if it is proved hidden from the
// eye and from its whole cell, the rasteriser was wrong (it extrapolates depth over slivers), else the object is missing.
// CSV on stdout: one line of totals. OPTIONS: JSON for test/pages/walk.js, e.g. {"seed":4}.
import { basename, dirname, resolve } from "node:path";
import { launch, runPage, serve } from "../../web/antumbra/test/browser.mjs";
import { packageFolder, program, run } from "../../web/antumbra/test/support.mjs";

const [scene, file, frames = "300", more = "{}"] = process.argv.slice(2);
const imports = JSON.stringify({ imports: {
  three: "/package/node_modules/three/build/three.module.js",
  "three/addons/": "/package/node_modules/three/examples/jsm/",
  "antumbra/three": "/package/src/three.js",
} });
const page = `<!doctype html><script type="importmap">${imports}</script><body><script type="module" src="/package/test/pages/walk.js"></script>`;

/** Is the object proved hidden, whatever the picture shows? */
function isProvedHidden(eye, node) {
  if (node < 0) return false;
  const { code, out } = run(program, ["explain", scene, file, `--eye=${eye.join()}`, "--object", String(node), "--json"]);
  if (code !== 0) return false;
  const { object, from_eye, from_cell } = JSON.parse(out);
  return object.node === node && from_eye.answer === "hidden" && from_cell.answer === "hidden";
}

function judge(rows) {
  const counts = { different: 0, rasteriser: 0, missing: 0 };
  for (const { different, list, eye, frame } of rows) {
    counts.different += different;
    const hidden = new Map(), nodes = new Set(list.map(({ all }) => all));
    for (const node of nodes) hidden.set(node, isProvedHidden(eye, node));
    const proved = list.filter(({ all }) => hidden.get(all)).length;
    counts.rasteriser += proved;
    counts.missing += different - proved; // also those beyond the list
    if (different > proved) console.error(`frame ${frame}, eye ${eye}: ${JSON.stringify(list)}`);
  }
  return counts;
}

const server = await serve({ "/walk.html": page }, {
  "/package/": packageFolder, "/scene/": dirname(resolve(scene)), "/file/": dirname(resolve(file)) });
const browser = await launch();
try {
  const question = { scene: `/scene/${basename(scene)}`, pvs: `/file/${basename(file)}`, frames: Number(frames), seed: 3, flat: true,
                     ...JSON.parse(more) };
  const { result, said } = await runPage(browser, `${server.url}/walk.html`, question);
  const complaints = said.filter((text) => !text.includes("GPU stall due to ReadPixels"));
  if (complaints.length) throw new Error(complaints.join("\n"));
  const { rows, summary, objects, openMs } = result;
  const total = (key) => rows.reduce((sum, row) => sum + row[key], 0);
  const ratio = rows.map((row) => row.plainMs / row.culledMs).sort((a, b) => a - b);
  const { different, rasteriser, missing } = judge(rows.filter((row) => row.different));
  console.log("objects,frames,open_and_attach_ms,frustum_ms_median,culled_ms_median,ratio_of_totals,ratio_median,frustum_calls,culled_calls," +
    "frustum_triangles,culled_triangles,hidden_median,frames_outside,different_pixels,proved_rasteriser_errors,missing_pixels");
  console.log([objects, rows.length, openMs.toFixed(1), summary.plainMs.toFixed(1), summary.culledMs.toFixed(1),
    (total("plainMs") / total("culledMs")).toFixed(2), ratio[Math.floor(ratio.length / 2)].toFixed(2), summary.plainCalls, summary.culledCalls,
    summary.plainTriangles, summary.culledTriangles, summary.hidden, rows.filter((row) => row.outside).length, different, rasteriser,
    missing].join());
} finally {
  await browser.close();
  server.close();
}
