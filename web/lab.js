// SPDX-License-Identifier: Apache-2.0
// The lab hour: three experiments, each a form, a plot, a table and a CSV file. All numbers come from lab.cpp in a
// worker; this module chooses the settings, and compares with the program's own figures.

// The program's own figures, shown beside the page's: `touchable-bench paper --json paper.json` gives them (with
// --quick those of 10 s). Fig. 19 by the end of the cases' names: hashes by pixel, then by world, without a filter,
// -m3, -m5, -m5-t, and with -temporal (not of -still, a single frame). Table I by content, metric and seconds:
// largest, mean and hash of line, circle, eight.
const {scratches, sweeps} = await (await fetch(new URL('lab_native.json', import.meta.url))).json();

const worker = new Worker(new URL('lab_worker.js', import.meta.url), {type: 'module'});

// Calls a function of lab.cpp, one at a time; answers its figures: texts by name.
const ask = (name, ...numbers) => new Promise((resolve, reject) => {
  worker.onmessage = ({data}) => (data.fault ? reject(new Error(data.fault)) : resolve(data.figures));
  worker.onerror = () => reject(new Error('The engine could not be started in this browser.'));
  worker.postMessage({name, numbers: numbers.map(Number)});
});

const white = '#eef0f4', chest_frames = 293;  // as in paper_suite.cpp
const filters = [
  {words: 'no filter', of: [0, 0, 0], colour: '#8a93a3'},
  {words: 'median 3x3', of: [3, 0, 0], colour: '#e8a86d'},
  {words: 'median 5x5', of: [5, 0, 0], colour: '#e86d8a'},
  {words: '5x5, terraces removed', of: [5, 1, 0], colour: '#6db9e8'},
  {words: 'and averaged over frames', of: [5, 1, 1], colour: '#8fe0a0', averages: true}
];
// The last two cells of a row: the force hash, and what the program's own says of it.
const verdict = (hash, native) =>
  [hash, !native ? 'no case of the program' : hash === native ? 'equal' : `not equal: ${native}`];

// Each adds rows, the heading first, and answers the panels to draw, and rows for the CSV file alone.
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
          const known = speed === 1 ? sweeps[`${content} ${metric} ${seconds}`] : null, mean = +got.primitives_mean;
          const [known_largest = '', known_mean = '', hash] = known?.slice(3 * path) ?? [];
          add(content, ours ? 'ours' : "the paper's", hand, +got.primitives_second_max, mean,
            known_largest, known_mean, ...verdict(got.force_hash, hash));
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
      const felt = got ? [+got.force_band_mn, +got.held_back_mm, ...verdict(got.force_hash, native)] : ['', '', '', ''];
      add(words, ...errors, ...felt);
    }
    lines.push({points: [[noise, 0.1], [noise, 100]], colour: white, width: 1, dashes: [3, 5]});
    return [[{title: 'Error of the normals, RMS', lines,
      x: {name: 'noise, levels', from: 0, to: 3, ticks: [0, 1, 2, 3]},
      y: {name: 'degrees', from: 0.1, to: 100, log: true, ticks: [0.1, 1, 10, 100]}}], kept];
  }
};

// Draws panels side by side: {title, x, y, lines}. An axis is {name, from, to, log, ticks, words}, a line {points,
// colour, words, width, dashes}. What colours mean is written below, by the first panel's lines.
function plot(canvas, panels) {
  canvas.hidden = false;
  const scale = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  const top = 46, bottom = height - (width < 640 ? 100 : 66);
  Object.assign(canvas, {width: width * scale, height: height * scale});
  const c = canvas.getContext('2d');
  c.scale(scale, scale);
  c.font = '13px system-ui, sans-serif';
  const write = (words, x, y, textAlign, fillStyle = '#a9b0bc') =>
    Object.assign(c, {textAlign, fillStyle}).fillText(words, x, y);
  const share = ({log, from, to}, v) => (log ? Math.log(v / from) / Math.log(to / from) : (v - from) / (to - from));
  for (const [n, {title, x, y, lines}] of panels.entries()) {
    const left = n * width / panels.length + 56, right = (n + 1) * width / panels.length - 14;
    const at = ([a, b]) =>
      [left + share(x, a) * (right - left), bottom - share(y, Math.max(b, y.from)) * (bottom - top)];
    const draw = ({points, colour, width: lineWidth = 1.8, dashes = []}) => {
      Object.assign(c, {strokeStyle: colour, lineWidth}).setLineDash(dashes);
      c.beginPath();
      for (const point of points) c.lineTo(...at(point));
      c.stroke();
    };
    x.ticks.forEach((v, k) => write(x.words?.[k] ?? v, at([v, 0])[0], bottom + 18, 'center'));
    for (const v of y.ticks) {
      draw({points: [[x.from, v], [x.to, v]], colour: '#2c3038', width: 1});
      write(y.log && v < 0.01 ? v.toExponential(0) : v, left - 8, at([x.from, v])[1] + 4, 'right');
    }
    write(title, left, 16, 'left', '#eef0f4');
    write(x.name, right, bottom + 36, 'right');
    write(y.name, left - 50, 34, 'left');
    lines.forEach(draw);
  }
  let begin = 6, row = bottom + 58;
  for (const {words, colour} of panels[0].lines.filter((line) => line.words)) {
    const wide = c.measureText(words).width;
    if (begin + wide > width) [begin, row] = [6, row + 18];
    write(words, begin, row, 'left', colour);
    begin += wide + 22;
  }
}

// Adds a row to a table, whose first is its heading; numbers have four digits, as the program prints them.
function show(table, cells) {
  const row = table.insertRow(), kind = table.rows.length > 1 ? 'td' : 'th';
  for (const value of cells) {
    const cell = row.appendChild(document.createElement(kind));
    cell.textContent = typeof value === 'number' ? Number(value.toPrecision(4)) : value;
    if (typeof value === 'string') cell.className = {equal: 'equal', not: 'other'}[value.split(' ')[0]] ?? 'word';
  }
}

function save(name, rows) {
  const text = rows.map((row) => row.map((value) => `"${value}"`).join(',')).join('\n');
  const href = URL.createObjectURL(new Blob([text, '\n'], {type: 'text/csv'}));
  Object.assign(document.createElement('a'), {href, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}

const status = document.getElementById('status'), buttons = [];
for (const [id, run] of Object.entries(experiments)) {
  const section = document.getElementById(id), form = section.querySelector('form');
  form.insertAdjacentHTML('beforeend',
    '<button type="button" class="main">Run</button><button type="button" disabled>CSV</button>');
  section.insertAdjacentHTML('beforeend', '<canvas hidden></canvas><div><table></table></div>');
  const [start, csv] = form.querySelectorAll('button'), [canvas, table] = section.querySelectorAll('canvas, table');
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
      table.replaceChildren();
      const [panels, kept] = await run(settings, (...row) => {
        rows.push(row);
        show(table, row);
      });
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
