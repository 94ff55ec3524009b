// SPDX-License-Identifier: Apache-2.0
// Loads WebAssembly that C++ became: the engine of the page, or the lab's.

import {answer_of, inflating, refuse} from './clip.js';

// The few calls that its C++ library makes: the time, and writing to nowhere.
function wasi(memory) {
  const view = () => new DataView(memory().buffer);
  return {
    clock_time_get(id, precision, at) {
      view().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
      return 0;
    },
    environ_get: () => 0,
    environ_sizes_get: (count, size) => (view().setUint32(count, 0, true), view().setUint32(size, 0, true), 0),
    fd_close: () => 8, fd_seek: () => 8, fd_write: () => 8,
    proc_exit() { throw new WebAssembly.RuntimeError('exit'); },
  };
}

// Its functions and memory. The file is WebAssembly under deflate, a third of its size; it is fetched unless the page
// has its bytes.
export async function load_engine(name, bytes) {
  let instance;
  const imports = {wasi_snapshot_preview1: wasi(() => instance.exports.memory)};
  bytes ??= await answer_of(new URL(name, import.meta.url), name, (answer) => answer.arrayBuffer());
  const code = await new Response(inflating([bytes])).arrayBuffer().catch(() => new ArrayBuffer(0));
  if (!WebAssembly.validate(code))
    refuse(`${name} is damaged, or this browser is too old for it: it takes WebAssembly with SIMD.`);
  try {
    ({instance} = await WebAssembly.instantiate(code, imports));
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
