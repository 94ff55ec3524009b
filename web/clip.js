// SPDX-License-Identifier: Apache-2.0
// A packed clip, read by parts: clip.json, and of each plane a file of packets (docs/web.md).
//
// A PackedClip gives the packets of a frame, inflated. It fetches runs of packets by Range, and takes all of a file
// from a server that ignores Range. A clip that differs from its clip.json is an Error with a sentence for people.
// clip.json is asked for anew each time; the files that it names may come from any cache, as their names change with
// what they hold.

const most_frames = 1e6, most_side = 16384, most_pixels = 1 << 25;
const first_bytes = 1 << 16, run_bytes = 1 << 20, most_kept = 64 << 20, most_whole = 256 << 20;
const roles = ['depth', 'haptic', 'height', 'colour'];

const is_whole = (value, least, most) => Number.isInteger(value) && value >= least && value <= most;

// `sentence`: for people.
export function refuse(sentence) {
  throw new Error(sentence);
}

// A function that refuses what does not hold, by sentences that begin so.
export const requiring = (begin) => (condition, what) => condition || refuse(`${begin}: ${what}.`);
const require = requiring('The clip is damaged, or was changed');

// `least`: pixels a side.
export function check_size(width, height, least) {
  if (![width, height].every((side) => is_whole(side, least, most_side)) || width * height > most_pixels)
    refuse(`The picture has ${width} x ${height} pixels. This page takes ${least} x ${least} to ` +
      `${most_pixels / 1e6 | 0} million pixels, at most ${most_side} a side.`);
}

// What `read` takes of a server's answer; an Error with a sentence if there is none, or if it breaks off. It `is_gone`
// if the server has no such file.
export async function answer_of(url, name, read, options) {
  let answer;
  try {
    answer = await fetch(url, options);
    if (answer.ok) return await read(answer);
  } catch {
    refuse(`The server does not answer, or broke off in the middle of ${name}.`);
  }
  const is_gone = answer.status === 404 || answer.status === 410;
  throw Object.assign(new Error(`There is no ${name}: the server answers ${answer.status}.`), {is_gone});
}

// Takes exact numbers of bytes from a stream.
export class ByteReader {
  constructor(stream) {
    this.reader = stream.getReader();
    this.rest = new Uint8Array(0);
  }

  // Fills `bytes` from `at` on, and answers where it ended: before their end if the stream ends there.
  async fill(bytes, at = 0) {
    while (at < bytes.length && await this.has_more()) {
      const part = this.rest.subarray(0, bytes.length - at);
      bytes.set(part, at);
      at += part.length;
      this.rest = this.rest.subarray(part.length);
    }
    return at;
  }

  async has_more() {
    while (this.rest.length === 0) {
      const {value, done} = await this.reader.read();
      if (done) return false;
      this.rest = value;
    }
    return true;
  }

  cancel() {
    this.reader.cancel().catch(() => {});
  }
}

// What the pieces inflate to, as a stream.
export const inflating = (pieces, format = 'deflate-raw') =>
  new Blob(pieces).stream().pipeThrough(new DecompressionStream(format));

// Fills `whole`, from `at` on, with what the pieces inflate to, and answers where that ended. 0: they are damaged, or
// inflate to more; then no more is taken in.
export async function inflate_into(whole, at, pieces, format) {
  const reader = new ByteReader(inflating(pieces, format));
  const filled = async () => [await reader.fill(whole, at), await reader.has_more()];
  const [end, has_more] = await filled().catch(() => [0, false]);
  reader.cancel();
  return has_more ? 0 : end;
}

export class PackedClip {
  // `place`: the URL of clip.json, or with `files` its text; `files`: the planes' files as Blobs, by name.
  static async open(place, files) {
    const clip = Object.assign(new PackedClip(), {files, base: place});
    clip.text = files ? place : await answer_of(place, 'clip.json', (answer) => answer.text(), {cache: 'no-cache'});
    try {
      clip.json = JSON.parse(clip.text);
    } catch {
      refuse('This is no packed clip: its clip.json is no JSON. touchable convert CLIP FOLDER --web writes one.');
    }
    clip.check();
    return clip;
  }

  check() {
    const {json} = this, {numbers, planes} = json ?? {};
    if (![1, 2].includes(json?.touchable_packed))
      refuse('This is no packed clip that this page knows: its clip.json does not say "touchable_packed": 1 or 2.');
    require(numbers && typeof numbers === 'object' && planes && typeof planes === 'object', 'it has no scene');
    this.numbers = Float64Array.from(Object.values(numbers), (value) => (value === null ? NaN : value));
    const {width, height} = Object.assign(this, {width: numbers.width, height: numbers.height});
    check_size(width, height, 1);
    this.live = typeof json.live === 'string' ? json.live : null;
    require(this.live === null || /^[\w-]+$/.test(this.live), 'its live stream is not beside it');
    this.frames = this.live ? 0 : json.frames;
    require(this.live || is_whole(this.frames, 1, most_frames), 'it does not say how many frames it has');
    this.times = json.times_ns ?? [];
    require(Array.isArray(this.times) && [0, this.frames].includes(this.times.length) &&
      this.times.every((time) => is_whole(time, 0, Number.MAX_SAFE_INTEGER)), 'its times are not one for each frame');
    const {error_bars_to: to = 0} = json;  // null: everywhere
    require(to === null || Number.isFinite(to), 'it does not say how far its error bars hold');
    this.error_bars_to = to ?? Infinity;
    this.planes = {};
    for (const role of roles)
      if (planes[role]) this.planes[role] = this.plane_of(role, planes[role]);
    require(this.planes.depth, 'it has no depth');
  }

  plane_of(role, {file, bytes_per_sample, channels, kind, sizes}) {
    const plane = {role, file, bytes_per_sample, channels, ends: [], own: [], kept: []};
    const is_known = role === 'colour' ? kind === 'image/jpeg'
      : is_whole(bytes_per_sample, 1, 2) && (channels === 1 || (channels === 3 && bytes_per_sample === 1));
    require(is_known, `${role} is of no form that this page knows`);
    const own_name = new RegExp(`^${role}(-[0-9a-f]{16})?\\.bin$`);  // with a hash of what it holds
    require(own_name.test(file), `${role} names a file that is not its own`);
    if (this.live) return plane;
    // Of colour as much as without a code; of others an eighth more.
    const samples = this.width * this.height * (channels ?? 3), most = 2.25 * (samples + 65536) + 1024;
    require(Array.isArray(sizes) && sizes.length === this.frames && sizes[0] > 0 &&
      sizes.every((size) => is_whole(size, 0, most)), `${role} has no packet for each frame`);
    sizes.forEach((size, frame) => {
      plane.own.push(size > 0 ? frame : plane.own.at(-1));
      plane.ends.push((plane.ends.at(-1) ?? 0) + size);
    });
    return plane;
  }

  // The number of the frame whose packet this frame shows: the same for frames that show one picture. A live clip
  // shows the newest colour.
  own(role, frame) {
    if (this.live) return role === 'colour' ? 'newest' : frame;
    return this.planes[role].own[frame];
  }

  // Bytes from `at` on of a plane's file, from what is kept, or fetched with what follows.
  async bytes(plane, at, size) {
    const holds = (run) => run.at <= at && at + size <= run.at + run.bytes.length;
    let run = plane.kept.find(holds);
    if (!run) {
      run = await this.fetched(plane, at, size);
      require(holds(run), `${plane.file} is shorter than it says`);
      plane.kept.push(run);
      const kept = () => plane.kept.reduce((sum, {bytes}) => sum + bytes.length, 0);
      while (plane.kept.length > 1 && kept() > most_kept) plane.kept.shift();
    }
    return run.bytes.subarray(at - run.at, at - run.at + size);
  }

  async fetched(plane, at, wanted) {
    const length = plane.ends.at(-1), run = plane.kept.length ? run_bytes : first_bytes;
    const end = Math.min(length, at + Math.max(wanted, run));
    if (this.files) return {at, bytes: new Uint8Array(await this.files[plane.file]?.slice(at, end).arrayBuffer())};
    return answer_of(new URL(plane.file, this.base), plane.file, async (answer) => {
      // A server without ranges answers 200 and sends all, which is kept.
      const [from, size] = answer.status === 206 ? [at, end - at] : [0, length];
      require(size <= most_whole, `${plane.file} is too large for a server that knows no ranges`);
      const bytes = new Uint8Array(size), reader = new ByteReader(answer.body);
      const got = await reader.fill(bytes);
      reader.cancel();
      return {at: from, bytes: bytes.subarray(0, got)};
    }, {headers: {Range: `bytes=${at}-${end - 1}`}});
  }

  // A packet with its content inflated; of colour the packet as it is.
  async picture(role, frame) {
    const plane = this.planes[role], own = plane.own[frame], begin = own > 0 ? plane.ends[own - 1] : 0;
    return this.unpacked(plane, await this.bytes(plane, begin, plane.ends[own] - begin));
  }

  async unpacked(plane, packet) {
    if (plane.role === 'colour') return packet;
    const samples = this.width * this.height * plane.channels;
    const whole = new Uint8Array(3 + 2 * (Math.min(samples, 65536) + samples));
    // In version 1 the head is not deflated, and deflate has no checksum.
    const plain = this.json.touchable_packed > 1 ? 0 : packet[0] === 0 ? 1 : 3;
    whole.set(packet.subarray(0, plain));
    const end = await inflate_into(whole, plain, [packet.subarray(plain)], plain ? 'deflate-raw' : 'deflate');
    const head = whole[0] === 0 ? 1 : 3, distinct = head === 3 ? 1 + whole[1] + (whole[2] << 8) : 0;
    require(end === head + 2 * (distinct + samples) && whole[0] <= 2, 'a picture does not inflate to its size');
    return whole.subarray(0, end);
  }
}

// Framesets of a live source, as they come: packets by role.
export async function* live_framesets(url, planes, signal) {
  const reader = await answer_of(url, 'live stream', (answer) => new ByteReader(answer.body), {signal});
  const taken = async (size) => {
    const bytes = new Uint8Array(size);
    return await reader.fill(bytes).catch(() => 0) === size ? bytes : refuse('The live stream broke off.');
  };
  try {
    for (;;) {
      const view = new DataView((await taken(24)).buffer), packets = {};
      const sizes = roles.map((_, k) => view.getUint32(4 * k, true));
      require(sizes.every((size) => size <= 1 << 28), 'the live stream is no stream of framesets');
      for (const [k, role] of roles.entries()) {
        const packet = await taken(sizes[k]);
        if (planes[role] && sizes[k] > 0) packets[role] = packet;
      }
      yield packets;
    }
  } finally {
    reader.cancel();
  }
}
