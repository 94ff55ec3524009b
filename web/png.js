// Reads a grey PNG of 8 or 16 bits without the browser's own decoder, which keeps only 8 bits.
//
//     const {width, height, bits, codes} = await unpack_png(bytes);   // codes: Uint16Array, row by row
//
// Throws an Error whose message is a sentence for people. Runs in pages, workers and Node. Nothing is allocated
// before the sizes in the file are known to be within the limits.

import {ByteReader, inflating, refuse} from './clip.js';

const most_pixels = 33e6, longest_side = 16384;
const signature = [137, 80, 78, 71, 13, 10, 26, 10];

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
    const view = new DataView(file.buffer, file.byteOffset, file.byteLength), data = [];
    if (!signature.every((byte, k) => file[k] === byte)) refuse('This file is not a PNG picture.');
    let header = null, at = 8;
    for (;;) {
        if (at + 12 > file.length) refuse('This PNG breaks off before its end.');
        const length = view.getUint32(at), name = String.fromCharCode(...file.subarray(at + 4, at + 8));
        if (length > file.length - at - 12) refuse('This PNG breaks off before its end.');
        if (crc_of(file.subarray(at + 4, at + 8 + length)) !== view.getUint32(at + 8 + length))
            refuse('This PNG is damaged: a checksum is wrong.');
        const body = file.subarray(at + 8, at + 8 + length);
        if ((name === 'IHDR') !== !header) refuse('This PNG is damaged: its header is not where it belongs.');
        if (name === 'IHDR') header = header_of(body);
        else if (name === 'IDAT') data.push(body);  // usually of 8 KB or more; a million of them is an attack
        else if (name === 'IEND') break;
        else if (!(file[at + 4] & 32) && name !== 'PLTE') refuse('This PNG has a part that this page does not know.');
        if (data.length > 1e5) refuse('This PNG is cut into too many pieces.');
        at += 12 + length;
    }
    if (!data.length) refuse('This PNG holds no picture.');
    return {...header, data};
}

function header_of(body) {
    if (body.length !== 13) refuse('This PNG is damaged: its header has a wrong size.');
    const view = new DataView(body.buffer, body.byteOffset, 13);
    const width = view.getUint32(0), height = view.getUint32(4);
    const [bits, kind, method, filter, interlace] = body.subarray(8);
    const other = {2: 'in colour (RGB)', 3: 'in colour (a palette)', 4: 'grey with transparency',
                   6: 'in colour with transparency'}[kind];
    if (other) refuse(`This PNG is ${other}. A depth picture is grey, with 16 bits and without transparency.`);
    if (kind !== 0 || (bits !== 8 && bits !== 16))
        refuse(`This PNG has ${bits} bits a pixel. A depth picture is grey, with 16 (or 8) bits.`);
    if (method || filter || interlace > 1) refuse('This PNG uses a method that this page does not know.');
    if (interlace) refuse('This PNG is interlaced. Save it without interlacing.');
    if (width < 2 || height < 2 || width > longest_side || height > longest_side || width * height > most_pixels)
        refuse(`This PNG has ${width} x ${height} pixels. The page takes 2 x 2 to 33 million pixels, ` +
               `at most ${longest_side} a side.`);
    return {width, height, bits};
}

// Exactly `size` bytes of zlib data; a stream that gives more is cancelled at once.
async function inflated(pieces, size) {
    const result = new Uint8Array(size), reader = new ByteReader(inflating(pieces, 'deflate'));
    const damaged = () => refuse('This PNG is damaged: its picture cannot be unpacked.');
    if (await reader.fill(result).catch(damaged) < size) refuse('This PNG breaks off before its end.');
    const has_more = await reader.has_more().catch(damaged);
    reader.cancel();
    if (has_more) refuse('This PNG is damaged: it unpacks to more than its header says.');
    return result;
}

export async function unpack_png(bytes) {
    if (!globalThis.DecompressionStream) refuse('This browser cannot unpack pictures (DecompressionStream).');
    const {width, height, bits, data} = chunks_of(new Uint8Array(bytes)), step = bits / 8, row = width * step;
    const packed = await inflated(data, (row + 1) * height), codes = new Uint16Array(width * height);
    let above = new Uint8Array(row);
    for (let y = 0; y < height; ++y) {
        const filter = packed[y * (row + 1)], line = packed.subarray(y * (row + 1) + 1, (y + 1) * (row + 1));
        if (filter > 4) refuse('This PNG is damaged: a row has an unknown filter.');
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
    return {width, height, bits, codes};
}
