// Draw calls, triangles and frame times of the viewer in chromium, with every method on the same frames of one path:
//   node bench/viewer.mjs build/release/antumbra SCENE.glb OUT.pvs [FRAMES] > bench/results/viewer.csv
// Medians over the frames; pixels_wrong is the total against drawing everything. Times are those of software GL on
// whatever machine this is: compare rows with each other.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [program, scene, pvs, frames = '24'] = process.argv.slice(2);
const require = createRequire(new URL('../web/viewer/package.json', import.meta.url));
const { chromium } = require('playwright-core');
const server = spawn(path.resolve(fileURLToPath(import.meta.url), '../..', program), ['view', scene, pvs, '--no-open', '--port', '0']);
const address = await new Promise((resolve) => server.stdout.once('data', (data) => resolve(String(data).trim())));
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 984, height: 360 } });
await page.goto(address);
await page.waitForSelector('html[data-loaded=yes]', { timeout: 300_000 });
const result = await page.evaluate(async (count) => {
  const { viewer } = window.antumbraViewer, gl = viewer.renderer.getContext();
  const { frames: all } = await (await fetch('api/path')).json();
  for (const method of viewer.methods) await method.prepare?.();
  viewer.showHidden = viewer.showInk = false;
  let report = null;
  viewer.onFrame = (left) => { report = left; };
  const size = gl.drawingBufferWidth * gl.drawingBufferHeight;
  const draw = (method) => {
    viewer.method = method;
    viewer.recull();
    viewer.draw();
    const bytes = new Uint8Array(size * 4);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return new Uint32Array(bytes.buffer);
  };
  const samples = Object.fromEntries(viewer.methods.map(({ name }) => [name, []]));
  for (let f = 0; f < count; ++f) {
    const { eye, target } = all[Math.floor((f + 0.5) * all.length / count)];
    viewer.walker.flying = true;
    viewer.walker.lookAt(viewer.camera.position.clone().fromArray(eye), viewer.camera.position.clone().fromArray(target));
    const truth = draw(viewer.methods[0]);
    // In turning order, the better of two: whatever else runs only ever adds time.
    for (let k = 0; k < viewer.methods.length; ++k) {
      const method = viewer.methods[(k + f) % viewer.methods.length];
      let best = null, wrong = 0;
      for (let repeat = 0; repeat < 2; ++repeat) {
        const pixels = draw(method);
        wrong = pixels.reduce((sum, value, i) => sum + (value !== truth[i] ? 1 : 0), 0);
        const now = { objects: report.answer.count, triangles: report.answer.triangles, calls: report.calls, cull: report.answer.cullMs, draw: report.drawMs };
        if (!best || now.draw + now.cull < best.draw + best.cull) best = now;
      }
      samples[method.name].push({ ...best, wrong });
    }
    await new Promise((resolve) => setTimeout(resolve));
  }
  return { samples, objects: viewer.model.objects.length, triangles: viewer.model.triangles, pixels: size };
}, Number(frames));
await browser.close();
server.kill('SIGINT');
const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
console.log('scene,objects,triangles,frames,pixels,method,draw_calls,triangles_drawn,cull_ms,draw_ms,speedup_over_frustum,pixels_wrong');
const total = (list) => median(list.map(({ cull, draw }) => cull + draw));
const frustum = total(result.samples.frustum);
for (const [name, list] of Object.entries(result.samples)) {
  const of = (key) => median(list.map((sample) => sample[key]));
  console.log([path.basename(scene), result.objects, result.triangles, frames, result.pixels * Number(frames), name, of('calls'), of('triangles'), of('cull').toFixed(3),
    of('draw').toFixed(1), (frustum / total(list)).toFixed(2), list.reduce((sum, { wrong }) => sum + wrong, 0)].join(','));
}
