// The worker of the page: it fetches and inflates pictures, gives them to the engine, runs the ticks that have
// elapsed at each event and each picture, and sends what is to be drawn, heard and read. One thread: no memory is
// shared, so any web server will do.

import {PackedClip, live_framesets} from './clip.js';
import {load_engine} from './engine.js';
import {unpack_png} from './png.js';

const event_kinds = ['moved', 'pressed', 'released', 'wheel', 'key', 'key_released', 'resized', 'dropped', 'left_window',
  'touch_began', 'touch_moved', 'touch_ended'];
const buttons = {left: 1, right: 2, middle: 3};
const roles = ['depth', 'haptic', 'height'];
// The members of Shown and ShownFinger in engine.cpp.
const members = ['tick', 'time', 'playing', 'at_end', 'loops', 'speed', 'force_on', 'own_view', 'newtons', 'sound_samples',
  'rumble_low', 'rumble_high', 'late_frames', 'fingers', 'picked', 'depth_m', 'stiffness', 'static_friction',
  'dynamic_friction', 'height_mm'];
const finger_members = 13;
// PageCommand of engine.cpp: number, and what its two numbers are.
const commands = {
  'play-pause': () => [0], seek: (s) => [1, s], 'seek-by': (s) => [2, s], step: (n) => [3, n], speed: (x) => [4, x],
  faster: (x) => [4, Math.min(4, Math.max(0.1, seen.speed * x))], loop: () => [5, seen.loops ? 0 : 1],
  fingers: (n) => [6, n], deeper: (mm) => [7, mm / 1000], 'point-right': (px) => [8, px, 0], 'point-down': (px) => [8, 0, px],
  force: () => [9], turn: (degrees) => [10, degrees, 0], tilt: (degrees) => [10, 0, degrees], nearer: (x) => [11, x],
  home: () => [12], press: (on) => [13, on],
};

let engine, clip, broken = false, shown = -1, colour_shown = -1, haptic_shown = null;
let turning = false, pressed = false, feeding = null, last_ms = 0, owed_ms = 0, ticks_us = 0, build_ms = 0, decode_ms = 0;
let seen = {speed: 1, loops: 0}, live_stop = null;
let opening = 0; // counts clips and beginnings: what was under way for an earlier one ends without a trace
const colours = new Map(); // pictures of frames that may still be shown

const say = (message, transfers = []) => postMessage(message, transfers);
const fail = (text) => { throw new Error(text); };

// ---- The engine

const memory = (type, at, count) => new type(engine.memory.buffer, at, count);
function text_at(at) {
  const bytes = memory(Uint8Array, at);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}
function put(array) {
  memory(array.constructor, engine.room(array.byteLength), array.length).set(array);
}
const check = (worked) => worked || fail(text_at(engine.fault()));

// ---- Opening

async function open({url, files, json, wasm}) {
  const told = (loaded, total, what) => say({is: 'progress', loaded, total, what});
  let packed;
  [engine, packed] = await Promise.all([engine ?? load_engine(wasm), PackedClip.open(files ? json : url, files, told)]);
  put(Float64Array.from([...packed.numbers, ...packed.times]));
  check(engine.open_scene(packed.numbers.length, packed.times.length, packed.live ? Number.MAX_SAFE_INTEGER : packed.frames, packed.live ? 1 : 0));
  const {numbers} = packed.json;
  const rate = numbers['rate.num'] / numbers['rate.den'];
  met(packed, {
    name: String(packed.json.name ?? ''), remarks: (packed.json.remarks ?? []).map(String), frames: packed.frames, rate,
    seconds: packed.times.length ? packed.times.at(-1) / 1e9 + 1 / rate : packed.frames / rate, live: packed.live !== null,
    has: {colour: !!packed.planes.colour, haptic: !!packed.planes.haptic, height: !!packed.planes.height},
    unit: numbers.metres_per_unit, near: numbers['depth.near'], far: numbers['depth.far'],
  });
  if (packed.live) follow(new URL(packed.live, url), packed);
}

async function open_picture({bytes, name, unit, fov}) {
  engine ??= await load_engine();
  const {width, height, codes} = await unpack_png(bytes);
  put(codes);
  check(engine.open_picture(width, height, unit, fov));
  met({width, height, frames: 1, planes: {}}, {
    name, remarks: [], frames: 1, rate: 30, seconds: 0, live: false, has: {colour: false, haptic: false, height: false}, unit: 0.001,
    near: 0, far: 0,
  });
}

function met(packed, about) {
  live_stop?.abort();
  live_stop = null;
  clip = packed;
  begun();
  say({is: 'clip', width: packed.width, height: packed.height, ...about});
}

/** The clip is at its beginning. */
function begun() {
  ++opening;
  feeding = null;
  broken = false;
  shown = colour_shown = -1;
  haptic_shown = null;
  colours.clear();
  taken = {};
  last_ms = 0;
  owed_ms = 0;
}

// ---- Frames

let taken = {}; // of each role the frame whose packet the engine has

async function give_frame(frame) {
  const of = opening, start = performance.now();
  for (const role of roles) {
    const plane = clip.planes[role];
    if (!plane || taken[role] === clip.own(role, frame)) continue;
    const packet = await clip.picture(role, frame);
    if (of !== opening) return;
    give_plane(plane, packet);
    taken[role] = clip.own(role, frame);
  }
  if (clip.planes.colour) await keep_colour(frame, clip.own('colour', frame));
  if (of !== opening) return;
  const decoded = performance.now();
  check(engine.give());
  decode_ms = decoded - start;
  build_ms = performance.now() - decoded;
}

function give_plane(plane, packet) {
  put(packet);
  check(engine.plane(roles.indexOf(plane.role), plane.bytes_per_sample, plane.channels, packet.length));
}

async function keep_colour(frame, own) {
  if (!colours.has(own)) {
    const packet = await clip.picture('colour', frame);
    colours.set(own, new Blob([packet], {type: 'image/jpeg'}));
  }
  if (colours.size > 32) colours.delete(colours.keys().next().value);
}

/** Gives the engine the frames that it wants, one after the other; one such work at a time. */
function feed() {
  if (feeding || broken || clip.live) return;
  const of = opening;
  feeding = (async () => {
    for (let frame; of === opening && (frame = engine.wanted()) >= 0;) await give_frame(frame);
  })().catch((error) => {
    if (of !== opening) return;
    broken = true;
    faulty(error);
  }).finally(() => { if (of === opening) feeding = null; });
}

async function follow(url, packed) {
  const of = opening;
  live_stop = new AbortController();
  try {
    for await (const {packets} of live_framesets(url, packed.planes, live_stop.signal)) {
      if (of !== opening) return;
      for (const role of roles) {
        const packet = packets[role] && await packed.unpacked(packed.planes[role], packets[role]);
        if (of !== opening) return;
        if (packet) give_plane(packed.planes[role], packet);
      }
      const number = engine.wanted();
      if (packets.colour) colours.set(number, new Blob([packets.colour], {type: 'image/jpeg'}));
      if (number >= 0) check(engine.give());
    }
    fail('The live stream has ended.');
  } catch (error) {
    if (of === opening) faulty(error);
  }
}

// ---- Ticks, and what the page sees

/** Runs the ticks that have elapsed. */
function run_elapsed() {
  if (!clip) return;
  const now = performance.now();
  if (last_ms) owed_ms += now - last_ms;
  last_ms = now;
  const ticks = Math.floor(owed_ms);
  if (ticks < 1) return;
  owed_ms -= ticks;
  const ran = engine.run(ticks);
  if (ran > 0) ticks_us = (1000 * (performance.now() - now)) / ran;
  feed();
}

function look() {
  const at = engine.look() / 8, values = memory(Float64Array, 0);
  const state = {is: 'state', turning, us_per_tick: ticks_us, build_ms, decode_ms, sound: null, pick: null, fingers: []};
  members.forEach((name, k) => { state[name] = values[at + k]; });
  const count = state.fingers;
  state.fingers = [];
  for (let k = 0; k < Math.min(count, 5); ++k) {
    const [is_shown, x, y, goal_x, goal_y, tip_x, tip_y, newtons, touching, share, depth_mm, stiffness, friction] =
      values.subarray(at + members.length + finger_members * k, at + members.length + finger_members * (k + 1));
    if (is_shown)
      state.fingers.push({at: [x, y], goal: [goal_x, goal_y], tip: [tip_x, tip_y], newtons, touching: touching > 0, share, depth_mm, stiffness, friction});
  }
  for (const name of ['playing', 'at_end', 'loops', 'force_on', 'own_view']) state[name] = state[name] > 0;
  if (state.picked >= 0)
    state.pick = {valid: state.picked > 0, depth_m: state.depth_m, stiffness: state.stiffness, friction_static: state.static_friction,
      friction_dynamic: state.dynamic_friction, height_mm: state.height_mm};
  state.matrix = memory(Float32Array, engine.view_matrix(), 16).slice();
  state.rumble = [state.rumble_low, state.rumble_high];
  state.frame = engine.shown_number();
  if (state.sound_samples > 0) {
    state.sound = memory(Float32Array, engine.sound(), 2 * state.sound_samples).slice();
    engine.forget_sound();
  }
  seen = state;
  return state;
}

/** Sends the frame that is to be drawn, if it is another than before. */
async function draw() {
  const number = engine.shown_number();
  if (number < 0 || number === shown) return false;
  shown = number;
  const count = clip.width * clip.height;
  const depths = memory(Float32Array, engine.drawn_depths(), count).slice();
  const message = {is: 'frame', number, depths, haptic: null, heights: null, colour: null}, transfers = [depths.buffer];
  const haptic = engine.drawn_haptic(), heights = engine.drawn_heights();
  const of = clip.planes.haptic && !clip.live ? clip.own('haptic', number) : number;
  if (haptic && haptic_shown !== of) {
    message.haptic = memory(Uint8Array, haptic, 3 * count).slice();
    transfers.push(message.haptic.buffer);
    haptic_shown = of;
  }
  if (heights) {
    message.heights = Float32Array.from(memory(Uint16Array, heights, count));
    transfers.push(message.heights.buffer);
  }
  const colour = clip.planes.colour ? (clip.live ? number : clip.own('colour', number)) : -1;
  if (colour >= 0 && colour !== colour_shown && colours.has(colour)) {
    message.colour = await createImageBitmap(colours.get(colour)).catch(() => null);
    if (message.colour) transfers.push(message.colour);
    colour_shown = colour;
  }
  say(message, transfers);
  return true;
}

/** Runs a script in virtual time, from the clip's beginning, and draws the frames that it meets. */
async function verify({goals, fingers, ticks, commands: asked}) {
  begun();
  put(Float64Array.from([...goals, ...asked.flat()]));
  engine.begin(fingers, goals.length / 3, asked.length);
  const frames = [], us = new Float64Array(ticks);  // what each tick took
  for (let tick = 0; tick < ticks;) {
    const start = performance.now(), ran = engine.run(1);
    us[tick] = 1000 * (performance.now() - start);
    tick += ran;
    if (ran === 0) {
      const frame = engine.wanted();
      if (frame < 0) fail('The clip has no frame for a tick.');
      await give_frame(frame);
    } else if (await draw()) {
      frames.push(shown);
      say(look());
    }
  }
  const hash = text_at(engine.hash());
  reset();
  say({is: 'verified', hash, ticks, frames, us});
}

function reset() {
  turning = false;
  put(new Float64Array(0));
  engine.begin(1, 0, 0);
  begun();
}

function faulty(error) {
  say({is: 'fault', text: error instanceof WebAssembly.RuntimeError ? 'The engine stopped: memory may not suffice for this clip.'
    : String(error?.message ?? error), fatal: !clip || error instanceof WebAssembly.RuntimeError});
}

const work = {
  open, picture: open_picture, verify, reset,
  size: ({width, height}) => engine?.size(width, height),
  event: (e) => {
    run_elapsed();
    engine?.event(event_kinds.indexOf(e.kind), buttons[e.word] ?? 0, e.x, e.y, +!!e.control, +!!e.shift, e.touch | 0, e.seconds ?? 0,
      e.press ?? 0, +turning);
  },
  command: ({name, number}) => {
    if (name === 'turning') turning = !turning;
    else if (commands[name]) check(engine.command(...pad(commands[name](number))));
  },
  due: async (due) => {
    if (!!due.pressed !== pressed) engine.command(13, +(pressed = !!due.pressed), 0);
    run_elapsed();
    await draw();
    say(look());
  },
};
const pad = ([verb, a = 0, b = 0]) => [verb, a, b];

let size = null, queue = Promise.resolve();
onmessage = ({data}) => {
  if (data.do === 'size') size = data;
  // One thing after the other: what opens or verifies a clip is not disturbed.
  queue = queue.then(async () => {
    if (!clip && !['open', 'picture', 'size'].includes(data.do)) return;
    await work[data.do]?.(data);
    if (size && engine && ['open', 'picture', 'verify', 'reset'].includes(data.do)) engine.size(size.width, size.height);
  }).catch(faulty);
};
