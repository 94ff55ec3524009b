// A packed clip, read by parts: clip.json, and of each plane a file of packets (docs/web.md).
//
// A PackedClip gives the packets of a frame, inflated. It fetches runs of packets by Range, and takes all of a file
// from a server that ignores Range. Whatever is not as clip.json says is an Error with a sentence for people.

const most_frames = 1e6, most_side = 16384, most_pixels = 1 << 25, run_bytes = 1 << 20, most_kept = 64 << 20;
const roles = ['depth', 'haptic', 'height', 'colour'];

export const is_whole = (value, least, most) => Number.isInteger(value) && value >= least && value <= most;

function require(condition, what) {
  if (!condition) throw new Error(`The clip is damaged, or was changed: ${what}.`);
}

/** What `read` takes of a server's answer; an Error with a sentence if there is none, or if it breaks off. */
export async function answer_of(url, name, read, options) {
  let answer;
  try {
    answer = await fetch(url, options);
    if (answer.ok) return await read(answer);
  } catch {
    throw new Error(`The server does not answer, or broke off in the middle of ${name}. Reload the page to try again.`);
  }
  throw new Error(`There is no ${name}: the server answers ${answer.status}.`);
}

/** Inflates raw deflate to exactly `size` bytes behind `head`, and takes no more in. */
async function inflated(packet, head, size) {
  const whole = new Uint8Array(head + size);
  whole.set(packet.subarray(0, head));
  const reader = new Blob([packet.subarray(head)]).stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader();
  let at = head;
  try {
    for (;;) {
      const {value, done} = await reader.read();
      if (done) break;
      if (at + value.length > whole.length) break;
      whole.set(value, at);
      at += value.length;
    }
  } catch {
    at = 0;
  }
  reader.cancel().catch(() => {});
  require(at === whole.length, 'a picture does not inflate to its size');
  return whole;
}

export class PackedClip {
  /** `place`: the URL of clip.json, or with `files` its text; `files`: the planes' files as Blobs, by name. */
  static async open(place, files, told) {
    const clip = new PackedClip();
    clip.told = told;
    clip.files = files;
    let text = place;
    if (!files) {
      clip.base = place;
      text = await answer_of(place, 'clip.json', (answer) => answer.text());
    }
    try {
      clip.json = JSON.parse(text);
    } catch {
      throw new Error('This is no packed clip: its clip.json is no JSON. touchable convert CLIP FOLDER --web writes one.');
    }
    clip.check();
    return clip;
  }

  check() {
    const {json} = this;
    if (json?.touchable_packed !== 1)
      throw new Error('This is no packed clip that this page knows: its clip.json does not say "touchable_packed": 1.');
    require(json.numbers && typeof json.numbers === 'object' && json.planes && typeof json.planes === 'object', 'it has no scene');
    this.numbers = Float64Array.from(Object.values(json.numbers), (value) => (value === null ? NaN : value));
    this.width = json.numbers.width;
    this.height = json.numbers.height;
    require(is_whole(this.width, 1, most_side) && is_whole(this.height, 1, most_side), 'its size is none');
    if (this.width * this.height > most_pixels)
      throw new Error(`The clip's pictures are ${this.width} x ${this.height}: this page shows up to ${most_pixels / 1e6 | 0} million pixels.`);
    this.live = typeof json.live === 'string' ? json.live : null;
    this.frames = this.live ? 0 : json.frames;
    require(this.live || is_whole(this.frames, 1, most_frames), 'it does not say how many frames it has');
    this.times = json.times_ns ?? [];
    require(Array.isArray(this.times) && (this.times.length === 0 || this.times.length === this.frames) &&
            this.times.every((time) => is_whole(time, 0, Number.MAX_SAFE_INTEGER)), 'its times are not one for each frame');
    this.planes = {};
    for (const role of roles) {
      const said = json.planes[role];
      if (said) this.planes[role] = this.plane_of(role, said);
    }
    require(this.planes.depth, 'it has no depth');
  }

  plane_of(role, said) {
    const plane = {role, file: said.file, bytes_per_sample: said.bytes_per_sample, channels: said.channels, kind: said.kind};
    require(role === 'colour' ? plane.kind === 'image/jpeg'
        : is_whole(plane.bytes_per_sample, 1, 2) && (plane.channels === 1 || (plane.channels === 3 && plane.bytes_per_sample === 1)),
    `${role} is of no form that this page knows`);
    require(plane.file === `${role}.bin`, `${role} names a file that is not its own`);
    if (this.live) return plane;
    require(Array.isArray(said.sizes) && said.sizes.length === this.frames && said.sizes[0] > 0 &&
            said.sizes.every((size) => is_whole(size, 0, 1 << 30)), `${role} has no packet for each frame`);
    plane.ends = [];
    plane.own = [];
    let end = 0, own = 0;
    said.sizes.forEach((size, frame) => {
      if (size > 0) own = frame;
      plane.own.push(own);
      plane.ends.push(end += size);
    });
    plane.kept = [];
    return plane;
  }

  /** The number of the frame whose packet this frame shows: the same for frames that show one picture. */
  own(role, frame) {
    return this.planes[role].own[frame];
  }

  /** Bytes from `at` on of a plane's file, from what is kept, or fetched with what follows. */
  async bytes(plane, at, size) {
    const holds = (run) => run.at <= at && at + size <= run.at + run.bytes.length;
    let run = plane.kept.find(holds);
    if (!run) {
      run = await this.fetched(plane, at, size);
      require(holds(run), `${plane.file} is shorter than it says`);
      plane.kept.push(run);
      for (let bytes = 0, k = plane.kept.length - 1; k >= 0; --k) {
        bytes += plane.kept[k].bytes.length;
        if (bytes > most_kept && k < plane.kept.length - 1) plane.kept.splice(k, 1);
      }
    }
    return run.bytes.subarray(at - run.at, at - run.at + size);
  }

  async fetched(plane, at, size) {
    const length = plane.ends.at(-1), end = Math.min(length, at + Math.max(size, run_bytes));
    if (this.files) {
      const blob = this.files[plane.file];
      require(blob, `${plane.file} is not there`);
      return {at, bytes: new Uint8Array(await blob.slice(at, end).arrayBuffer())};
    }
    const range = {headers: {Range: `bytes=${at}-${end - 1}`}};
    const answer = await answer_of(new URL(plane.file, this.base), plane.file, (one) => one, range);
    // A server without ranges answers 200 and sends all, which is kept.
    const from = answer.status === 206 ? at : 0, expected = answer.status === 206 ? end - at : length;
    return {at: from, bytes: await this.body(answer, expected, plane.file)};
  }

  async body(answer, expected, file) {
    const bytes = new Uint8Array(expected), reader = answer.body.getReader();
    let got = 0;
    for (;;) {
      let part;
      try {
        part = await reader.read();
      } catch {
        throw new Error(`The server broke off in the middle of ${file}. Reload the page to try again.`);
      }
      if (part.done) break;
      const value = part.value.subarray(0, expected - got);
      bytes.set(value, got);
      got += value.length;
      this.told?.(got, expected, file);
      if (got === expected) {
        reader.cancel().catch(() => {});
        break;
      }
    }
    require(got === expected, `${file} is shorter than it says`);
    return bytes;
  }

  /** A packet with its content inflated; of colour the packet as it is. */
  async picture(role, frame) {
    const plane = this.planes[role], own = plane.own[frame], begin = own > 0 ? plane.ends[own - 1] : 0;
    return this.unpacked(plane, await this.bytes(plane, begin, plane.ends[own] - begin));
  }

  async unpacked(plane, packet) {
    if (plane.role === 'colour') return packet;
    const head = packet[0] === 0 ? 1 : 3, distinct = head === 3 ? 1 + packet[1] + (packet[2] << 8) : 0;
    const samples = this.width * this.height * plane.channels;
    require(packet[0] <= 2 && packet.length > head && distinct <= samples, 'a packet has no head');
    return inflated(packet, head, 2 * (distinct + samples));
  }
}

/** Framesets of a live source, as they come: {time_ns, packets: {role: bytes}}. */
export async function* live_framesets(url, planes, signal) {
  const answer = await answer_of(url, 'live stream', (one) => one, {signal});
  const reader = answer.body.getReader(), order = ['depth', 'haptic', 'height', 'colour'];
  const waiting = [];
  let there = 0;
  const take = async (count) => {
    while (there < count) {
      const {value, done} = await reader.read();
      if (done) return null;
      waiting.push(value);
      there += value.length;
    }
    const all = new Uint8Array(there);
    let at = 0;
    for (const part of waiting) all.set(part, at), at += part.length;
    waiting.length = 0;
    if (there > count) waiting.push(all.subarray(count));
    there -= count;
    return all.subarray(0, count);
  };
  for (;;) {
    const head = await take(24);
    if (!head) return;
    const view = new DataView(head.buffer, head.byteOffset, 24), packets = {};
    const sizes = order.map((_, k) => view.getUint32(4 * k, true));
    require(sizes.every((size) => size <= 1 << 28), 'the live stream is no stream of framesets');
    for (const [k, role] of order.entries()) {
      if (sizes[k] === 0) continue;
      const packet = await take(sizes[k]);
      if (!packet) return;
      if (planes[role]) packets[role] = packet;
    }
    yield {time_ns: view.getFloat64(16, true), packets};
  }
}
