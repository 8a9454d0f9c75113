// Wherever the bytes of a file come from.
import { AntumbraError } from "./errors.js";

const isNode = typeof process !== "undefined" && !!process.versions?.node;

async function gather(chunks, expected) {
  const parts = [];
  let size = 0;
  for await (const chunk of chunks) {
    const part = chunk instanceof Uint8Array ? chunk : new Uint8Array(chunk);
    parts.push(part);
    size += part.byteLength;
  }
  const bytes = new Uint8Array(size);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.byteLength;
  }
  return bytes;
}

/** Not every browser can loop over a stream. */
async function* chunksOf(stream) {
  const reader = stream.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield value;
    }
  } finally {
    reader.releaseLock();
  }
}

async function ofResponse(response, place) {
  if (!response.ok)
    throw new AntumbraError("io", `${place}: the server answered ${response.status} ${response.statusText}`.trimEnd());
  return new Uint8Array(await response.arrayBuffer());
}

async function ofUrl(url, options) {
  const place = String(url);
  if (isNode && place.startsWith("file:")) {
    const { readFile } = await import(/* @vite-ignore */ /* webpackIgnore: true */ "node:fs/promises");
    try {
      return await readFile(new URL(place), options?.signal ? { signal: options.signal } : undefined);
    } catch (cause) {
      if (cause.name === "AbortError") throw new AntumbraError("cancelled", `${place}: reading was stopped`, { cause });
      throw new AntumbraError("io", `${place}: ${cause.message}`, { cause });
    }
  }
  let response;
  try {
    response = await fetch(url, { signal: options?.signal });
    return await ofResponse(response, place);
  } catch (cause) {
    if (cause instanceof AntumbraError) throw cause;
    if (cause.name === "AbortError") throw new AntumbraError("cancelled", `${place}: loading was stopped`, { cause });
    throw new AntumbraError("io", `${place}: ${cause.message}`, { cause });
  }
}

/** Bytes of a Source; the name to put before errors about them. */
export async function readSource(source, options) {
  if (source instanceof ArrayBuffer || (typeof SharedArrayBuffer !== "undefined" && source instanceof SharedArrayBuffer))
    return { bytes: new Uint8Array(source), name: "" };
  if (ArrayBuffer.isView(source))
    return { bytes: new Uint8Array(source.buffer, source.byteOffset, source.byteLength), name: "" };
  if (typeof source === "string" || source instanceof URL)
    return { bytes: await ofUrl(source, options), name: String(source) };
  if (typeof Response !== "undefined" && source instanceof Response)
    return { bytes: await ofResponse(source, source.url || "response"), name: source.url };
  if (typeof Blob !== "undefined" && source instanceof Blob)
    return { bytes: new Uint8Array(await source.arrayBuffer()), name: source.name ?? "" };
  if (typeof source?.[Symbol.asyncIterator] === "function") return { bytes: await gather(source), name: "" };
  if (typeof source?.getReader === "function") return { bytes: await gather(chunksOf(source)), name: "" };
  throw new AntumbraError(
    "usage",
    "open: give bytes (ArrayBuffer or a view of one), a URL, a Response, a Blob or File, or a stream of bytes",
  );
}
