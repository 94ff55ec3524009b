// The worker of the lab hour: calls functions of lab.cpp in engine.wasm, so that the page itself never waits.

/** What the engine's C++ library asks of a system: nothing here needs it. */
const system = new Proxy({}, {get: (_, name) => () => {
  if (name === 'proc_exit') throw new Error('The memory does not suffice.');
  return 8;
}});

let engine;
onmessage = async ({data: {name, numbers}}) => {
  try {
    engine ??= fetch(new URL('engine.wasm', import.meta.url)).then((answer) => answer.arrayBuffer())
      .then((bytes) => WebAssembly.instantiate(bytes, {wasi_snapshot_preview1: system}));
    const {exports} = (await engine).instance;
    if (name === 'start') return void exports._initialize();
    const worked = exports[name](...numbers), bytes = new Uint8Array(exports.memory.buffer, exports.lab_text());
    const text = new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
    if (!worked) throw new Error(text);
    postMessage({figures: Object.fromEntries(text.split('\n').map((line) => line.split('\t')))});
  } catch (error) {
    postMessage({fault: error.message});
  }
};
