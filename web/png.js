// SPDX-License-Identifier: Apache-2.0
// Reads a grey PNG of 8 or 16 bits without the browser's own decoder, which keeps only 8 bits.
//
//     const {width, height, codes} = await unpack_png(bytes);   // codes: Uint8Array or Uint16Array
//
// Throws an Error whose message is a sentence for people. Runs in pages, workers and Node. Nothing is allocated
// before the sizes in the file are known to be within the limits.

import {check_size, inflate_into, refuse, requiring} from './clip.js';

const signature = [137, 80, 78, 71, 13, 10, 26, 10];
const kinds = {0: 'grey', 2: 'in colour (RGB)', 3: 'in colour (a palette)', 4: 'grey with transparency',
  6: 'in colour with transparency'};
const require = requiring('This PNG is damaged');

const crc_table = Uint32Array.from({length: 256}, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});
function crc_of(bytes) {
  let crc = 0xffffffff;
  for (let k = 0; k < bytes.length; ++k) crc = crc_table[(crc ^ bytes[k]) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

// The header's sizes, and the compressed data as pieces of the file.
function chunks_of(file) {
  const view = new DataView(file.buffer), data = [];
  if (!signature.every((byte, k) => file[k] === byte)) refuse('This file is not a PNG picture.');
  let header = null, name = '';
  for (let at = 8, length; name !== 'IEND'; at += 12 + length) {
    const fits = at + 12 <= file.length && at + 12 + view.getUint32(at) <= file.length;
    require(fits, 'it breaks off before its end');
    length = view.getUint32(at);
    name = String.fromCharCode(...file.subarray(at + 4, at + 8));
    const body = file.subarray(at + 8, at + 8 + length), crc = view.getUint32(at + 8 + length);
    require(crc_of(file.subarray(at + 4, at + 8 + length)) === crc, 'a checksum is wrong');
    require((name === 'IHDR') === !header, 'its header is not where it belongs');
    if (name === 'IHDR') header = header_of(body);
    else if (name === 'IDAT') data.push(body);  // usually of 8 KB or more; a million of them is an attack
    else if (!(file[at + 4] & 32) && !['PLTE', 'IEND'].includes(name))
      refuse('This PNG has a part that this page does not know.');
    if (data.length > 1e5) refuse('This PNG is cut into too many pieces.');
  }
  return {...header, data};
}

function header_of(body) {
  require(body.length === 13, 'its header has a wrong size');
  const view = new DataView(body.buffer, body.byteOffset), width = view.getUint32(0), height = view.getUint32(4);
  const [bits, kind, method, filter, interlace] = body.subarray(8);
  if (kind !== 0 || (bits !== 8 && bits !== 16))
    refuse(`This PNG has ${bits} bits and is ${kinds[kind] ?? 'of an unknown kind'}. A depth picture is grey, ` +
      'with 16 (or 8) bits and without transparency.');
  if (method || filter || interlace)
    refuse('This PNG is interlaced, or uses a method that this page does not know. Save it without interlacing.');
  check_size(width, height, 2);  // fewer have no surface
  return {width, height, step: bits / 8};
}

export async function unpack_png(bytes) {
  const {width, height, step, data} = chunks_of(new Uint8Array(bytes)), row = width * step;
  const packed = new Uint8Array((row + 1) * height), codes = new (step === 2 ? Uint16Array : Uint8Array)(width * height);
  const end = await inflate_into(packed, 0, data, 'deflate');
  require(end === packed.length, 'its picture does not unpack to its size');
  let above = new Uint8Array(row);
  for (let y = 0; y < height; ++y) {
    const filter = packed[y * (row + 1)], line = packed.subarray(y * (row + 1) + 1, (y + 1) * (row + 1));
    require(filter <= 4, 'a row has an unknown filter');
    for (let k = 0; filter && k < row; ++k) {
      const left = k < step ? 0 : line[k - step], up = above[k];
      if (filter === 1) line[k] += left;
      else if (filter === 2) line[k] += up;
      else if (filter === 3) line[k] += (left + up) >> 1;
      else {
        const corner = k < step ? 0 : above[k - step], guess = left + up - corner;
        const a = Math.abs(guess - left), b = Math.abs(guess - up), c = Math.abs(guess - corner);
        line[k] += a <= b && a <= c ? left : b <= c ? up : corner;
      }
    }
    for (let x = 0, to = y * width; x < width; ++x, ++to)
      codes[to] = step === 2 ? (line[2 * x] << 8) | line[2 * x + 1] : line[x];
    above = line;
  }
  return {width, height, bits: 8 * step, codes};
}
