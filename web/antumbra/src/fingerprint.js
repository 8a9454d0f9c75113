// The objects of a glTF document as the baker lists them, from its JSON alone, and their fingerprint (docs/format.md, 5):
// how a page notices that the scene has changed since it was baked.
const TRIANGLES = 4, MASK = 0xffffffff;

function isIgnored(...holders) {
  return holders.some((holder) => {
    const extras = holder?.extras;
    if (typeof extras !== "object" || extras === null) return false;
    return extras.antumbra?.ignore === true || extras.antumbra_ignore === true;
  });
}

function trianglesOf(json, primitive) {
  const accessor = json.accessors[primitive.indices ?? primitive.attributes.POSITION];
  const corners = accessor.count, mode = primitive.mode ?? TRIANGLES;
  return mode === TRIANGLES ? Math.floor(corners / 3) : Math.max(corners - 2, 0);
}

/** Nodes of the shown scene, ascending, with whether they or an ancestor are to be ignored. */
function shownNodes(json) {
  const scene = json.scenes?.[json.scene ?? 0];
  const children = new Set((json.nodes ?? []).flatMap((node) => node.children ?? []));
  const roots = scene ? (scene.nodes ?? []) : (json.nodes ?? []).map((_, n) => n).filter((n) => !children.has(n));
  const found = [];
  const todo = roots.map((node) => ({ node, ignored: false }));
  while (todo.length) {
    const { node, ignored } = todo.pop();
    const own = ignored || isIgnored(json.nodes[node]);
    found.push({ node, ignored: own });
    for (const child of json.nodes[node].children ?? []) todo.push({ node: child, ignored: own });
  }
  return found.sort((a, b) => a.node - b.node);
}

function instancesOf(json, node) {
  const attributes = node.extensions?.EXT_mesh_gpu_instancing?.attributes;
  if (!attributes) return null;
  const accessor = attributes.TRANSLATION ?? attributes.ROTATION ?? attributes.SCALE;
  return accessor === undefined ? 0 : json.accessors[accessor].count;
}

/** Calls use(node, primitive, instance, triangles) for every object, in order. */
export function forEachObject(json, use) {
  for (const { node: n, ignored } of shownNodes(json)) {
    const node = json.nodes[n];
    if (node.mesh === undefined) continue;
    const mesh = json.meshes[node.mesh], instances = instancesOf(json, node);
    mesh.primitives.forEach((primitive, p) => {
      if (ignored || isIgnored(mesh, json.materials?.[primitive.material])) return;
      if ((primitive.mode ?? TRIANGLES) < TRIANGLES || primitive.attributes?.POSITION === undefined) return;
      const triangles = trianglesOf(json, primitive);
      if (instances === null) use(n, p, -1, triangles);
      else for (let i = 0; i < instances; ++i) use(n, p, i, triangles);
    });
  }
}

/** FNV-1a in 64 bits, in two halves: the prime is 2^40 + 0x1b3. */
export function structureFingerprint(json) {
  let high = 0xcbf29ce4, low = 0x84222325;
  const mixByte = (byte) => {
    low = (low ^ byte) >>> 0;
    const product = low * 0x1b3; // below 2^53
    high = (high * 0x1b3 + Math.floor(product / 0x100000000) + ((low << 8) >>> 0)) >>> 0; // below 2^53, too
    low = product >>> 0;
  };
  const mix = (value) => {
    const word = value & MASK;
    mixByte(word & 255);
    mixByte((word >>> 8) & 255);
    mixByte((word >>> 16) & 255);
    mixByte(word >>> 24);
  };
  forEachObject(json, (node, primitive, instance, triangles) => {
    mix(node);
    mix(primitive);
    mix(instance);
    mix(triangles);
  });
  return (BigInt(high) << 32n) | BigInt(low >>> 0);
}
