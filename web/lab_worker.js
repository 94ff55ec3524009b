// The worker of the lab hour: calls functions of lab.cpp in the engine, so that the page itself never waits.

import {load_engine} from './engine.js';

let engine;
onmessage = async ({data: {name, numbers}}) => {
  try {
    engine ??= load_engine();
    const exports = await engine;
    if (name === 'start') return;
    const worked = exports[name](...numbers), bytes = new Uint8Array(exports.memory.buffer, exports.lab_text());
    const text = new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
    if (!worked) throw new Error(text);
    postMessage({figures: Object.fromEntries(text.split('\n').map((line) => line.split('\t')))});
  } catch (error) {
    postMessage({fault: error.message});
  }
};
