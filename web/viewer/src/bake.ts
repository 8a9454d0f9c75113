// A .pvs as the viewer needs it, read by the package `antumbra`.
import { Box3, Vector3 } from 'three';
import { open, type Pvs } from 'antumbra';
import { CullScene } from 'antumbra/cull';
import { structureFingerprint } from 'antumbra/three';
import type { Cell } from './cells';
import { occlusionMethods, PackageMethod, titleOf, type Method } from './culling';
import { plural, size, whole } from './dom';
import { breathe, type Model } from './model';

export interface Bake {
  name: string;
  guarantee: string;
  facts: [string, string][];
  cells: Cell[];
  /** `pvs`; and, where the file brings occluders (`antumbra prepare`), the methods that use them. */
  methods: Method[];
  /** Number in the file of an object of the model; -1: not in it. */
  idOf(index: number): number;
  /** Object of the model with that number in the file; -1: none. */
  indexOf(id: number): number;
  boxAt(eye: Vector3): Box3 | null;
  dispose(): void;
}

/** Above this, cells are not counted: the picture would be a fog of boxes. */
const mostCells = 40_000;

/** Opens a .pvs for a model. Refuses a damaged one and one of another scene; says which. `byOrder`: object i of the file is
 * object i of the model, as the server has checked. */
export async function openBake(name: string, bytes: ArrayBuffer, model: Model, byOrder: boolean): Promise<Bake> {
  let pvs: Pvs;
  try {
    pvs = await open(bytes);
  } catch (error) {
    throw new Error(`${name}: ${error instanceof Error ? error.message : error}`);
  }
  const { info } = pvs;
  const modelOf = byOrder ? Int32Array.from({ length: info.objectCount }, (_, i) => (i < model.objects.length ? i : -1)) : match(pvs, model);
  if (!byOrder && structureFingerprint(model.json) !== info.structureFingerprint) {
    pvs.dispose();
    throw new Error(`${name}: baked from another scene than ${model.name}, or from an older version of it; bake it again`);
  }
  const idOfModel = new Int32Array(model.objects.length).fill(-1);
  modelOf.forEach((index, id) => { if (index >= 0) idOfModel[index] = id; });
  const scene = await CullScene.fromPvs(pvs);
  const boxAt = (eye: Vector3): Box3 | null => {
    const cell = pvs.cellAt(eye.toArray());
    return cell < 0 ? null : boxOf(pvs.cell(cell));
  };
  const cellAt = (eye: Vector3): number | null => {
    const cell = pvs.cellAt(eye.toArray());
    return cell < 0 ? null : cell;
  };
  return {
    name, guarantee: info.guarantee, facts: factsOf(name, pvs, scene.occluderCount), cells: await countCells(pvs),
    methods: [
      ...(scene.occluderCount > 0 ? occlusionMethods : []).map((method) => new PackageMethod(method, titleOf(method), scene.createCuller(method), modelOf)),
      new PackageMethod('pvs', titleOf('pvs'), scene.createCuller('pvs'), modelOf, cellAt),
    ],
    idOf: (index) => idOfModel[index], indexOf: (id) => modelOf[id] ?? -1, boxAt,
    dispose: () => {
      scene.dispose();
      pvs.dispose();
    },
  };
}

const boxOf = ({ min, max }: { min: number[]; max: number[] }): Box3 => new Box3(new Vector3().fromArray(min), new Vector3().fromArray(max));

/** For each object of the file the model's object with the same node, primitive and instance. */
function match(pvs: Pvs, model: Model): Int32Array {
  const keyed = new Map(model.objects.map(({ node, primitive, instance, index }) => [`${node}/${primitive}/${instance}`, index]));
  const keys = pvs.keys(), found = new Int32Array(keys.length / 3);
  for (let id = 0; id < found.length; ++id)
    found[id] = keyed.get(`${keys[3 * id]}/${keys[3 * id + 1]}/${keys[3 * id + 2]}`) ?? -1;
  return found;
}

/** Of a grid, or of a view tree that splits space alone. */
async function countCells(pvs: Pvs): Promise<Cell[]> {
  if (Math.max(pvs.info.cellCount, pvs.info.treeNodes / 2) > mostCells) return [];
  const view = pvs.createView(), cells: Cell[] = [];
  let clock = performance.now();
  for (const number of pvs.cells()) {
    if (performance.now() - clock > 8) {
      await breathe();
      clock = performance.now();
    }
    const cell = pvs.cell(number), box = boxOf(cell), eye = box.getCenter(new Vector3()).toArray();
    if (!pvs.info.grid && pvs.cellAt(eye) !== number) continue; // of some directions alone
    const seen = cell.kind === 'baked' ? view.query({ eye }).count : cell.kind === 'solid' ? -2 : -1;
    cells.push({ box, seen });
  }
  view.dispose();
  return cells;
}

function factsOf(name: string, pvs: Pvs, occluders: number): [string, string][] {
  const { info } = pvs;
  const options = info.options as { holdout_rays_per_cell?: number; holdout_misses?: number; holdout_rays?: number };
  const facts: [string, string][] = [
    ['.pvs', `${name}, ${size(info.fileBytes)}`],
    ['baked by', `${info.method}, Antumbra ${info.toolVersion}`],
    ['promise', info.guarantee],
    ['cells', info.grid ? `${info.grid.count.join(' × ')} = ${whole(info.cellCount)}` : `a view tree of ${plural(info.treeNodes, 'node')}`],
    ['visibility', size(info.visibilityBytes)],
  ];
  if (occluders > 0) facts.push(['occluders', whole(occluders)]);
  if (options.holdout_rays)
    facts.push(['missed rays', `${whole(options.holdout_misses ?? 0)} of ${whole(options.holdout_rays)}`]);
  return facts;
}
