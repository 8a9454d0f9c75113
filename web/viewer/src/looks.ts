// How the scene looks: light, and a quiet palette for scenes that bring no colours of their own.
import {
  Color, DirectionalLight, DoubleSide, Fog, FrontSide, Group, HemisphereLight, Material, MeshLambertMaterial,
  MeshStandardMaterial, Scene,
} from 'three';
import type { Model, SceneObject } from './model';

/** Colours by what a thing is called. First match wins; the palette is that of a cardboard model. */
const kinds: [RegExp, number][] = [
  [/leaf|leaves|tree|plant|bush|grass/, 0x8aa67c], [/pane|glass|window$/, 0x9fc3d4], [/tiles|roof/, 0xb9705a],
  [/ground|earth|terrain|street/, 0xc9c2ac], [/timber|beam|door|shutter|ladder|stairs|railing/, 0x8f7358],
  [/table|desk|bench|counter|shelf|board|chest|cupboard|wardrobe|pew|chair|stall|bed$/, 0xb39372],
  [/book/, 0x8d9fb0], [/barrel|jug|pot|kettle|box/, 0xa8805e], [/cloth|blanket|pillow|curtain/, 0xc7a6a0],
  [/floor|slab|step/, 0xd4cec0], [/wall|partition|chimney|tower|church|piece|stone|gate/, 0xe9e3d6], [/screen|keyboard|lamp/, 0x6f7884],
  [/visitor/, 0xb88f6c], [/metal|gear|roller|screw|shaft|spring/, 0xa3abb5],
];
/** For everything else: muted colours, picked by the name. */
const others = [0xc9b79c, 0x9fb3a8, 0xb7a6bd, 0xa9b8c9, 0xd0a992, 0xb9bf9a, 0x93a9b5, 0xc8b0b0];

export function colourOf(name: string): number {
  const words = name.toLowerCase().split('/');
  const last = words[words.length - 1].replace(/[\d.#-]+/g, ' ').trim();
  for (const [pattern, colour] of kinds) if (pattern.test(last)) return colour;
  let hash = 0;
  for (const letter of last || words[0]) hash = (Math.imul(hash, 31) + letter.charCodeAt(0)) | 0;
  return others[(hash >>> 0) % others.length];
}

export class Looks {
  private readonly lights = new Group();
  private readonly palette = new Map<string, MeshLambertMaterial>();
  private readonly sky = new HemisphereLight(0xffffff, 0xcfc8bb, 1.9);
  private readonly sun = new DirectionalLight(0xfff3e0, 2.1);
  private readonly fill = new DirectionalLight(0xdfe9ff, 0.7);

  constructor(private readonly scene: Scene) {
    this.sun.position.set(0.45, 1, 0.32);
    this.fill.position.set(-0.7, 0.25, -0.6);
    this.lights.add(this.sky, this.sun, this.fill);
    scene.add(this.lights);
  }

  /** Sky and mist in the colours of the page. */
  setTheme(dark: boolean, extent: number): void {
    const sky = new Color(dark ? 0x1b1f24 : 0xe6eaea);
    this.scene.background = sky;
    this.scene.fog = new Fog(sky, extent * 0.6, extent * 4);
    this.sky.intensity = dark ? 1.0 : 1.75;
    this.sun.intensity = dark ? 0.95 : 1.35;
    this.fill.intensity = dark ? 0.4 : 0.55;
  }

  /** The file's own materials, or the palette. */
  apply(model: Model, own: boolean): void {
    for (const object of model.objects) object.mesh.material = own ? object.ownMaterial : this.materialOf(object);
  }

  private materialOf(object: SceneObject): Material {
    const source = [object.ownMaterial].flat()[0] as MeshStandardMaterial;
    const colour = colourOf(object.name), both = source.side === DoubleSide;
    const flat = !object.mesh.geometry.attributes.normal;
    const key = `${colour}/${both}/${source.transparent}/${flat}`;
    let material = this.palette.get(key);
    if (!material) {
      material = new MeshLambertMaterial({
        color: colour, side: both ? DoubleSide : FrontSide, flatShading: flat, transparent: source.transparent,
        opacity: source.transparent ? 0.35 : 1, depthWrite: !source.transparent,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      });
      this.palette.set(key, material);
    }
    return material;
  }
}
