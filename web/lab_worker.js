// The worker of the lab hour: calls functions of lab.cpp in the engine, so that the page itself never waits.

import {load_engine, text_at} from './engine.js';

let engine;
onmessage = async ({data: {name, numbers}}) => {
  try {
    engine ??= load_engine();
    const exports = await engine;
    if (name === 'start') return;
    const worked = exports[name](...numbers), text = text_at(exports, exports.lab_text());
    if (!worked) throw new Error(text);
    postMessage({figures: Object.fromEntries(text.split('\n').map((line) => line.split('\t')))});
  } catch (error) {
    postMessage({fault: error.message});
  }
};
