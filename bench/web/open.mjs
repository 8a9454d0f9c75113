// node open.mjs FILE.pvs..: how long a file takes to be opened (the module compiled before), and to be asked. CSV on stdout.
import { readFileSync } from "node:fs";
import { open } from "../../web/antumbra/src/index.js";
import { randomNumbers, randomPoint } from "../../web/antumbra/test/support.mjs";

const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
console.log("file_bytes,objects,open_ms,new_cell_us,same_cell_us,visible_mean");
for (const file of process.argv.slice(2)) {
  const bytes = readFileSync(file), times = [];
  for (let i = 0; i < 15; ++i) {
    const begin = performance.now();
    (await open(bytes)).dispose();
    times.push(performance.now() - begin);
  }
  const pvs = await open(bytes), { grid } = pvs.info, random = randomNumbers(1);
  let visible = 0;
  const eyes = Array.from({ length: 5000 }, () => randomPoint(random, grid.min, grid.max));
  let begin = performance.now();
  for (const eye of eyes) visible += pvs.query({ eye }).count;
  const fresh = ((performance.now() - begin) / eyes.length) * 1000;
  begin = performance.now();
  for (let i = 0; i < 100000; ++i) pvs.query({ eye: eyes[0] });
  const same = (performance.now() - begin) / 100;
  console.log([bytes.length, pvs.info.objectCount, median(times).toFixed(2), fresh.toFixed(2), same.toFixed(3), (visible / eyes.length).toFixed(1)].join());
}
