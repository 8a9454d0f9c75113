// What `antumbra view` offers beside the page. A page opened from disk has none of it.
import { Vector3 } from 'three';

export interface Offer {
  name: string;
  scene: string;
  pvs: string | null;
  /** Objects of the .pvs are the nodes of the scene in order: the scene was converted from another format. */
  byOrder: boolean;
  explains: boolean;
}

export interface PathFrame { eye: Vector3; target: Vector3 }

export interface SightAnswer {
  answer: 'visible' | 'hidden' | 'undecided';
  touches: boolean;
  witness: { from: number[]; to: number[] } | null;
  sight_lines: number;
  lines_through: number;
  hiders: { id: number; name: string; share: number; leaves: number }[];
  certificate: { verified: boolean } | null;
}

export interface Explanation {
  object: { id: number };
  cell: { index: number | null; state: string } | null;
  pvs: { listed: boolean; guarantee: string; always_visible: boolean } | null;
  from_eye: SightAnswer;
  from_cell: SightAnswer | null;
}

/** The offer of the server that the page came from, or null: then there is none. Addresses in the page's query
 * (?scene=..&pvs=..) do without a server of ours. */
export async function findOffer(): Promise<Offer | null> {
  if (document.querySelector('meta[name=antumbra-server]')) return await json<Offer>('api/scene');
  const query = new URLSearchParams(location.search), scene = query.get('scene');
  return scene ? { name: scene.split('/').pop()!, scene, pvs: query.get('pvs'), byOrder: false, explains: false } : null;
}

async function json<T>(address: string): Promise<T> {
  const response = await fetch(address);
  const body = await response.json();
  if (!response.ok) throw new Error(body.error ?? `${address}: ${response.status}`);
  return body as T;
}

/** Bytes of an address, with progress. */
export async function download(address: string, progress: (share: number) => void): Promise<ArrayBuffer> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${(await response.text()) || response.statusText}`);
  const total = Number(response.headers.get('content-length')), reader = response.body!.getReader();
  const parts: Uint8Array[] = [];
  let size = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    size += value.length;
    if (total) progress(Math.min(1, size / total));
  }
  const all = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all.buffer;
}

/** A walk through the scene; null where there is nowhere to walk. */
export async function fetchPath(): Promise<PathFrame[] | null> {
  const { frames } = await json<{ frames: { eye: number[]; target: number[] }[] }>('api/path');
  return frames.length < 2 ? null : frames.map(({ eye, target }) => ({ eye: new Vector3(...eye), target: new Vector3(...target) }));
}

export const fetchExplanation = (object: number, eye: Vector3): Promise<Explanation> =>
  json<Explanation>(`api/explain?object=${object}&eye=${eye.toArray().join(',')}`);
