// SPDX-License-Identifier: Apache-2.0
// The page of touchable: it connects the worker, which holds the clip, the solver and the view, with pointer, keys,
// gamepad, picture and sound. The messages between both are listed by `work` in worker.js and `answers` here.
//
// Once per animation frame the page sends 'due'; the worker runs the ticks that have elapsed and answers by one
// 'state', which is drawn at once. Nothing runs while the page is hidden. `?clip=URL` names the clip, `?kiosk` makes an
// unattended exhibit.

import {SurfacePicture, css_of, missing_colour, paint_fingers} from './draw.js';
import {ContactSound, tremble} from './sound.js';
import {keys} from './words.js';

const $ = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search), kiosk = query.has('kiosk');
const calm = matchMedia('(prefers-reduced-motion: reduce)').matches, by_touch = matchMedia('(pointer: coarse)').matches;
const one_file = globalThis.touchable_one_file;  // touch.html: {worker: URL, clip: {json, files}}
const canvas = $('picture'), stage = $('stage'), invitation = $('invitation'), sound = new ContactSound();
const invited_again_ms = 20000, reset_ms = 60000, try_again_ms = 60000;

const page = {worker: null, clip: null, state: null};
let picture = null;
let unit = 1, width = 1, height = 1;  // canvas pixels of a CSS pixel; of the stage
let unanswered = Infinity;  // 'due's: one may be under way while the answer to another is drawn
let drawn_view = '', drawn_fingers = '';
let has_begun = false;  // the clip's first picture is there
let enter_held = false, pad_presses = false, seeking = false, turning = false, touched = false;
let last_input = performance.now(), last_tick = 0, asked_at = 0;
let fault_at = Infinity, over = '';  // when something failed, or was last tried again; the page's last words
const held = new Map();  // pointers that are down, with the buttons of each

const post = (message, transfer = []) => page.worker.postMessage(message, transfer);
const play = (verb, number = 0) => post({do: 'play', verb, number});
const hand = (verb, a = 0, b = 0) => post({do: 'hand', verb, a, b});
function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// ---- Sentences: in place of the picture, as a notice above it, for a screen reader

function show_message(text, stops = false) {
  $('message').hidden = !text;
  $('message').className = stops ? 'stop' : has_begun ? '' : 'empty';
  put($('message').firstElementChild, text);
  $('again').hidden = !stops;
  if (stops) invitation.hidden = true;
}
const show_rest = () => show_message(over || (has_begun ? '' : 'Loading the first picture …'), !!over);
// `again`: whether it may help to ask the worker once more. A clip that fails before its first picture is over.
function show_fault(text, fatal = false, again = false) {
  fatal ||= again && !has_begun;
  if (fatal) over = text;
  fault_at = performance.now();
  show_rest();
  put($('notice').firstElementChild, text);
  $('go-on').hidden = !again;
  $('notice').hidden = fatal;
}
function end_fault() {
  fault_at = Infinity;
  $('notice').hidden = true;
}
function stop(text) {
  show_fault(text, true);
  $('bar').hidden = true;
}
// Reloads the page if its server answers. Otherwise the page stays: one that could not be loaded would not try again.
async function begin_anew() {
  if (over) show_message('Trying again …');
  const can_load = !location.protocol.startsWith('http') ||
    await fetch(location.href, {cache: 'no-store'}).then(({ok}) => ok, () => false);
  if (can_load) location.reload();
  else show_rest();
}
function say_finger() {
  const {pick, fingers: [finger]} = page.state, mm = Math.abs(finger?.depth_mm).toFixed(1);
  const where = !(pick?.valid > 0) ? 'nothing to touch'
    : `distance ${pick.depth_m.toFixed(3)} metres, ${mm} millimetres ` +
      (finger?.touching ? 'deep' : 'above the surface');
  const error = finger?.error_degrees >= 0 ? `, right to ${finger.error_degrees.toFixed(0)} degrees` : '';
  const text = finger ? `${page.clip.name}: ${where}, ${finger.newtons.toFixed(1)} newtons${error}`
    : 'No finger is on the picture.';
  put($('said'), '');
  setTimeout(() => put($('said'), text), 60);  // or the same words would not be read again
}

// ---- Messages of the worker

const answers = {
  clip(clip) {
    [page.clip, page.state] = [clip, null];
    over = '';
    end_fault();
    picture.begin(clip);
    document.title = `${clip.name || 'a picture'} · touchable`;
    const still = !clip.live && !(clip.frames > 1), word = /globe/i.test(clip.name) ? 'globe' : 'picture';
    for (const id of ['play', 'time', 'seek', 'speed', 'loop'])
      $(id).hidden = still || (clip.live && id !== 'play' && id !== 'time');
    $('seek').max = clip.seconds || 1;
    const plane_of = {stiffness: 'haptic', friction: 'haptic', height: 'height'};
    for (const option of $('overlay').options)
      option.disabled = option.value in plane_of && !clip.planes.includes(plane_of[option.value]);
    $('overlay').options[0].label = clip.planes.includes('colour') ? 'colour' : 'shape';
    show_overlay('colour');
    put($('invite'), kiosk || by_touch ? `Touch the ${word}` : `Move over the ${word}. Hold to press.`);
    put($('hint'), by_touch ? 'One finger touches, two turn it.' : kiosk ? 'Move, hold the button, and feel.'
      : 'The ring and the number show the force.');
    $('lock').hidden = !kiosk;
    show_begun(false);
    unanswered = 0;
  },
  state({planes, ...state}) {
    unanswered = Math.max(unanswered - 1, 0);
    page.state = state;
    if (state.frame < 0) return;  // at a clip's beginning; what was shown before stays
    if (!has_begun) show_begun(true);
    if (planes) picture.show(planes);
    draw(state, !!planes);
    const touches = state.fingers.some((finger) => finger.touching);
    show_state(state);
    sound.play(state.sound);
    tremble(gamepad(), state.rumble_low, state.rumble_high, touches && !touched);
    touched = touches;
  },
  fault: ({text, fatal, again}) => show_fault(text, fatal, again),
  well: end_fault,
  asked: ask_meaning
};

function show_begun(begun) {
  has_begun = begun;
  invite(begun);
  $('bar').classList.toggle('empty', !begun);
  $('force').hidden = !begun;
  show_rest();
}
function draw({matrix, own_view, fingers}, is_new = false) {
  const overlay = $('overlay').value;
  const view = [overlay, own_view, canvas.width, canvas.height, picture.stride, matrix].join();
  if (is_new || view !== drawn_view) {
    picture.draw(matrix, own_view, overlay);
    drawn_view = view;
    if (picture.drawn_ms) keep_pace(picture.drawn_ms);
  }
  const marks = JSON.stringify(fingers), size = Math.min(width, 1.4 * height);
  if (marks !== drawn_fingers) paint_fingers($('fingers'), unit, size, by_touch ? 15 : 9, fingers, page.clip.table);
  drawn_fingers = marks;
}

// ---- What bar and panels show

function show_state(state) {
  const tenths = Math.floor(10 * state.time + 0.05), [time, frame] = $('time').children;
  const seconds = `${String(Math.floor(tenths / 10) % 60).padStart(2, '0')}.${tenths % 10}`;
  put(time, page.clip.live ? 'live' : `${Math.floor(tenths / 600)}:${seconds}`);
  put(frame, ` frame ${state.frame}`);
  if (!seeking) $('seek').value = state.time;
  $('seek').setAttribute('aria-valuetext', `${time.textContent}, frame ${state.frame}`);
  put($('speed'), `${+state.speed.toFixed(2)}×`);
  $('speed').ariaLabel = `Speed ${$('speed').textContent}`;
  $('play').toggleAttribute('data-on', state.playing);
  $('play').ariaLabel = state.playing ? 'Pause' : 'Play';
  $('loop').ariaPressed = state.loops > 0;
  $('turning').ariaPressed = turning;
  $('home').disabled = state.own_view;
  const [number, newton, force] = $('force').children;
  const share = Math.min(1, Math.max(0, ...state.fingers.map((finger) => finger.share)));
  put(number, state.force_on ? state.newtons.toFixed(1) : 'off');
  newton.hidden = !state.force_on;
  force.firstElementChild.style.transform = `scaleX(${share.toFixed(3)})`;
  show_values(state.pick);
  if (!$('legend').hidden) show_legend(page.clip);
}

function show_values(pick) {
  $('values').hidden = !pick || !(invitation.hidden || invitation.matches('.away, .over'));
  if (!pick) return;
  put($('values'), !pick.valid ? 'nothing to touch' : `distance ${pick.depth_m.toFixed(4)} m\n` +
    `stiffness ${pick.stiffness.toFixed(2)} N/mm\n` +
    `friction ${pick.friction_static.toFixed(2)}, sliding ${pick.friction_dynamic.toFixed(2)}` +
    (page.clip.planes.includes('height') ? `\nheight ${pick.height_mm.toFixed(2)} mm` : ''));
}

function show_overlay(value) {
  $('overlay').value = value;
  $('legend').hidden = value === 'colour';
  const ramp = page.clip.table.ramp.map(css_of);
  const colours = {missing: [`${missing_colour} 50%`, '#555 50%'], depth: [...ramp].reverse()}[value] ?? ramp;
  $('legend').children[1].style.background = `linear-gradient(90deg, ${colours})`;
}
const words_of = (metres) => (metres < 0.1 ? `${+(1000 * metres).toPrecision(3)} mm` : `${+metres.toPrecision(3)} m`);
function show_legend({unit: metres}) {
  const [title, , least, greatest] = $('legend').children, {value, text} = $('overlay').selectedOptions[0];
  const length = (units) => words_of(units * metres);
  const ends = {depth: picture.range.map(length), height: ['0', length(picture.highest)],
    missing: ['measured', 'missing'], stiffness: ['soft', 'hard'], friction: ['slippery', 'sticky']};
  put(title, text);
  put(least, ends[value][0]);
  put(greatest, ends[value][1]);
}

// ---- Sizes: a picture takes at most 20 ms to draw, at a lower resolution if need be

const levels = [[1, 1], [0.75, 1], [0.75, 2], [0.5, 2], [0.5, 3], [0.35, 4]];  // pixels a side, stride of vertices
let level = 0, slow = 0;
function keep_pace(ms) {
  slow += ms > 80 ? 4 : ms > 50 ? 2 : ms > 20 ? 1 : ms < 5 ? -0.1 : 0;
  slow = Math.min(Math.max(slow, -2), 4);
  const next = Math.min(Math.max(level + Math.trunc(slow / 2), 0), levels.length - 1);
  if (next === level) return;
  [level, slow] = [next, 0];
  resize();
}
function resize() {
  const {clientWidth, clientHeight} = stage, [share, stride] = levels[level];
  unit = Math.min(devicePixelRatio || 1, 3);
  [width, height] = [clientWidth, clientHeight].map((length) => Math.round(length * unit));
  const drawn = share * Math.min(1, Math.sqrt(3e6 / Math.max(1, width * height)));
  Object.assign(canvas, {width: Math.ceil(width * drawn), height: Math.ceil(height * drawn)});
  picture.stride = stride;
  drawn_view = drawn_fingers = '';
  if (page.state) draw(page.state);  // a canvas with another size is black
}

// ---- Pointers: mouse, pen and touches become the window's events. The stage begins in the page's corner.

function send(kind, event, more = {}) {
  const {clientX = 0, clientY = 0, ctrlKey: control = false, shiftKey: shift = false, pointerId: touch = 0} = event;
  const press = event.pointerType === 'pen' ? event.pressure : 0;
  post({do: 'event', kind, x: clientX * unit, y: clientY * unit, button: 0, control, shift, touch, press, turning,
    seconds: event.timeStamp / 1000, ...more});
}
function leave(event) {
  send('left_window', event);
  enter_held = false;
  held.clear();
}
function on_pointer(event) {
  const {type, pointerId: id, pointerType} = event, moves = type === 'pointermove', down = type === 'pointerdown';
  const coalesced = moves && event.getCoalescedEvents?.() || [], parts = coalesced.length ? coalesced : [event];
  note_input(!moves);  // browsers allow sound when a touch ends
  if (down) canvas.setPointerCapture(id);
  const before = held.get(id) ?? 0, now = type === 'pointercancel' ? 0 : event.buttons;
  if (now) held.set(id, now);
  else held.delete(id);
  if (pointerType === 'touch') {
    for (const part of parts) send(down ? 'touch_began' : moves ? 'touch_moved' : 'touch_ended', part);
    return;
  }
  invitation.classList.add('over');
  for (const part of parts) send('moved', part);
  // A second button comes as a movement, so the buttons are compared.
  for (const button of [1, 2, 4])
    if ((before ^ now) & button) send(now & button ? 'pressed' : 'released', event, {button});
}

// ---- Keys and gamepad

const held_keys_repeat = ['deeper', 'point-down', 'point-right', 'turn', 'tilt', 'nearer', 'seek-by', 'step', 'louder'];
// `play` and `hand` take the names of ClockCommand and of HandCommand in engine.cpp.
const commands = {
  'play-pause': () => play('play_pause'), 'seek-by': (seconds) => play('seek_by', seconds), loop: () => play('loop'),
  step: (frames) => play('step', frames), faster: (factor) => play('rate', factor * page.state.speed),
  fingers: (count) => hand('count', count), deeper: (mm) => hand('deepen', mm / 1000),
  'point-right': (pixels) => hand('point', pixels * unit), 'point-down': (pixels) => hand('point', 0, pixels * unit),
  force: () => hand('force'), turn: (degrees) => hand('turn', degrees), tilt: (degrees) => hand('turn', 0, degrees),
  nearer: (factor) => hand('near_by', factor), home: () => hand('home'), turning: () => { turning = !turning; },
  mute: () => set_sound(sound.volume, !sound.muted),
  louder: (number) => set_sound(Math.min(Math.max(sound.volume + number / 100, 0), 1), false),
  overlay() {
    const free = [...$('overlay').options].filter((option) => !option.disabled).map((option) => option.value);
    show_overlay(free[(free.indexOf($('overlay').value) + 1) % free.length]);
  },
  help: show_help,
  fullscreen: () => (document.fullscreenElement ? document.exitFullscreen() : document.body.requestFullscreen())
    .catch(() => {})
};
const is_handled = (name) => name in commands && !(kiosk && ['help', 'fullscreen', 'loop'].includes(name));

function set_sound(volume, muted) {
  sound.set(volume, muted);
  $('mute').toggleAttribute('data-on', !muted);
  $('mute').ariaPressed = !muted;
}
// The row of the table; not Latin letters are where they are on an American keyboard.
function binding_of(event) {
  let key = event.key === ' ' ? 'space' : event.key.replace(/^Arrow/, '').toLowerCase();
  if (key.length === 1 && key > '~' && event.code.startsWith('Key')) key = event.code[3].toLowerCase();
  const is_sign = key.length === 1 && !/[a-z]/.test(key);  // Shift only serves to type it
  return keys.find((row) => row.key === key && !!row.control === event.ctrlKey && is_handled(row.command) &&
    (is_sign || !!row.shift === event.shiftKey));
}
function on_key(event) {
  const {target, key} = event, over_picture = target === canvas || target === document.body;
  if (event.altKey || event.metaKey || !page.state || document.querySelector('dialog[open]')) return;
  if (target.matches('select') || (!over_picture && /^(Enter| )$/.test(key))) return;
  if (target === $('seek') && /^(Arrow|Home|End|Page)/.test(key)) return;
  const found = binding_of(event), side = /Left|Up/.test(key) ? -1 : 1;
  if (key === 'Escape') $('notice').hidden = true;
  if (key === 'Enter') enter_held = true;
  else if (key === 'i' && !event.ctrlKey) say_finger();
  else if (over_picture && key.startsWith('Arrow') && !event.ctrlKey && !event.shiftKey) {
    // On the picture arrows lead the finger, or turn the view while dragging does.
    if (/Left|Right/.test(key)) commands[turning ? 'turn' : 'point-right'](side * (turning ? 5 : 8));
    else commands[turning ? 'tilt' : 'point-down'](side * (turning ? -5 : 8));
  } else if (!found) return;
  else if (!event.repeat || held_keys_repeat.includes(found.command)) commands[found.command](found.number);
  event.preventDefault();
  note_input(true);
}

const gamepad = () => [...(navigator.getGamepads?.() ?? [])].find((pad) => pad?.connected && pad.axes.length > 1);
function read_gamepad(seconds) {
  const pad = gamepad(), axes = pad ? pad.axes.map((value) => (Math.abs(value) < 0.15 ? 0 : value)) : [];
  pad_presses = pad?.buttons[7]?.value > 0.15;
  for (const [k, name] of ['point-right', 'point-down', 'turn', 'tilt'].entries())
    if (axes[k]) commands[name](axes[k] * seconds * [420, 420, 90, -90][k]);
  if (pad_presses || axes.slice(0, 4).some((value) => value)) note_input(true);
}

// ---- The invitation, and the exhibit's reset

function invite(shown) {
  invitation.hidden = false;
  invitation.classList.toggle('away', !shown);
}
function note_input(pressed = false) {
  last_input = performance.now();
  if (!pressed) return;
  invite(false);
  sound.start();
}
function watch_exhibit() {
  const now = performance.now();
  if (page.clip && !over && unanswered > 1 && now - asked_at >= try_again_ms) stop('The engine is silent.');
  if (now - fault_at >= try_again_ms) {
    fault_at = now;
    begin_anew();
  }
  if (held.size || !has_begun) return;
  const idle_ms = now - last_input;
  if (idle_ms >= invited_again_ms) invite(true);
  if (idle_ms < reset_ms) return;
  last_input = Infinity;  // once, until the next visitor
  post({do: 'reset'});
  turning = false;
  show_overlay('colour');
  set_sound(1, false);
  $('notice').hidden = $('lock').hidden = true;
  invitation.classList.remove('over');
}

// ---- One's own pictures, and help

async function ask_picture(file) {
  if (!file || kiosk || $('ask').open) return;
  if ($('go-on').hidden) end_fault();
  if (file.size > 1e8) return show_fault(`${file.name} is larger than 100 MB.`);
  show_message('Reading the picture …');
  const bytes = await file.arrayBuffer().catch(() => show_fault(`${file.name} cannot be read.`));
  if (bytes) post({do: 'read', bytes, name: file.name}, [bytes]);
}
// Meaning of the picture's levels, as chosen in the dialog; and the nearest and farthest depth that follow from it.
const is_relative = () => /white|black/.test($('unit').value);
const metres_a_level = () => (is_relative() ? 0 : Number($('unit').value) || $('level').valueAsNumber / 1000);
function show_extent({least, most, near, far}) {
  $('own-unit').hidden = $('level').disabled = $('unit').value !== '';
  const metres = metres_a_level(), [first, last] = is_relative() ? [near, far] : [least * metres, most * metres];
  const words = `Nearest ${words_of(first)}, farthest ${words_of(last)}${is_relative() ? ' (assumed)' : ''}`;
  put($('extent'), last > 0 ? words : '');
}
async function ask_meaning({name, guess}) {
  show_rest();
  put($('ask-name'), name);
  const known = guess.metres ? String(guess.metres) : guess.white_near ? 'white' : 'black';
  $('level').value = 1000 * guess.metres || 1;
  $('unit').value = known;
  if (!$('unit').value) $('unit').value = '';
  $('ask').oninput = () => show_extent(guess);
  show_extent(guess);
  $('ask').returnValue = '';
  $('ask').showModal();
  await new Promise((resolve) => $('ask').addEventListener('close', resolve, {once: true}));
  if ($('ask').returnValue !== 'open') return;
  post({do: 'picture', name, metres: metres_a_level(), white_near: $('unit').value === 'white',
    fov: $('fov').valueAsNumber});
}

const by_hand = {
  'Mouse and pen': [['move', 'the finger follows'], ['left button, pen', 'press; a pen by its pressure'],
    ['wheel', 'press deeper or less deep'], ['Ctrl and drag', 'turn; also the middle button'],
    ['Ctrl and wheel', 'nearer or farther']],
  'Touch screen': [['one finger', 'touches; up to five'], ['two fingers', 'turn; apart or together: zoom']],
  Gamepad: [['left stick', 'moves the finger'], ['right trigger', 'presses'], ['right stick', 'turns the view']],
  'On the picture': [['arrows', 'move the finger'], ['Enter', 'presses while it is held'],
    ['I', 'says name, distance and force']]
};
const topics = {begin: 'View', touch: 'Touch', view: 'View', play: 'Play', data: 'Data', window: 'Page'};
function show_help() {
  const sections = structuredClone(by_hand);
  let held_before = '';
  for (const {topic, what, key, control, shift} of keys.filter(({command}) => is_handled(command))) {
    const hold = `${control ? 'Ctrl ' : ''}${shift ? 'Shift ' : ''}`;
    const name = {left: '←', right: '→', up: '↑', down: '↓'}[key] ?? key[0].toUpperCase() + key.slice(1);
    const rows = sections[topics[topic]] ??= [], row = rows.find(([, words]) => words === what);
    if (row) row[0] += ` ${hold === held_before ? '' : hold}${name}`;
    else rows.push([hold + name, what]);
    held_before = hold;
  }
  const {clip} = page, size_words = `${clip?.width} x ${clip?.height} pixels, ${clip?.frames || 'live'} frames`;
  const facts = clip ? [`${clip.name}: ${size_words}`, ...clip.remarks] : [];
  sections['This clip'] = facts.map((words) => [words, '']);
  const made = (tag, ...inside) => {
    const element = document.createElement(tag);
    element.append(...inside);  // strings as text
    return element;
  };
  const section_of = ([title, rows]) => made('section', made('h3', title),
    made('dl', ...rows.flatMap(([key, words]) => [made('dt', key), made('dd', words)])));
  $('about-text').replaceChildren(...Object.entries(sections).map(section_of));
  $('about').showModal();
}

// ---- Start

function tick(now) {
  requestAnimationFrame(tick);
  const ms = now - last_tick;
  last_tick = now;
  if (!page.clip || unanswered > 1) return;
  read_gamepad(Math.min(ms, 100) / 1000);
  post({do: 'due', width, height, pressed: enter_held || pad_presses});
  ++unanswered;
  asked_at = performance.now();
}

function connect_controls() {
  const on = (element, types, call, options) =>
    types.split(' ').forEach((type) => element.addEventListener(type, call, options));
  on(canvas, 'pointerdown pointermove pointerup pointercancel', on_pointer);
  on(canvas, 'pointerleave', (event) => {
    invitation.classList.remove('over');
    if (event.pointerType !== 'touch') leave(event);
  });
  on(canvas, 'wheel', (event) => {
    note_input();
    send('wheel', event, {y: -event.deltaY / (event.deltaMode ? 3 : 100)});
  });
  on(canvas, 'contextmenu wheel webglcontextlost', (event) => event.preventDefault(), {passive: false});
  on(canvas, 'webglcontextrestored', () => {
    picture.prepare();
    drawn_view = '';
  });
  on(canvas, 'dblclick', () => kiosk || by_touch || commands.fullscreen());
  on(window, 'keydown', on_key);
  on(window, 'keyup', (event) => { if (event.key === 'Enter') enter_held = false; });
  on(window, 'blur', leave);
  on(document, 'visibilitychange', (event) => {
    leave(event);
    if (document.hidden) sound.suspend();
    else sound.resume();
  });
  new ResizeObserver(resize).observe(stage);
  on($('play'), 'click', commands['play-pause']);
  for (const name of ['loop', 'turning', 'home', 'mute', 'help', 'fullscreen']) on($(name), 'click', commands[name]);
  on($('speed'), 'click', () => play('rate', {1: 0.5, 0.5: 0.25, 0.25: 2}[page.state.speed] ?? 1));
  on($('seek'), 'input change', ({type}) => {
    seeking = type === 'input';
    if (seeking) play('seek', $('seek').valueAsNumber);
  });
  on($('overlay'), 'change', () => show_overlay($('overlay').value));
  on($('bar'), 'click', ({target}) => {  // keys belong to the picture again, unless keys clicked
    note_input(true);
    if (target.closest('button:not(:focus-visible)')) canvas.focus({preventScroll: true});
  });
  on($('notice'), 'click', () => { $('notice').hidden = true; });
  on($('go-on'), 'click', () => post({do: 'go_on'}));
  on($('open'), 'click', () => $('file').click());
  on($('file'), 'change', () => {
    ask_picture($('file').files[0]);
    $('file').value = '';
  });
  on(window, 'dragover dragleave drop', (event) => {
    event.preventDefault();
    $('drop').hidden = kiosk || event.type !== 'dragover';
    if (event.type === 'drop') ask_picture(event.dataTransfer.files[0]);
  });
}

function start() {
  document.body.classList.toggle('kiosk', kiosk);
  if (kiosk) setInterval(watch_exhibit, 1000);
  $('again').onclick = begin_anew;
  $('fullscreen').hidden = !document.fullscreenEnabled;
  for (const need of ['WebAssembly', 'Worker', 'DecompressionStream'])
    if (!globalThis[need]) return stop(`This page needs ${need}, which this browser does not offer.`);
  try {
    picture = new SurfacePicture(canvas);
    page.worker = new Worker(one_file?.worker ?? new URL('worker.js', import.meta.url), {type: 'module'});
  } catch (error) {
    return stop(error.message);
  }
  page.worker.onmessage = ({data}) => {
    try {
      answers[data.is]?.(data);
    } catch (error) {
      show_fault(error.message, true);
    }
  };
  page.worker.onerror = (event) => stop(`The worker stopped: ${event.message || 'it cannot be loaded'}.`);
  set_sound(1, false);
  connect_controls();
  show_message('Loading the clip …');
  const url = new URL(query.get('clip') || 'clip.json', location.href).href;
  post({do: 'open', url, ...one_file?.clip, wasm: one_file?.wasm, calm});
  requestAnimationFrame(tick);
}
start();
