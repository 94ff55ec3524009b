// SPDX-License-Identifier: Apache-2.0
// Loads WebAssembly that C++ became: the engine of the page, or the lab's.

import {answer_of, inflating, refuse} from './clip.js';

// Its functions and memory. The file is WebAssembly under deflate; it is fetched unless the page has its bytes.
export async function load_engine(name, bytes) {
  let instance;
  const view = () => new DataView(instance.exports.memory.buffer), nowhere = () => 8, done = () => 0;
  // The few calls that its C++ library makes: the time, and writing to nowhere.
  const wasi_snapshot_preview1 = {
    clock_time_get: (id, precision, at) =>
      done(view().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true)),
    environ_sizes_get: (count, size) => done(view().setUint32(count, 0, true), view().setUint32(size, 0, true)),
    environ_get: done, fd_close: nowhere, fd_seek: nowhere, fd_write: nowhere,
    proc_exit() { throw new WebAssembly.RuntimeError('exit'); }
  };
  bytes ??= await answer_of(new URL(name, import.meta.url), name, (answer) => answer.arrayBuffer());
  const code = await new Response(inflating([bytes])).arrayBuffer().catch(() => new ArrayBuffer(0));
  if (!WebAssembly.validate(code))
    refuse(`${name} is damaged, or this browser is too old for it: it takes WebAssembly with SIMD.`);
  try {
    ({instance} = await WebAssembly.instantiate(code, {wasi_snapshot_preview1}));
  } catch (error) {
    if (!(error instanceof WebAssembly.CompileError)) throw error;
    refuse("The server's Content-Security-Policy forbids WebAssembly: its script-src needs 'wasm-unsafe-eval'.");
  }
  instance.exports._initialize();
  return instance.exports;
}

// The text at an address of its memory, where a 0 ends it.
export function text_of({memory}, at) {
  const bytes = new Uint8Array(memory.buffer, at);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}

// Whether nothing that the engine has can be relied on: after a trap, or without memory.
export const has_trapped = (error) => error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
