// SPDX-License-Identifier: Apache-2.0
// The worker of the page: it fetches and inflates pictures, gives them to the engine, runs the ticks that have
// elapsed at each event and each picture, and sends what is to be drawn, heard and read. One thread: no memory is
// shared, so any web server will do.

import {PackedClip, live_framesets, refuse, roles} from './clip.js';
import {has_trapped, load_engine, text_of} from './engine.js';
import {unpack_png} from './png.js';

const event_kinds = ['moved', 'pressed', 'released', 'wheel', 'key', 'key_released', 'resized', 'dropped',
  'left_window', 'touch_began', 'touch_moved', 'touch_ended'];
// Members of Shown in engine.cpp, in this order, and of ShownFinger those behind its places.
const members = ['tick', 'time', 'playing', 'at_end', 'loops', 'speed', 'force_on', 'own_view', 'newtons', 'rumble_low',
  'rumble_high', 'late_frames', 'fingers'];
const pick_members = ['valid', 'depth_m', 'stiffness', 'friction_static', 'friction_dynamic', 'height_mm'];
const finger_members = ['newtons', 'touching', 'share', 'depth_mm', 'stiffness', 'friction', 'error_degrees'];
let read_size, engine, clip, session, pressed = false, stands_still = false, build_ms = 0, decode_ms = 0, seen_matrix;

// What is forgotten when a clip begins anew. Work under way for an earlier session ends without a trace.
const new_session = () => ({
  feeding: false, failed: '', shown: -1, ran_until: null, live_stop: new AbortController(),
  taken: {}, sent: {},  // by role the frame whose picture the engine has, and the page (of colour the picture)
  colours: new Map(),  // by frame, of those that may still be shown: JPEG, and what it is decoded to, ahead
});

const memory = (type, at, count) => new type(engine.memory.buffer, at, count);
function put(array) {
  memory(array.constructor, engine.room(array.byteLength), array.length).set(array);
}
const text_at = (at) => text_of(engine, at);
const check = (worked) => worked || refuse(text_at(engine.fault()));
// `verb`: of ClockCommand in engine.cpp.
const play = (verb, number = 0) => check(engine.play(verb, number));

// ---- Opening

// `gone`: {error, text} if the open clip has lost a file; `text` is its clip.json. If the server still has the same
// clip.json, the error is thrown and is fatal.
async function open({url, files, json, wasm, calm, gone}) {
  stands_still = calm;
  if (gone) clip = undefined;
  let packed;
  [engine, packed] = await Promise.all(
    [engine ?? load_engine('engine.bin', wasm), PackedClip.open(files ? json : url, files)]);
  if (packed.text === gone?.text) throw gone.error;
  const {times, frames, live, json: {name, remarks, numbers}} = packed;
  if (text_at(engine.scene_names()) !== Object.keys(numbers).join('\n'))
    throw Object.assign(new Error('The clip is of another version than this page. ' +
      "touchable convert --web of the page's version writes one."), {is_final: true});
  put(Float64Array.from([...packed.numbers, ...times]));
  const known_frames = live ? Number.MAX_SAFE_INTEGER : frames;
  check(engine.open_scene(packed.numbers.length, times.length, known_frames, live ? 1 : 0, packed.error_bars_to));
  const rate = numbers['rate.num'] / numbers['rate.den'];
  met(packed, {
    name: String(name ?? ''), remarks: (remarks ?? []).map(String), frames, live: live !== null,
    seconds: times.length ? times.at(-1) / 1e9 + 1 / rate : frames / rate,
    unit: numbers.metres_per_unit, far: numbers['depth.far'],
  });
}

// Reads a picture that a person will open, and tells what its levels seem to mean.
async function read({bytes, name}) {
  engine ??= await load_engine('engine.bin');
  const {width, height, bits, codes} = await unpack_png(bytes);
  put(codes);
  if (!engine.read_picture(width, height, bits)) refuse(`${name} ${text_at(engine.fault())}.`);
  const [metres, white_near, least, most, near, far] = memory(Float64Array, engine.picture_guess(), 6);
  read_size = {width, height};
  postMessage({is: 'asked', name, guess: {metres, white_near, least, most, near, far}});
}

function open_picture({name, metres, white_near, fov}) {
  check(engine.open_picture(metres, white_near, fov));
  met({...read_size, planes: {}}, {name, remarks: [], frames: 1, seconds: 0, live: false, unit: 1, far: 0});
}

function met(packed, about) {
  clip = packed;
  start();
  postMessage({is: 'clip', width: clip.width, height: clip.height, planes: Object.keys(clip.planes), ...about});
}

// A clip begins: it plays and loops, unless the person asked for less motion; a live one is followed.
function start() {
  session?.live_stop.abort();
  session = new_session();
  if (clip.live) follow();
  if (!(clip.frames > 1)) return;
  if (stands_still) play(0);
  play(5, 1);
}

// ---- Frames

async function give_frame(frame) {
  const of = session, start = performance.now();
  for (const role of Object.keys(clip.planes)) {
    const own = clip.own(role, frame);
    if (role === 'colour' ? of.colours.has(own) : of.taken[role] === own) continue;
    const packet = await clip.picture(role, frame);
    if (of !== session) return;
    give_packet(role, own, packet);
  }
  const decoded = performance.now();
  check(engine.give(frame));
  decode_ms = decoded - start;
  build_ms = performance.now() - decoded;
  note_well();
}

function give_packet(role, own, packet) {
  if (role === 'colour') {
    const {colours} = session;
    const jpeg = new Blob([packet], {type: 'image/jpeg'});
    colours.set(own, {jpeg, bitmap: bitmap_of(jpeg)});
    if (colours.size > 16) colours.delete(colours.keys().next().value);
    return;
  }
  const {bytes_per_sample, channels} = clip.planes[role];
  put(packet);
  check(engine.plane(roles.indexOf(role), bytes_per_sample, channels, packet.length));
  session.taken[role] = own;
}

// Gives the engine the frames that it wants, one after the other; one such work at a time.
async function feed() {
  const of = session;
  if (of.feeding || clip.live) return;
  of.feeding = true;  // and stays so after a fault, until a person asks to go on: the next frame would have it, too
  try {
    for (let frame; of === session && (frame = engine.wanted()) >= 0;) await give_frame(frame);
    of.feeding = false;
  } catch (error) {
    if (of !== session) return;
    if (!error.is_gone) {
      of.failed = error.message;
      return faulty(error, true);
    }
    const {base: url, text} = clip, calm = stands_still;
    in_turn(() => of === session && open({url, calm, gone: {error, text}})).catch(faulty);
  }
}

// Shows a live clip, and connects again when it breaks off; to another clip if its server has one by then.
async function follow() {
  const of = session, {text, base, live} = clip;
  for (let is_first = true; of === session; is_first = false) {
    try {
      if (is_first || (await PackedClip.open(base)).text === text)
        await show_framesets(live_framesets(new URL(live, base), clip.planes, of.live_stop.signal), of);
      else
        await in_turn(() => of === session && open({url: base, calm: stands_still}));
    } catch (error) {
      if (!error.is_final) error.message += ' The page connects again by itself.';
      if (of === session && of.failed !== error.message) faulty(error);
      of.failed = error.message;
    }
    await new Promise((done) => setTimeout(done, 1000));
  }
}

async function show_framesets(framesets, of) {
  for await (const packets of framesets) {
    if (of !== session) return;
    const number = engine.wanted();
    for (const [role, packet] of Object.entries(packets)) {
      const unpacked = await clip.unpacked(clip.planes[role], packet);
      if (of !== session) return;
      give_packet(role, clip.own(role, number), unpacked);
    }
    if (number >= 0) check(engine.give(number));
    note_well();
  }
}

// Frames come again: the page takes its notice away.
function note_well() {
  if (session.failed) postMessage({is: 'well'});
  session.failed = '';
}

// ---- Ticks, and what the page sees

// Runs the ticks that have elapsed.
function run_elapsed() {
  const now = performance.now(), ticks = Math.floor(now - (session.ran_until ??= now));
  if (ticks < 1) return;
  session.ran_until += ticks;
  check(engine.run(ticks) >= 0);
  feed();
}

function look() {
  const values = memory(Float64Array, engine.look());
  let at = 0;
  const next = (count) => [...values.subarray(at, at += count)];
  const named = (names) => Object.fromEntries(next(names.length).map((value, k) => [names[k], value]));
  const state = {is: 'state', build_ms, decode_ms, frame: engine.shown_number(), ...named(members)};
  const pick = named(pick_members), [sound, samples] = next(2), matrix = next(16);
  const fingers = Array.from({length: Math.min(state.fingers, 5)}, () => {
    const [[shown], at, goal, tip] = [1, 2, 2, 2].map(next);
    return {shown, at, goal, tip, ...named(finger_members)};
  });
  state.fingers = fingers.filter(({shown}) => shown);
  state.pick = pick.valid < 0 ? null : pick;
  // Until the first frame after a beginning is there, the picture of before stays.
  if (state.frame >= 0 || !seen_matrix) seen_matrix = Float32Array.from(matrix);
  state.matrix = seen_matrix;
  state.sound = samples ? memory(Float32Array, sound, samples).slice() : null;
  return state;
}

const bitmap_of = (jpeg) => createImageBitmap(jpeg).catch(() => null);

// The planes of the frame that is to be drawn, if it is another than before; of these those that have changed.
async function new_planes() {
  const {sent, colours} = session, number = engine.shown_number(), count = clip.width * clip.height;
  if (number < 0 || number === session.shown) return null;
  session.shown = number;
  const [depths, haptic, heights] = [0, 1, 2].map((role) => engine.drawn(role));
  const planes = {depths: memory(Float32Array, depths, count).slice()};
  if (haptic && sent.haptic !== clip.own('haptic', number)) {
    sent.haptic = clip.own('haptic', number);
    planes.haptic = memory(Uint8Array, haptic, 3 * count).slice();
  }
  if (heights) planes.heights = memory(Uint16Array, heights, count).slice();
  const picture = clip.planes.colour && colours.get(clip.own('colour', number));
  if (picture && sent.colour !== picture) {
    sent.colour = picture;
    const bitmap = await (picture.bitmap ?? bitmap_of(picture.jpeg));
    picture.bitmap = null;  // it goes to the page
    if (bitmap) planes.colour = bitmap;
  }
  return planes;
}

function tell(planes) {
  const transfers = Object.values(planes ?? {}).map((plane) => plane.buffer ?? plane);
  postMessage({...look(), planes}, transfers);
}

// Runs a script in virtual time, from the clip's beginning, and draws the frames that it meets.
async function verify({goals, fingers, ticks, commands: asked}) {
  session = new_session();
  put(Float64Array.from([...goals, ...asked.flat()]));
  engine.begin(fingers, goals.length / 3, asked.length);
  const frames = [], us = new Float64Array(ticks);  // what each tick took
  for (let tick = 0; tick < ticks;) {
    const start = performance.now(), ran = engine.run(1);
    check(ran >= 0);
    us[tick] = 1000 * (performance.now() - start);
    tick += ran;
    if (ran === 0) {
      const frame = engine.wanted();
      if (frame < 0) refuse('The clip has no frame for a tick.');
      await give_frame(frame);
      continue;
    }
    const planes = await new_planes();
    if (!planes) continue;
    frames.push(session.shown);
    tell(planes);
  }
  const hash = text_at(engine.hash());
  reset();
  postMessage({is: 'verified', hash, ticks, frames, us});
}

function reset() {
  engine.begin(1, 0, 0);
  start();
}

// `again`: whether the page may ask to go on.
function faulty(error, again = false) {
  const trapped = has_trapped(error);
  if (trapped || error.is_final) engine = clip = session = undefined;
  const text = trapped ? 'The engine stopped: memory may not suffice for this clip.' : error.message;
  postMessage({is: 'fault', text, fatal: !clip, again});
}

const work = {
  open, read, picture: open_picture, verify, reset,
  event({kind, button, x, y, control, shift, touch, seconds, press, turning}) {
    run_elapsed();
    engine.event(event_kinds.indexOf(kind), button, x, y, control, shift, touch, seconds, press, turning);
  },
  play({verb, number}) {
    play(verb, number);
    if (session.failed) work.go_on(); // the page's notice may have been closed
  },
  hand: ({verb, a, b}) => engine.hand(verb, a, b),
  // After a fault: frames are fetched again from the next tick on, as what was fetched may have been damaged.
  go_on() {
    for (const plane of Object.values(clip.planes)) plane.kept = [];
    session.feeding = false;
  },
  async due({width, height, pressed: presses}) {
    engine.size(width, height);
    if (presses !== pressed) engine.hand(7, presses, 0);  // HandCommand::press
    pressed = presses;
    run_elapsed();
    tell(await new_planes());
  },
};

let queue = Promise.resolve();
// One thing after the other: what opens or verifies a clip is not disturbed. The caller handles a job's fault.
function in_turn(job) {
  const done = queue.then(job);
  queue = done.catch(() => {});
  return done;
}
onmessage = ({data}) => in_turn(async () => {
  if (clip || ['open', 'read', 'picture'].includes(data.do)) await work[data.do]?.(data);
}).catch(faulty);
