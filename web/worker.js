// SPDX-License-Identifier: Apache-2.0
// The worker of the page: it fetches and inflates pictures, gives them to the engine, runs the ticks that have
// elapsed at each event and each picture, and sends what is to be drawn, heard and read. One thread: no memory is
// shared, so any web server will do.

import {PackedClip, live_framesets, refuse} from './clip.js';
import {has_trapped, load_engine, text_of} from './engine.js';
import {unpack_png} from './png.js';

let read_size, engine, table, clip, session, pressed = false, stands_still = false, seen_matrix;

// What is forgotten when a clip begins anew. Work under way for an earlier session ends without a trace.
const new_session = () => ({
  feeding: false, failed: '', shown: -1, ran_until: null, live_stop: new AbortController(),
  taken: {}, sent: {},  // by role the frame whose picture the engine has, and the page (of colour the picture)
  colours: new Map()  // by frame, of those that may still be shown: JPEG, and what it is decoded to, ahead
});

const memory = (type, at, count) => new type(engine.memory.buffer, at, count);
const put = (array) => memory(array.constructor, engine.room(array.byteLength), array.length).set(array);
const text_at = (at) => text_of(engine, at);
const check = (worked) => worked || refuse(text_at(engine.fault()));
const play = (verb, number = 0) => check(engine.play(table.ClockCommand[verb], number));

// `table`: what the engine has by name (page_table in engine.cpp).
async function load(bytes) {
  engine = await load_engine('engine.bin', bytes);
  table = JSON.parse(text_at(engine.table()));
}
// Reads structs of doubles, one behind the other: numbers, and arrays by a member's [length].
function reader(at) {
  const values = memory(Float64Array, at).values(), next = () => values.next().value;
  return (struct) => Object.fromEntries(Array.from(table[struct].matchAll(/(\w+)(?:\[(\d+)\])?/g),
    ([, member, length]) => [member, length ? Array.from({length}, next) : next()]));
}

// ---- Opening

// `gone`: {error, text} if the open clip has lost a file; `text` is its clip.json. If the server still has the same
// clip.json, the error is thrown and is fatal.
async function open({url, files, json, wasm, calm, gone}) {
  stands_still = calm;
  if (gone) clip = undefined;
  const [packed] = await Promise.all([PackedClip.open(files ? json : url, files), engine ?? load(wasm)]);
  if (packed.text === gone?.text) throw gone.error;
  const {times, frames, live, json: {name, remarks, numbers}} = packed;
  if (table.scene !== Object.keys(numbers).join('\n'))
    throw Object.assign(new Error('The clip is of another version than this page. ' +
      "touchable convert --web of the page's version writes one."), {is_final: true});
  put(Float64Array.from([...packed.numbers, ...times]));
  const known_frames = live ? Number.MAX_SAFE_INTEGER : frames;
  check(engine.open_scene(packed.numbers.length, times.length, known_frames, live ? 1 : 0, packed.error_bars_to));
  const rate = numbers['rate.num'] / numbers['rate.den'];
  met(packed, {
    name: String(name ?? ''), remarks: (remarks ?? []).map(String), frames, live: live !== null,
    seconds: times.length ? times.at(-1) / 1e9 + 1 / rate : frames / rate,
    unit: numbers.metres_per_unit, far: numbers['depth.far']
  });
}

// Reads a picture that a person will open, and tells what its levels seem to mean.
async function read({bytes, name}) {
  if (!engine) await load();
  const {width, height, bits, codes} = await unpack_png(bytes);
  put(codes);
  if (!engine.read_picture(width, height, bits)) refuse(`${name} ${text_at(engine.fault())}.`);
  read_size = {width, height};
  postMessage({is: 'asked', name, guess: reader(engine.picture_guess())('PictureGuess')});
}

function open_picture({name, metres, white_near, fov}) {
  check(engine.open_picture(metres, white_near, fov));
  met({...read_size, planes: {}}, {name, remarks: [], frames: 1, seconds: 0, live: false, unit: 1, far: 0});
}

function met(packed, about) {
  clip = packed;
  start();
  postMessage({is: 'clip', width: clip.width, height: clip.height, planes: Object.keys(clip.planes), table, ...about});
}

// A clip begins: it plays and loops, unless the person asked for less motion; a live one is followed.
function start() {
  session?.live_stop.abort();
  session = new_session();
  if (clip.live) follow();
  if (!(clip.frames > 1)) return;
  if (stands_still) play('play_pause');
  play('loop');
}

// ---- Frames

async function give_frame(frame) {
  const of = session;
  for (const role of Object.keys(clip.planes)) {
    const own = clip.own(role, frame);
    if (role === 'colour' ? of.colours.has(own) : of.taken[role] === own) continue;
    const packet = await clip.picture(role, frame);
    if (of !== session) return;
    give_packet(role, own, packet);
  }
  check(engine.give(frame));
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
  check(engine.plane(table.Role[`${role}_role`], bytes_per_sample, channels, packet.length));
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
      else await in_turn(() => of === session && open({url: base, calm: stands_still}));
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
  const frame = engine.shown_number(), next = reader(engine.look());
  const {sound, sound_samples, matrix, fingers, ...state} = next('Shown'), pick = next('ShownPick');
  // Until the first frame after a beginning is there, the picture of before stays.
  if (frame >= 0 || !seen_matrix) seen_matrix = Float32Array.from(matrix);
  return {is: 'state', ...state, frame, pick: pick.valid < 0 ? null : pick, matrix: seen_matrix,
    fingers: Array.from({length: fingers}, () => next('ShownFinger')),
    sound: sound_samples ? memory(Float32Array, sound, sound_samples).slice() : null};
}

const bitmap_of = (jpeg) => createImageBitmap(jpeg).catch(() => null);

// The planes of the frame that is to be drawn, if it is another than before; of these those that have changed.
async function new_planes() {
  const {sent, colours} = session, number = engine.shown_number(), count = clip.width * clip.height;
  if (number < 0 || number === session.shown) return null;
  session.shown = number;
  const [depths, haptic, heights] = Object.values(table.Role).map((role) => engine.drawn(role));
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
  engine.aim();
  postMessage({...look(), planes}, transfers);
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
  open, read, picture: open_picture, reset,
  event({kind, button, x, y, control, shift, touch, seconds, press, turning}) {
    run_elapsed();
    engine.event(table.EventKind[kind], button, x, y, control, shift, touch, seconds, press, turning);
  },
  play({verb, number}) {
    play(verb, number);
    if (session.failed) work.go_on(); // the page's notice may have been closed
  },
  hand: ({verb, a, b}) => engine.hand(table.HandCommand[verb], a, b),
  // After a fault: frames are fetched again from the next tick on, as what was fetched may have been damaged.
  go_on() {
    for (const plane of Object.values(clip.planes)) plane.kept = [];
    session.feeding = false;
  },
  async due({width, height, pressed: presses}) {
    engine.size(width, height);
    if (presses !== pressed) engine.hand(table.HandCommand.press, presses, 0);
    pressed = presses;
    run_elapsed();
    tell(await new_planes());
  }
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
