// What the tests of the viewer share: running the program, steering the page, comparing pictures.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

export const [program, source, builtPage, chromiumPath] = process.argv.slice(2);
const require = createRequire(path.join(source, 'web/viewer/package.json'));
const { chromium } = require('playwright-core');
const { PNG } = require('pngjs');

export const scratch = path.join(builtPage, '..', 'viewer_test');
mkdirSync(scratch, { recursive: true });
export const pagePath = path.join(builtPage, 'index.html');

export function run(...parts) {
  const { status, stderr } = spawnSync(program, parts, { encoding: 'utf8' });
  assert.equal(status, 0, `antumbra ${parts.join(' ')}: ${stderr}`);
}
/** A file of the scratch folder, made once per run of the tests. */
export function made(name, make) {
  const file = path.join(scratch, name);
  make(file);
  return file;
}

/** `antumbra view` with these arguments; resolves when it has printed its address. */
export async function serve(...parts) {
  const child = spawn(program, ['view', '--no-open', '--port', '0', ...parts]);
  process.on('exit', () => child.kill()); // also when a test has failed before it could stop it
  let text = '', errors = '';
  child.stderr.on('data', (data) => { errors += data; });
  const ended = new Promise((resolve) => child.on('exit', (code) => resolve(code)));
  const address = await new Promise((resolve, reject) => {
    child.stdout.on('data', (data) => {
      text += data;
      if (text.includes('\n')) resolve(text.trim());
    });
    void ended.then((code) => reject(new Error(`antumbra view ended with ${code}: ${errors}`)));
  });
  return { address, stop: async (signal = 'SIGINT') => { child.kill(signal); return await ended; } };
}

export const launch = () => chromium.launch({
  executablePath: chromiumPath, args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});

/** A fresh page; `problems` collects what it complains about. */
export async function openPage(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 560 }, colorScheme: 'light', reducedMotion: 'reduce', ...options });
  const page = await context.newPage(), problems = [];
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type())) problems.push(message.text()); });
  page.on('pageerror', (error) => problems.push(error.message));
  page.on('request', (request) => { if (!/^(data|blob|file|http:\/\/127\.0\.0\.1)/.test(request.url())) problems.push(`asks ${request.url()}`); });
  await page.goto(address);
  await page.waitForSelector('html[data-loaded=yes]', { timeout: 60_000 });
  // Drivers in software say that reading pixels is slow: it is, and it is what we measure.
  return { page, context, problems: () => problems.filter((text) => !/GPU stall due to ReadPixels|GroupMarkerNotSet/.test(text)) };
}

/** Drops files on the page, as a hand would. */
export async function drop(page, ...files) {
  const given = files.map((file) => ({ name: path.basename(file), bytes: readFileSync(file).toString('base64') }));
  await page.evaluate(async (list) => {
    delete document.documentElement.dataset.ready;
    const transfer = new DataTransfer();
    for (const { name, bytes } of list) {
      const blob = await (await fetch(`data:application/octet-stream;base64,${bytes}`)).blob();
      transfer.items.add(new File([blob], name));
    }
    dispatchEvent(new DragEvent('dragenter', { dataTransfer: transfer, cancelable: true }));
    dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
  }, given);
}

/** The state of the page in numbers. */
export const state = (page) => page.evaluate(() => {
  const { viewer } = window.antumbraViewer, values = viewer.states?.values ?? [];
  const count = (wanted) => values.reduce((sum, value) => sum + (value === wanted ? 1 : 0), 0);
  return { eye: viewer.camera.position.toArray(), yaw: viewer.walker.yaw, method: viewer.method?.name ?? null, drawn: count(2), hidden: count(1), outOfView: count(0),
    frozen: viewer.frozen !== null, methods: viewer.methods.map(({ name }) => name) };
});

let stands = 0;
/** Puts the camera somewhere and waits for the frame. */
export async function stand(page, eye, target, method) {
  await page.evaluate(([from, to, name, n]) => {
    location.hash = `eye=${from}&to=${to}` + (name ? `&method=${name}` : '') + `&n=${n}`;
  }, [eye, target, method, ++stands]);
  await page.waitForFunction(([from, name]) => {
    const { viewer } = window.antumbraViewer;
    return Math.hypot(...viewer.camera.position.toArray().map((x, k) => x - from[k])) < 1e-6 && (!name || viewer.method.name === name);
  }, [eye, method]);
  await settle(page);
}

/** Until the answer stands, it has been drawn, and the panel has caught up. */
export const settle = async (page) => {
  await page.evaluate(() => window.antumbraViewer.viewer.recull());
  await page.waitForFunction(() => window.antumbraViewer.viewer.settling === 0);
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve, 130)))));
};

export const messages = async (page) => (await page.locator('#messages > div span').allInnerTexts()).join('\n');

/** Means over blocks of 6 x 6 pixels: fonts and edges may differ a little from machine to machine, content may not. */
function blocks({ width, height, data }) {
  const across = Math.floor(width / 6), down = Math.floor(height / 6), means = new Float32Array(across * down * 3);
  for (let y = 0; y < down * 6; ++y)
    for (let x = 0; x < across * 6; ++x)
      for (let k = 0; k < 3; ++k)
        means[(Math.floor(y / 6) * across + Math.floor(x / 6)) * 3 + k] += data[(y * width + x) * 4 + k] / 36;
  return means;
}

/** Compares a picture with the one that was looked at and committed. ANTUMBRA_UPDATE_PICTURES=1 writes it instead. */
export function comparePicture(name, bytes) {
  const reference = path.join(source, 'tests/viewer/pictures', `${name}.png`);
  writeFileSync(path.join(scratch, `${name}.png`), bytes);
  if (process.env.ANTUMBRA_UPDATE_PICTURES) return writeFileSync(reference, bytes);
  assert.ok(existsSync(reference), `${reference} is missing; look at ${scratch}/${name}.png and copy it there`);
  const now = PNG.sync.read(bytes), then = PNG.sync.read(readFileSync(reference));
  assert.deepEqual([now.width, now.height], [then.width, then.height], name);
  const a = blocks(now), b = blocks(then);
  let sum = 0, far = 0;
  for (let i = 0; i < a.length; ++i) {
    const difference = Math.abs(a[i] - b[i]);
    sum += difference;
    if (difference > 40) ++far;
  }
  const mean = sum / a.length, share = far / a.length;
  assert.ok(mean < 3 && share < 0.01, `${name}: differs from tests/viewer/pictures/${name}.png by ${mean.toFixed(2)} on average, ` +
    `${(share * 100).toFixed(2)} % of the blocks much; look at ${scratch}/${name}.png`);
}
