// SPDX-License-Identifier: Apache-2.0
// The worker of lab.html: calls a function of lab.cpp, and answers by its figures, texts by name.

import {refuse} from './clip.js';
import {has_trapped, load_engine, text_of} from './engine.js';

const load = () => load_engine('lab.bin');
let loading = load();
onmessage = async ({data: {name, numbers}}) => {
  try {
    const lab = await loading, worked = lab[name](...numbers), text = text_of(lab, lab.lab_text());
    if (!worked) refuse(text);
    postMessage({figures: Object.fromEntries(text.split('\n').map((line) => line.split('\t')))});
  } catch (error) {
    loading = load();
    postMessage({fault: has_trapped(error) ? 'The lab stopped: memory may not suffice for this.' : error.message});
  }
};
