// The lab hour: three experiments, each a form, a plot, a table and a CSV file. All numbers come from lab.cpp in a
// worker; this module chooses the settings, and compares with the program's own figures.

import {plot, save, show} from './lab_plot.js';

// The program's own figures, shown beside the page's: `touchable-bench paper --json paper.json` gives them (with
// --quick those of 10 s). Fig. 19 by the end of the cases' names: hashes by pixel, then by world, without a filter,
// -m3, -m5, -m5-t, and with -temporal (not of -still, a single frame). Table I by content, metric and seconds:
// largest, mean and hash of line, circle, eight.
const {scratches, sweeps} = await (await fetch(new URL('lab_native.json', import.meta.url))).json();

const worker = new Worker(new URL('worker.js', import.meta.url), {type: 'module'});
worker.postMessage({do: 'lab'});

/** Calls a function of lab.cpp, one at a time; answers its figures: texts by name. */
const ask = (name, ...numbers) => new Promise((resolve, reject) => {
  worker.onmessage = ({data}) => (data.is === 'fault' ? reject(new Error(data.text)) : resolve(data.figures));
  worker.onerror = () => reject(new Error('The engine could not be started in this browser.'));
  worker.postMessage({do: 'lab', name, numbers: numbers.map(Number)});
});

const white = '#eef0f4', chest_frames = 293; // as in paper_suite.cpp
const filters = [
  {words: 'no filter', of: [0, 0, 0], colour: '#8a93a3'},
  {words: 'median 3x3', of: [3, 0, 0], colour: '#e8a86d'},
  {words: 'median 5x5', of: [5, 0, 0], colour: '#e86d8a'},
  {words: '5x5, terraces removed', of: [5, 1, 0], colour: '#6db9e8'},
  {words: 'and averaged over frames', of: [5, 1, 1], colour: '#8fe0a0', averages: true},
];
/** The last two cells of a row: the force hash, and what the program's own says of it. */
const verdict = (hash, native) =>
  [hash, !native ? 'no case of the program' : hash === native ? 'equal' : `not equal: ${native}`];

/** Each adds rows, the heading first, and answers the panels to draw, and rows for the CSV file alone. */
const experiments = {
  async 'table-1'({seconds, speed}, add) {
    add('content', 'method', 'hand', 'largest', 'mean', 'the program: largest', 'mean', 'force hash', '');
    const hands = ['line', 'circle', 'eight'], lines = [], ticks = [], words = [];
    for (const content of ['chest', 'globe']) {
      const is_chest = content === 'chest', begin = ticks.length - 0.5, paper = is_chest ? 3.498 : 5.549;
      await ask('lab_clip', is_chest, 1, chest_frames, 0);
      for (const metric of ['pixel', 'world']) {
        const ours = metric === 'world', settings = !ours ? [0, 3, 0, 1] : is_chest ? [1, 5, 1, 0] : [1, 0, 1, 0];
        for (const [path, hand] of hands.entries()) {
          const got = await ask('lab_sweep', ...settings, path, speed, seconds);
          const known = speed === 1 ? sweeps[`${content} ${metric} ${seconds}`]?.split(' ') : null;
          const native = known ? known.slice(3 * path, 3 * path + 3) : ['', '', null], mean = +got.primitives_mean;
          add(content, ours ? 'ours' : "the paper's", hand, +got.primitives_second_max, mean,
            known ? +native[0] : '', known ? +native[1] : '', ...verdict(got.force_hash, native[2]));
          const x = ticks.length;
          lines.push({points: [[x, 0], [x, mean]], width: 22, colour: filters[ours ? 3 : 1].colour,
            words: {0: "the paper's method", 3: 'ours'}[x]});
          ticks.push(x);
          words.push(x % 6 ? hand : `${content}: ${hand}`);
        }
      }
      lines.push({points: [[begin, paper], [begin + 6, paper]], colour: white, dashes: [5, 5],
        words: is_chest ? "the paper's hands, on average" : ''});
    }
    return [[{title: 'Primitives passed in a tick, mean', lines, x: {name: '', from: -0.7, to: 11.7, ticks, words},
      y: {name: '', from: 0, to: 10, ticks: [0, 2, 4, 6, 8, 10]}}], []];
  },

  async 'figure-19'({noise, newtons, hand}, add) {
    add('metric', 'filter', '20 to 500 Hz, mN', 'held back, mm', 'mean force, N', 'force hash', '');
    const changes = {'0 1': '', '0 2': '-hard', '2 1': '-fast', '3 1': '-firm'};
    const native = scratches[`n${noise}${changes[`${hand} ${newtons}`] ?? '-unknown'}`];
    const kept = [['metric', 'filter', 'Hz', 'N^2/Hz']], panels = [];
    await ask('lab_clip', 1, noise, chest_frames, 0);
    for (const [n, metric] of ['pixel', 'world'].entries()) {
      const lines = [];
      for (const [k, {words, of, colour}] of filters.entries()) {
        const got = await ask('lab_scratch', n, ...of, hand, newtons);
        const points = Object.entries(got).filter(([figure]) => figure.startsWith('force_psd_'))
          .map(([figure, value]) => [parseFloat(figure.slice('force_psd_'.length)), +value]);
        lines.push({points, colour, words});
        kept.push(...points.map((point) => [metric, words, ...point]));
        add(metric, words, +got.force_band_mn, +got.held_back_mm, +got.force_n_mean,
          ...verdict(got.force_hash, native?.[5 * n + k]));
      }
      panels.push({title: n ? 'World, ours' : "Pixel, the paper's", lines,
        x: {name: 'Hz', from: 1, to: 500, log: true, ticks: [1, 10, 100]},
        y: {name: 'N²/Hz', from: 1e-12, to: 10, log: true, ticks: [1e-12, 1e-9, 1e-6, 1e-3, 1]}});
    }
    return [panels, kept];
  },

  async filters({noise, seed, frames}, add) {
    add('filter', 'depth, mm', 'normals, degrees', '20 to 500 Hz, mN', 'held back, mm', 'force hash', '');
    const kept = [['filter', 'noise', 'depth, mm', 'normals, degrees']];
    const lines = filters.map(({words, colour}) => ({points: [], colour, words}));
    for (let level = 0; level <= 3; level += 0.25)
      for (const [k, {words, of, averages}] of filters.entries()) {
        // Averaging ends with the picture that the others filter.
        if (averages) await ask('lab_clip', 1, level, frames, seed - frames + 1);
        else if (k === 0) await ask('lab_clip', 1, level, 1, seed);
        const got = await ask('lab_surface', ...of);
        lines[k].points.push([level, +got.normal_deg_rms]);
        kept.push([words, level, +got.depth_mm_rms, +got.normal_deg_rms]);
      }
    await ask('lab_clip', 1, noise, 1, seed);
    for (const [k, {words, of, averages}] of filters.entries()) {
      const errors = kept.find((row) => row[0] === words && row[1] === noise).slice(2);
      const got = averages ? null : await ask('lab_scratch', 1, ...of, 0, 1);
      const native = seed === 0 ? scratches[`n${noise}-still`]?.[4 + k] : null;
      const felt = got && [+got.force_band_mn, +got.held_back_mm, ...verdict(got.force_hash, native)];
      add(words, ...errors, ...(felt ?? ['', '', '', '']));
    }
    lines.push({points: [[noise, 0.1], [noise, 100]], colour: white, width: 1, dashes: [3, 5]});
    return [[{title: 'Error of the normals, RMS', lines,
      x: {name: 'noise, levels', from: 0, to: 3, ticks: [0, 1, 2, 3]},
      y: {name: 'degrees', from: 0.1, to: 100, log: true, ticks: [0.1, 1, 10, 100]}}], kept];
  },
};

const status = document.getElementById('status'), buttons = [];
for (const [id, run] of Object.entries(experiments)) {
  const section = document.getElementById(id), form = section.querySelector('form');
  const made = (place, name, more) => place.appendChild(Object.assign(document.createElement(name), more));
  const start = made(form, 'button', {type: 'button', className: 'main', textContent: 'Run'});
  const csv = made(form, 'button', {type: 'button', textContent: 'CSV', disabled: true});
  const canvas = made(section, 'canvas', {hidden: true}), table = made(made(section, 'div'), 'table');
  form.oninput = () => {
    for (const output of form.querySelectorAll('output')) output.value = output.previousElementSibling.value;
  };
  form.oninput();
  buttons.push(start);
  start.onclick = async () => {
    const settings = Object.fromEntries([...new FormData(form)].map(([name, value]) => [name, Number(value)]));
    const rows = [], count = (begin) => rows.filter((row) => row.at(-1).startsWith(begin)).length;
    for (const button of [...buttons, csv]) button.disabled = true;
    status.textContent = 'Running. A row appears as soon as it is there.';
    try {
      const [panels, kept] = await run(settings, (...row) => show(table, (rows.push(row), rows)));
      plot(canvas, panels);
      csv.onclick = () => save(`${id}.csv`, [...Object.entries(settings), [], ...rows, [], ...kept]);
      csv.disabled = false;
      status.textContent = count('equal') + count('not') === 0 ? 'Done. The program has no case of these settings.'
        : `Done. Force hashes: ${count('equal')} equal the program's, ${count('not')} do not.`;
    } catch (error) {
      status.textContent = error.message;
    }
    for (const button of buttons) button.disabled = false;
  };
}
