#!/usr/bin/env node
// What can be asked of a .pvs file without any native program: info, inspect, query. Keys and exit codes are those of the
// command line in C++.
import { statSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { AntumbraError, open, version } from "../src/index.js";

const HELP = `What can be seen from here? Asks .pvs files. Baking, walking and more: the native program \`antumbra\`.

usage: antumbra info FILE.pvs [--json]
       antumbra inspect FILE.pvs [--worst N] [--json]
       antumbra query FILE.pvs --eye X,Y,Z [--dir X,Y,Z [--up X,Y,Z] [--fov DEG] [--aspect A]] [--radius R] [--json]
       antumbra --version

example: antumbra query house.pvs --eye 1.5,1.7,-4
`;

const OPTIONS = {
  json: { type: "boolean" },
  help: { type: "boolean", short: "h" },
  version: { type: "boolean" },
  worst: { type: "string", default: "5" },
  eye: { type: "string" },
  dir: { type: "string" },
  up: { type: "string" },
  fov: { type: "string" },
  aspect: { type: "string" },
  radius: { type: "string" },
};

class UsageError extends Error {}

function number(text, name, least = -Infinity, greatest = Infinity) {
  const value = Number(text);
  if (text.trim() === "" || !Number.isFinite(value) || value < least || value > greatest)
    throw new UsageError(`--${name}: ${text} is no number` + (least > -Infinity ? ` from ${least} to ${greatest}` : ""));
  return value;
}

function vector(text, name) {
  const parts = text.split(",");
  if (parts.length !== 3) throw new UsageError(`--${name}: give three numbers, as in --${name}=1.5,1.7,-4`);
  return parts.map((part) => number(part, name));
}

const boxJson = ({ min, max }) => [min, max];
const boxText = ({ min, max }) => `(${min.join(", ")}) .. (${max.join(", ")})`;
const hex = (fingerprint) => fingerprint.toString(16).padStart(16, "0");

/** How many objects each cell sees. */
function census(pvs) {
  const cells = [];
  const counts = { baked: 0, solid: 0, "not-baked": 0 };
  const view = pvs.createView();
  for (let index = 0; index < pvs.info.cellCount; ++index) {
    const cell = pvs.cell(index);
    ++counts[cell.kind];
    if (cell.kind !== "baked") continue;
    const eye = cell.min.map((least, k) => (least + cell.max[k]) / 2);
    cells.push({ ...cell, visible: view.query({ eye }).count });
  }
  view.dispose();
  const sum = cells.reduce((total, cell) => total + cell.visible, 0);
  const worst = cells.slice().sort((a, b) => b.visible - a.visible || a.index - b.index);
  return { counts, worst, mean: cells.length ? sum / cells.length : 0 };
}

function basics({ info }) {
  return {
    tool_version: info.toolVersion,
    method: info.method,
    guarantee: info.guarantee,
    volumes: info.volumeCount,
    sides: info.doubleSided ? "both" : "material",
    scene_fingerprint: info.sceneFingerprint,
    structure_fingerprint: hex(info.structureFingerprint),
    options: info.options,
    objects: info.objectCount,
    bytes: info.fileBytes,
    visibility_bytes: info.visibilityBytes,
    ...(info.grid
      ? { grid: { count: info.grid.count, bounds: boxJson(info.grid) }, cells: info.cellCount }
      : { tree: { nodes: info.treeNodes } }),
  };
}

function basicText({ info }) {
  const cells = info.grid ? `${info.grid.count.join(" x ")} in ${boxText(info.grid)}` : `a view tree of ${info.treeNodes} nodes`;
  return `written by   Antumbra ${info.toolVersion}
method       ${info.method}
guarantee    ${info.guarantee}
scene        ${info.sceneFingerprint}, structure ${hex(info.structureFingerprint)}
objects      ${info.objectCount}
cells        ${cells}
bytes        ${info.fileBytes}, of which visibility ${info.visibilityBytes}
`;
}

const COMMANDS = {
  info(pvs, values) {
    return values.json ? basics(pvs) : basicText(pvs);
  },
  inspect(pvs, values) {
    const { counts, worst, mean } = census(pvs);
    const listed = worst.slice(0, number(values.worst, "worst", 0, 1e9));
    if (values.json)
      return {
        ...basics(pvs),
        cells_baked: counts.baked,
        cells_solid: counts.solid,
        cells_not_baked: counts["not-baked"],
        mean_visible: mean,
        worst: listed.map((cell) => ({ cell: cell.index, visible: cell.visible, box: boxJson(cell) })),
      };
    const lines = listed.map((cell) => `worst cell   ${cell.index} sees ${cell.visible} from ${boxText(cell)}\n`);
    return (
      basicText(pvs) +
      `             ${counts.baked} baked, ${counts.solid} solid, ${counts["not-baked"]} not baked\n` +
      `visible      ${mean.toFixed(1)} objects from a baked cell on average\n` +
      lines.join("")
    );
  },
  query(pvs, values) {
    if (values.eye === undefined) throw new UsageError("query needs --eye X,Y,Z");
    const question = { eye: vector(values.eye, "eye") };
    if (values.dir !== undefined) question.direction = vector(values.dir, "dir");
    if (values.up !== undefined) question.up = vector(values.up, "up");
    if (values.fov !== undefined) question.fov = number(values.fov, "fov", 0.001, 179);
    if (values.aspect !== undefined) question.aspect = number(values.aspect, "aspect", 0.001, 1000);
    if (values.radius !== undefined) question.radius = number(values.radius, "radius", 0, 1e30);
    const view = pvs.createView();
    const { guarantee, everything, count, ids, cell: found } = view.query(question);
    const clusters = visibleClusters(pvs, view, ids);
    const cell = found === -3 && pvs.info.grid ? pvs.cellAt(question.eye) : found;
    const objects = Array.from(ids, (id) => pvs.object(id));
    if (values.json)
      return {
        cell: cell < 0 ? null : cell,
        guarantee,
        everything,
        count,
        clusters,
        cluster_count: pvs.info.clusterCount,
        visible: objects.map(({ id, node, primitive, instance, name }) => ({ id, node, primitive, instance, name })),
      };
    const lines = objects.map(
      ({ id, node, primitive, instance, name }) =>
        `${String(id).padStart(8)}  node ${node} primitive ${primitive} instance ${instance}  ${name}\n`,
    );
    const listed = pvs.info.clusterCount === 0 ? "" : `clusters   ${clusters.length} of ${pvs.info.clusterCount}\n`;
    return (
      `cell       ${cell < 0 ? "none" : cell}\nguarantee  ${guarantee}\nvisible    ${count} of ${pvs.info.objectCount} objects\n` +
      listed +
      lines.join("")
    );
  },
};

/** The clusters that the view's last answer sees, of the objects `ids`. */
function visibleClusters(pvs, view, ids) {
  if (pvs.info.clusterCount === 0) return [];
  const clusters = Array.from(ids, (id) => Array.from(new Set(pvs.clustersOf(id)))).flat();
  return clusters.filter((cluster) => cluster !== 0xffffffff && view.seesCluster(cluster)).sort((a, b) => a - b);
}

/** "--eye -1,2,3" as "--eye=-1,2,3": a value may begin with a minus. */
function withValues(argv) {
  const joined = [];
  for (let i = 0; i < argv.length; ++i) {
    const takesValue = argv[i].startsWith("--") && OPTIONS[argv[i].slice(2)]?.type === "string" && i + 1 < argv.length;
    joined.push(takesValue ? `${argv[i]}=${argv[++i]}` : argv[i]);
  }
  return joined;
}

async function run(argv) {
  let values, positionals;
  try {
    ({ values, positionals } = parseArgs({ args: withValues(argv), options: OPTIONS, allowPositionals: true }));
  } catch (error) {
    throw new UsageError(error.message);
  }
  if (values.version) return `${version}\n`;
  if (values.help) return HELP;
  const [name, file, ...rest] = positionals;
  const command = Object.hasOwn(COMMANDS, name ?? "") ? COMMANDS[name] : undefined;
  if (!command) throw new UsageError(name ? `there is no command '${name}'` : "a command is needed");
  if (!file || rest.length) throw new UsageError(`${name} takes one .pvs file`);
  if (!statSync(file, { throwIfNoEntry: false })) throw new AntumbraError("io", `${file}: there is no such file`);
  let pvs;
  try {
    pvs = await open(pathToFileURL(file));
  } catch (error) {
    throw new AntumbraError(error.code, error.message.replace(String(pathToFileURL(file)), file));
  }
  const output = command(pvs, values);
  return typeof output === "string" ? output : JSON.stringify(output, null, 2) + "\n";
}

process.stdout.on("error", (error) => process.exit(error.code === "EPIPE" ? 0 : 1));
try {
  process.stdout.write(await run(process.argv.slice(2)));
} catch (error) {
  if (error instanceof UsageError) {
    process.stderr.write(`antumbra: ${error.message}\n\n${HELP}`);
    process.exitCode = 2;
  } else {
    process.stderr.write(`antumbra: ${error instanceof AntumbraError ? error.message : (error.stack ?? error)}\n`);
    process.exitCode = 1;
  }
}
