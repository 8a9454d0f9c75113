// How one object of a .pvs is shown and hidden in three.js, each in constant time.
import { Object3D } from "three";


/** A mesh of its own: it changes between the list of its parent's children and that of the hidden ones. It stays in the
 * scene, with its parent, so that whoever traverses the scene still finds it. */
export class MeshTarget {
  /** `at`: where it stands among the children of its parent. */
  constructor(object, at, culling) {
    this.object = object;
    this.at = at;
    this.hidden = culling._hidden.children;
    this.owner = culling._owner;
    this.owner.set(object, this);
    if (object.children.length > 0) this._moveChildrenOut();
  }

  /** Children must not vanish with their parent: they hang beside it from now on, at the same place. */
  _moveChildrenOut() {
    const { object } = this;
    const pivot = new Object3D();
    pivot.name = `${object.name} (children)`;
    pivot.matrixAutoUpdate = false;
    pivot.matrix = object.matrix;
    object.updateMatrix();
    pivot.children = object.children;
    for (const child of pivot.children) child.parent = pivot;
    object.children = [];
    object.parent.add(pivot);
    this.pivot = pivot;
  }

  show() {
    this._move(this.hidden, this.object.parent.children);
    this.object.matrixWorldNeedsUpdate = true;
  }

  hide() {
    this._move(this.object.parent.children, this.hidden);
  }

  _move(from, to) {
    const { object } = this;
    let at = this.at;
    if (from[at] !== object) at = from.indexOf(object); // somebody else has changed the list
    if (at < 0) return; // taken out of the scene: none of our business
    const last = from.pop();
    if (last !== object) {
      from[at] = last;
      const target = this.owner.get(last);
      if (target) target.at = at;
    }
    this.at = to.length;
    to.push(object);
  }

  release() {
    if (!this.pivot) return;
    this.object.children = this.pivot.children;
    for (const child of this.object.children) child.parent = this.object;
    this.pivot.removeFromParent();
  }
}

/** The instances of an InstancedMesh: visible ones come first, and `count` says how many they are. */
export class InstancedTargets {
  constructor(mesh, at, culling) {
    this.mesh = mesh;
    this.total = this.visible = mesh.count;
    this.slotOf = Uint32Array.from({ length: this.total }, (_, i) => i); // instance to slot
    this.instanceAt = this.slotOf.slice();
    this.whole = new MeshTarget(mesh, at, culling);
    mesh.computeBoundingSphere();
    mesh.computeBoundingBox();
    this._wrap(culling);
  }

  /** Only the main camera gets less than all instances. */
  _wrap(culling) {
    const { mesh } = this;
    this.saved = { render: mesh.onBeforeRender, before: mesh.onBeforeShadow, after: mesh.onAfterShadow };
    const { saved } = this;
    mesh.onBeforeRender = (renderer, scene, camera, ...rest) => {
      mesh.count = camera === culling.camera ? this.visible : this.total;
      saved.render.call(mesh, renderer, scene, camera, ...rest);
    };
    mesh.onBeforeShadow = (...rest) => {
      mesh.count = this.total;
      saved.before.call(mesh, ...rest);
    };
    mesh.onAfterShadow = (...rest) => {
      saved.after.call(mesh, ...rest);
      mesh.count = this.visible;
    };
  }

  target(instance) {
    return { show: () => this.show(instance), hide: () => this.hide(instance), release: () => {} };
  }

  show(instance) {
    if (this.visible === 0) this.whole.show();
    this._swap(this.slotOf[instance], this.visible++);
    this.mesh.count = this.visible;
  }

  hide(instance) {
    this._swap(this.slotOf[instance], --this.visible);
    this.mesh.count = this.visible;
    if (this.visible === 0) this.whole.hide();
  }

  _swap(a, b) {
    if (a === b) return;
    swapItems(this.mesh.instanceMatrix, a, b);
    if (this.mesh.instanceColor) swapItems(this.mesh.instanceColor, a, b);
    for (const attribute of Object.values(this.mesh.geometry.attributes))
      if (attribute.isInstancedBufferAttribute) swapItems(attribute, a, b);
    const first = this.instanceAt[a], second = this.instanceAt[b];
    [this.instanceAt[a], this.instanceAt[b]] = [second, first];
    [this.slotOf[first], this.slotOf[second]] = [b, a];
  }

  release() {
    for (let instance = 0; instance < this.total; ++instance) this._swap(this.slotOf[instance], instance);
    this.mesh.count = this.total;
    this.mesh.onBeforeRender = this.saved.render;
    this.mesh.onBeforeShadow = this.saved.before;
    this.mesh.onAfterShadow = this.saved.after;
    this.whole.release();
  }
}

function swapItems(attribute, a, b) {
  const { array, itemSize } = attribute;
  for (let k = 0; k < itemSize; ++k) {
    const kept = array[a * itemSize + k];
    array[a * itemSize + k] = array[b * itemSize + k];
    array[b * itemSize + k] = kept;
  }
  attribute.needsUpdate = true;
}

/** The instances of a BatchedMesh, which has a flag for each and looks at all of them itself. */
export class BatchedTargets {
  constructor(mesh, culling) {
    this.mesh = mesh;
    this.hiddenOnes = new Set();
    const saved = (this.saved = { render: mesh.onBeforeRender, before: mesh.onBeforeShadow });
    mesh.onBeforeRender = (renderer, scene, camera, ...rest) =>
      this._withAll(camera !== culling.camera, () => saved.render.call(mesh, renderer, scene, camera, ...rest));
    mesh.onBeforeShadow = (...rest) => this._withAll(true, () => saved.before.call(mesh, ...rest));
  }

  _withAll(all, draw) {
    if (all) for (const instance of this.hiddenOnes) this.mesh.setVisibleAt(instance, true);
    draw();
    if (all) for (const instance of this.hiddenOnes) this.mesh.setVisibleAt(instance, false);
  }

  target(instance) {
    return {
      show: () => {
        this.hiddenOnes.delete(instance);
        this.mesh.setVisibleAt(instance, true);
      },
      hide: () => {
        this.hiddenOnes.add(instance);
        this.mesh.setVisibleAt(instance, false);
      },
      release: () => {},
    };
  }

  release() {
    this.mesh.onBeforeRender = this.saved.render;
    this.mesh.onBeforeShadow = this.saved.before;
  }
}
