// The viewer in a real browser: node viewer_test.mjs PROGRAM SOURCE FOLDER_OF_THE_PAGE CHROMIUM
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import { pathToFileURL } from 'node:url';
import { comparePicture, drop, launch, made, messages, openPage, pagePath, program, run, serve, settle, source, stand, state } from './support.mjs';

const office = made('office.glb', (file) => run('generate', 'office', '--triangles', '6000', '-o', file));
const pvs = made('office.pvs', (file) => run('bake', office, '--cells', '8x2x4', '-o', file));
const other = made('apartment.glb', (file) => run('generate', 'apartment', '-o', file));
const page0 = pathToFileURL(pagePath).href;
const corridor = [[1.5, 1.7, 6.2], [9, 1.5, 6.2]];
const browser = await launch();
let failures = 0;
async function test(name, work) {
  const start = performance.now();
  try {
    await work();
    console.log(`ok      ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failures;
    console.log(`FAILED  ${name}\n${error.stack}`);
  }
}

/** One page from disk with the office in it. */
async function withOffice(options, work) {
  const opened = await openPage(browser, page0, options);
  await drop(opened.page, office, pvs);
  await opened.page.waitForFunction(() => window.antumbraViewer.bake && document.documentElement.dataset.ready);
  await work(opened.page);
  assert.deepEqual(opened.problems(), []);
  await opened.context.close();
}

await test('a page from disk takes a scene and its bake by drag and drop', () => withOffice({}, async (page) => {
  const { drawn, hidden, outOfView, method, methods } = await state(page);
  assert.deepEqual(methods, ['none', 'frustum', 'planes', 'masked', 'pvs']);
  assert.equal(method, 'pvs');
  assert.equal(drawn + hidden + outOfView, await page.evaluate(() => window.antumbraViewer.viewer.model.objects.length));
  assert.match(await page.locator('#facts').innerText(), /8 × 2 × 4 = 64/);
  assert.equal(await messages(page), '');
}));

await test('methods draw less, from the plainest on, and say the same as the program', () => withOffice({}, async (page) => {
  const counts = {};
  for (const method of ['none', 'frustum', 'planes', 'masked', 'pvs']) {
    await stand(page, ...corridor, method);
    counts[method] = (await state(page)).drawn;
    await page.waitForFunction(([name, text]) => document.querySelector(`#methods tr[data-method=${name}] td`).innerText === text, [method, counts[method].toLocaleString('en')]);
  }
  assert.equal(counts.none, await page.evaluate(() => window.antumbraViewer.viewer.model.objects.length));
  assert.ok(counts.frustum < counts.none && counts.planes <= counts.frustum && counts.masked < counts.frustum && counts.pvs < counts.frustum,
    JSON.stringify(counts));
  const { fov, aspect, near, far } = await page.evaluate(() => window.antumbraViewer.viewer.camera);
  const view = ['--eye', corridor[0].join(), '--dir', corridor[1].map((x, k) => x - corridor[0][k]).join(), '--fov', fov, '--aspect', aspect, '--near', near, '--far', far];
  const asked = JSON.parse(spawnSync(program, ['cull', office, '--method', 'pvs', '--pvs', pvs, ...view.map(String), '--json'], { encoding: 'utf8' }).stdout);
  assert.equal(counts.pvs, asked.count);
}));

await test('pictures are the same, whichever conservative method culls', () => withOffice({ viewport: { width: 800, height: 300 } }, async (page) => {
  // The pixels of a method that differ from those with everything drawn; null: there is nothing to see.
  const differing = (method) => page.evaluate((name) => {
    const { viewer } = window.antumbraViewer, gl = viewer.renderer.getContext(), size = gl.drawingBufferWidth * gl.drawingBufferHeight;
    const pixels = (culler) => {
      viewer.method = viewer.methods.find((entry) => entry.name === culler);
      viewer.showHidden = viewer.showInk = false;
      viewer.recull();
      viewer.draw();
      const bytes = new Uint8Array(size * 4);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      return new Uint32Array(bytes.buffer);
    };
    const all = pixels('none'), some = pixels(name);
    return new Set(all).size < 6 ? null : all.reduce((sum, value, i) => sum + (value !== some[i] ? 1 : 0), 0);
  }, method);
  for (const [eye, target] of [corridor, [[5, 1.6, 6.3], [1, 1.5, 6.1]], [[3, 1.6, 6], [6, 1.4, 5]]])
    for (const method of ['frustum', 'planes', 'masked']) {
      await stand(page, eye, target, method);
      assert.equal(await differing(method), 0, `${method} from ${eye}`);
    }
}));

await test('keys walk, a drag turns, walls and floors are solid', () => withOffice({}, async (page) => {
  await stand(page, ...corridor);
  await page.locator('#walk').click();
  const before = await state(page);
  await page.locator('#picture').focus();
  await page.keyboard.down('w');
  await page.waitForTimeout(900);
  await page.keyboard.up('w');
  await settle(page);
  const after = await state(page);
  assert.ok(after.eye[0] > before.eye[0] + 0.5, `walked from ${before.eye} to ${after.eye}`);
  assert.ok(Math.abs(after.eye[1] - 1.65) < 0.1, `eye height ${after.eye[1]}`);
  await page.mouse.move(300, 250);
  await page.mouse.down();
  await page.mouse.move(420, 250, { steps: 4 });
  await page.mouse.up();
  assert.ok((await state(page)).yaw > after.yaw + 0.1);
  // Against the wall of the corridor, for longer than its width takes.
  await page.evaluate(() => { window.antumbraViewer.viewer.walker.yaw = 0; });
  await page.keyboard.down('Shift');
  await page.keyboard.down('w');
  await page.waitForTimeout(1500);
  await page.keyboard.up('w');
  await page.keyboard.up('Shift');
  const box = await page.evaluate(() => window.antumbraViewer.viewer.model.bounds);
  const { eye } = await state(page);
  assert.ok(eye[2] > box.min.z && eye[0] > box.min.x && eye[0] < box.max.x, `walked through a wall to ${eye}`);
}));

await test('frozen culling stays while the camera moves on', () => withOffice({}, async (page) => {
  await stand(page, ...corridor, 'pvs');
  const before = await state(page);
  await page.keyboard.press('f');
  await page.keyboard.press('o');
  await settle(page);
  const outside = await state(page);
  assert.ok(outside.frozen && outside.eye[1] > 5);
  assert.deepEqual([outside.drawn, outside.hidden], [before.drawn, before.hidden]);
  assert.ok(outside.hidden > 50);
  assert.match(await page.locator('#banner').innerText(), /frozen/);
  await page.locator('#cells').selectOption('level');
  await settle(page);
  assert.ok(await page.locator('#legend').isVisible());
  await page.evaluate(() => new Promise((resolve) => setTimeout(resolve, 400))); // edges take the place of boxes
  await settle(page);
  await page.evaluate(() => document.getElementById('keys').remove());
  comparePicture('outside', await page.locator('#stage').screenshot());
  await page.keyboard.press('f');
  await settle(page);
  const thawed = await state(page);
  assert.ok(!thawed.frozen && thawed.drawn !== before.drawn);
}));

await test('a click tells what is there; without a server by rays that are called what they are', () => withOffice({}, async (page) => {
  await stand(page, ...corridor, 'pvs');
  await page.mouse.click(320, 270);
  await page.waitForSelector('#chosen:not([hidden]) .why');
  const text = await page.locator('#chosen').innerText();
  assert.match(text, /drawn/);
  assert.match(text, /a hint, not a proof/);
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('#chosen').isHidden());
}));

await test('two methods side by side', () => withOffice({}, async (page) => {
  await stand(page, ...corridor, 'pvs');
  await page.keyboard.press('c');
  await settle(page);
  await page.waitForFunction(() => /objects[^]*objects/.test(document.getElementById('halves').innerText));
  const halves = await page.locator('#halves .half').allInnerTexts();
  assert.match(halves[0], /^pvs\n/);
  assert.match(halves[1], /^frustum\n/);
  await page.waitForFunction((drawn) => Number(document.getElementById('drawn').innerText) === drawn, (await state(page)).drawn);
  const numbers = halves.map((text) => Number(text.match(/([\d,]+) objects/)[1].replace(',', '')));
  assert.ok(numbers[0] < numbers[1], halves.join(' | '));
  await page.locator('#second').selectOption('masked');
  await page.waitForFunction(() => document.querySelector('#halves').innerText.includes('masked'));
}));

await test('damaged and foreign files give one clear line, and what was there stays', () => withOffice({}, async (page) => {
  const before = (await state(page)).drawn;
  const bytes = readFileSync(pvs), flipped = Buffer.from(bytes);
  flipped[flipped.length >> 1] ^= 1;
  for (const [name, content, pattern] of [
    ['flipped.pvs', flipped, /flipped\.pvs: .*(damaged|checksum|corrupt)/i], ['short.pvs', bytes.subarray(0, 100), /short\.pvs: /], ['empty.pvs', Buffer.alloc(0), /empty\.pvs: /],
    ['short.glb', readFileSync(office).subarray(0, 5000), /short\.glb: the file is cut short/], ['text.glb', Buffer.from('hello'), /text\.glb: .*damaged/],
    ['wrong.gltf', Buffer.from('{"asset":{"version":"2.0"},"meshes":3}'), /wrong\.gltf: /], ['picture.tiff', Buffer.from('II'), /picture\.tiff: neither a scene/],
  ]) {
    const file = made(name, (place) => writeFileSync(place, content));
    await page.evaluate(() => document.getElementById('messages').replaceChildren());
    await drop(page, file);
    await page.waitForSelector('#messages > div');
    assert.match(await messages(page), pattern);
  }
  await page.evaluate(() => document.getElementById('messages').replaceChildren());
  await settle(page);
  assert.equal((await state(page)).drawn, before);
  await drop(page, other);
  await page.waitForFunction(() => window.antumbraViewer.viewer.model.name === 'apartment.glb');
  await drop(page, pvs);
  await page.waitForSelector('#messages > div');
  assert.match(await messages(page), /office\.pvs: baked from another scene than apartment\.glb/);
  assert.ok(!(await state(page)).methods.includes('pvs'));
}));

await test('compressed and instanced scenes open, too', async () => {
  const tool = (name) => `${source}/tools/gltf/node_modules/.bin/${name}`;
  const packed = made('meshopt.glb', (file) => spawnSync(tool('gltfpack'), ['-i', other, '-o', file, '-cc', '-kn', '-noq']));
  const draco = made('draco.glb', (file) => spawnSync(tool('gltf-transform'), ['draco', other, file]));
  const opened = await openPage(browser, page0);
  for (const file of [packed, draco]) {
    await drop(opened.page, file);
    await opened.page.waitForFunction((name) => window.antumbraViewer.viewer.model?.name === name, file.split('/').pop());
    assert.ok(await opened.page.evaluate(() => window.antumbraViewer.viewer.model.triangles) > 2500);
  }
  assert.deepEqual(opened.problems(), []);
  await opened.context.close();
});

await test('light, dark, and a switch between them', () => withOffice({ colorScheme: 'dark' }, async (page) => {
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  assert.equal(await theme(), 'dark');
  await stand(page, ...corridor, 'pvs');
  await page.evaluate(() => document.getElementById('keys').remove());
  comparePicture('dark', await page.locator('#stage').screenshot());
  await page.emulateMedia({ colorScheme: 'light' });
  await page.waitForFunction(() => document.documentElement.dataset.theme === 'light');
  await settle(page);
  comparePicture('light', await page.locator('#stage').screenshot());
  await page.locator('#theme').click();
  assert.equal(await theme(), 'dark');
}));

await test('a phone: the stick walks, a finger turns, the sheet opens', () => withOffice({ viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true }, async (page) => {
  assert.ok(await page.locator('#stick').isVisible());
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await stand(page, ...corridor, 'pvs');
  const before = await state(page), box = await page.locator('#stick').boundingBox();
  const touch = (type, x, y) => page.evaluate(([kind, cx, cy]) => document.getElementById('stick').dispatchEvent(
    new PointerEvent(kind, { pointerId: 1, pointerType: 'touch', isPrimary: true, clientX: cx, clientY: cy, bubbles: true })), [type, x, y]);
  await page.evaluate(() => { document.getElementById('stick').setPointerCapture = () => {}; });
  await touch('pointerdown', box.x + box.width / 2, box.y + 5);
  await page.waitForTimeout(600);
  await touch('pointerup', box.x + box.width / 2, box.y + 5);
  await settle(page);
  assert.ok((await state(page)).eye[0] > before.eye[0] + 0.3);
  await stand(page, ...corridor, 'pvs');
  comparePicture('phone', await page.locator('#stage').screenshot());
  await page.touchscreen.tap(330, 350);
  await page.waitForSelector('#chosen:not([hidden]) .why');
  await page.locator('#chosen').waitFor(); // the sheet has opened
  await page.locator('#grip').tap();
  assert.ok(await page.locator('#chosen').isHidden());
  await page.locator('#grip').tap();
  assert.ok(await page.locator('#methods').isVisible());
  await page.locator('#methods tr[data-method=none] label').tap();
  await page.waitForFunction(() => window.antumbraViewer.viewer.method.name === 'none');
}));

await test('the picture can be saved', () => withOffice({}, async (page) => {
  const [download] = await Promise.all([page.waitForEvent('download'), page.locator('#screenshot').click()]);
  assert.equal(download.suggestedFilename(), 'office-pvs.png');
  assert.equal(readFileSync(await download.path()).subarray(1, 4).toString(), 'PNG');
}));

await test('antumbra view serves the scene, a tour and proofs, and stops at Ctrl-C', async () => {
  const server = await serve(office, pvs);
  const opened = await openPage(browser, server.address), { page } = opened;
  await page.waitForSelector('#tour:not([hidden])');
  await stand(page, ...corridor, 'pvs');
  await page.mouse.click(320, 270);
  await page.waitForSelector('#chosen .why.good');
  assert.match(await page.locator('#chosen').innerText(), /Visible from here: proved/);
  // A hidden object: the server proves it, and names what hides it.
  await page.evaluate(() => {
    const { viewer, chosen } = window.antumbraViewer;
    chosen.choose([viewer.model.objects.find(({ index, name }) => viewer.states.values[index] === 1 && /book/.test(name))]);
  });
  await page.waitForSelector('#chosen .why.bad', { timeout: 30_000 });
  assert.match(await page.locator('#chosen').innerText(), /Hidden from here: proved/);
  assert.ok(await page.locator('#chosen .why.bad li').count() > 0);
  const eye = (await state(page)).eye;
  await page.keyboard.press('Escape');
  await page.keyboard.press('t');
  await page.waitForFunction((from) => Math.hypot(...window.antumbraViewer.viewer.camera.position.toArray().map((x, k) => x - from[k])) > 0.2, eye);
  assert.deepEqual(opened.problems(), []);
  await opened.context.close();
  const status = (where, host) => new Promise((resolve) => http.get(server.address + where, { headers: host ? { host } : {} }, (response) => resolve(response.resume().statusCode)));
  assert.equal(await status('api/scene'), 200);
  assert.equal(await status('api/scene', 'example.org'), 403);
  assert.equal(await status('scene/office.pvs'), 404);
  assert.equal(await status('scene/..%2f..%2fetc%2fpasswd'), 404);
  assert.equal(await status('api/explain?object=99999999&eye=0,0,0'), 400);
  assert.equal(await status('api/explain?object=1&eye=nowhere'), 400);
  const port = server.address.match(/:(\d+)/)[1];
  const busy = spawnSync(program, ['view', office, '--no-open', '--port', port], { encoding: 'utf8' });
  assert.equal(busy.status, 1);
  assert.match(busy.stderr, /port \d+ .*--port/);
  assert.equal(await server.stop(), 0);
  const stale = spawnSync(program, ['view', other, pvs, '--no-open'], { encoding: 'utf8' });
  assert.equal(stale.status, 1);
  assert.match(stale.stderr, /another scene/);
});

await test('a scene of 20,000 objects opens, and the page answers meanwhile', async () => {
  const town = made('town.glb', (file) => run('generate', 'town', '-o', file));
  const server = await serve(town);
  const context = await browser.newContext({ viewport: { width: 480, height: 300 } }), page = await context.newPage();
  await page.goto(server.address);
  let slowest = 0;
  while ((await page.evaluate(() => document.documentElement.dataset.scene)) !== 'yes') {
    const start = performance.now();
    await page.evaluate(() => new Promise((resolve) => setTimeout(resolve)));
    slowest = Math.max(slowest, performance.now() - start);
    await page.waitForTimeout(20);
  }
  assert.equal(await page.evaluate(() => window.antumbraViewer.viewer.model.objects.length), 20189);
  // About a second of work in one piece (three.js makes 20,000 meshes); more on a machine that does other things, too.
  assert.ok(slowest < 20_000, `the page did not answer for ${slowest.toFixed(0)} ms`);
  console.log(`        slowest answer ${slowest.toFixed(0)} ms`);
  await stand(page, [0, 1.7, 12], [30, 1.7, 30], 'masked');
  const { drawn, hidden } = await state(page);
  assert.ok(hidden > 1000 && drawn > 100, `masked draws ${drawn}, hides ${hidden}`);
  await context.close();
  await server.stop();
});

await test('the page has the colours of the report', () => {
  const colours = (file) => readFileSync(`${source}/${file}`, 'utf8').split('}').slice(0, 3).map((block) => Object.fromEntries([...block.matchAll(/(--[\w-]+): (#\w+)/g)].map((found) => found.slice(1))));
  const report = colours('src/evaluate/report/report.css'), viewer = colours('web/viewer/src/style.css');
  for (const [theme, mine] of viewer.slice(0, 2).entries()) {
    assert.ok(Object.keys(mine).length > 10);
    for (const [name, colour] of Object.entries(mine)) assert.equal(colour, report[theme][name], name);
  }
});

await browser.close();
process.exit(failures ? 1 : 0);
