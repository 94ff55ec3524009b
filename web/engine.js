// Loads the engine, engine.bin: WebAssembly under deflate, a third of its bytes on the way.

import {answer_of, inflating} from './clip.js';

/** The few calls that its C++ library makes: the time, and writing to nowhere. */
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
    proc_exit: () => { throw new Error('Memory does not suffice for this clip.'); },
  };
}

/** The engine's functions and memory. `bytes`: of engine.bin, if the page has them; else they are fetched. */
export async function load_engine(bytes) {
  let instance;
  const imports = {wasi_snapshot_preview1: wasi(() => instance.exports.memory)};
  bytes ??= await answer_of(new URL('engine.bin', import.meta.url), 'engine.bin', (answer) => answer.arrayBuffer());
  try {
    ({instance} = await WebAssembly.instantiate(await new Response(inflating([bytes])).arrayBuffer(), imports));
  } catch {
    throw new Error('engine.bin is damaged, or this browser is too old for it: it takes WebAssembly with SIMD.');
  }
  instance.exports._initialize();
  return instance.exports;
}

/** The engine's text at an address, where a 0 ends it. */
export function text_at({memory}, at) {
  const bytes = new Uint8Array(memory.buffer, at);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}
