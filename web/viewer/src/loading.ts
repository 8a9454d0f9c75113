// Reading scenes: GLB and glTF, with Draco, meshopt and Basis decoders that the page carries itself.
import { LoadingManager, type WebGLRenderer } from 'three';
import { DRACO_GLTF_CONFIG, DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader, type GLTF } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

export interface SceneSource {
  name: string;
  bytes: ArrayBuffer;
  /** Files that the scene may refer to by relative address. */
  files?: Map<string, File>;
  /** Where relative addresses point otherwise. */
  folder?: string;
}

/** Addresses of a dropped scene's companions; released after loading. */
class LocalFiles {
  private readonly addresses: string[] = [];
  constructor(private readonly files: Map<string, File>) {}
  find(address: string): string {
    if (/^(data|blob):/.test(address)) return address;
    const path = decodeURIComponent(address).replace(/^\.\//, '');
    const file = this.files.get(path) ?? this.files.get(path.split('/').pop() ?? path);
    if (!file) return address;
    const made = URL.createObjectURL(file);
    this.addresses.push(made);
    return made;
  }
  release(): void { for (const address of this.addresses) URL.revokeObjectURL(address); }
}

/** Says in one sentence what is wrong with bytes that are no glTF; null if they may be one. */
function problemOf(source: SceneSource): string | null {
  const { bytes, name } = source;
  if (bytes.byteLength === 0) return 'the file is empty';
  const head = new DataView(bytes);
  if (bytes.byteLength >= 4 && head.getUint32(0, true) === 0x46546c67) {
    if (bytes.byteLength < 20) return 'the file is cut short';
    if (head.getUint32(4, true) !== 2) return `it is glTF version ${head.getUint32(4, true)}; only version 2 is read`;
    const promised = head.getUint32(8, true);
    if (promised > bytes.byteLength)
      return `the file is cut short: it promises ${promised} bytes and has ${bytes.byteLength}`;
    return null;
  }
  const first = new TextDecoder().decode(new Uint8Array(bytes, 0, Math.min(64, bytes.byteLength))).trimStart()[0];
  if (first === '{') return null;
  return /\.(glb|gltf)$/i.test(name)
    ? 'it is neither a GLB nor glTF text: the file is damaged'
    : `only .glb and .gltf are read here; convert it, or run: antumbra view ${name}`;
}

/** Reads a scene; every error names the file. */
export async function loadScene(source: SceneSource, renderer: WebGLRenderer): Promise<GLTF> {
  const problem = problemOf(source);
  if (problem) throw new Error(`${source.name}: ${problem}`);
  const manager = new LoadingManager();
  const files = new LocalFiles(source.files ?? new Map());
  manager.setURLModifier((address) => files.find(address));
  let missing = '';
  manager.onError = (address) => { missing ||= address; };
  const draco = new DRACOLoader(manager).setDecoderPath(DRACO_GLTF_CONFIG as never);
  const textures = new KTX2Loader(manager).detectSupport(renderer);
  const loader = new GLTFLoader(manager).setDRACOLoader(draco).setKTX2Loader(textures).setMeshoptDecoder(MeshoptDecoder);
  try {
    const gltf = await loader.parseAsync(source.bytes, source.folder ?? '');
    if (!gltf.scene) throw new Error('it holds no scene');
    return gltf;
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    throw new Error(`${source.name}: ` + (missing && !missing.startsWith('data:')
      ? `it refers to ${decodeURIComponent(missing.split('/').pop() ?? missing)}, which is not there; drop it together with the scene`
      : `cannot be read: ${reason.replace(/^THREE\.GLTFLoader: /, '')}`));
  } finally {
    files.release();
    draco.dispose();
    textures.dispose();
  }
}
