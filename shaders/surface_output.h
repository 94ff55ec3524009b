// SPDX-License-Identifier: Apache-2.0
// The output of decoding and medians beside codes, for GLSL: validity, and parts of tile bounds.
#ifndef TOUCHABLE_SHADERS_SURFACE_OUTPUT_H
#define TOUCHABLE_SHADERS_SURFACE_OUTPUT_H

layout(set = 0, binding = 2, std430) writeonly buffer Validity { uint out_validity[]; };
/// Of each strip and pair of tiles.
layout(set = 0, binding = 3, std430) writeonly buffer Parts { u64vec2 out_parts[]; };

/// Working codes of all stored ones, two in a word, the lower code in the lower half.
layout(set = 0, binding = 4, std430) readonly buffer Table { uint working_codes[]; };

/// Least and greatest valid code of a stretch of both rows, and whether one is invalid.
struct Bounds {
    uint least, greatest, any_invalid;
};
const Bounds no_bounds = Bounds(greatest_code, 0u, 0u);

Bounds joined(Bounds a, Bounds b) {
    return Bounds(min(a.least, b.least), max(a.greatest, b.greatest), a.any_invalid | b.any_invalid);
}
uint64_t part_of(Bounds bounds) {
    return packUint2x32(uvec2(bounds.least | bounds.greatest << 16, bounds.any_invalid));
}

// Collected by a lane until a word of validity, which is two tiles, is full.
uint upper_word = 0u, lower_word = 0u;
uint upper_later = 0u, lower_later = 0u;  // the next word's first bits
Bounds tile = no_bounds, finished[2];

/// Bits of the pixels k = 0 to 7 in `inside` that are valid.
uint bits_of(bool valid[8], uint inside) {
    if (may_be_invalid == 0u) return inside;
    uint bits = 0u;
    [[unroll]] for (int k = 0; k < 8; ++k) bits |= valid[k] ? 1u << k : 0u;
    return bits & inside;
}

/// Bounds of a pixel in both rows; `upper` and `lower`: whether that row's code counts.
Bounds bounds_of(uint upper_code, uint lower_code, bool upper, bool lower, bool any_invalid) {
    return Bounds(min(upper ? upper_code : greatest_code, lower ? lower_code : greatest_code),
                  max(upper ? upper_code : 0u, lower ? lower_code : 0u), any_invalid ? 1u : 0u);
}

/// WorkingCodes::of, if filters work on these.
uint scaled(uint code) {
    if (to_finer == 0u) return code;
    return looked_up == 0u ? code * push.factor : working_codes[code >> 1u] >> (16u * (code & 1u)) & 0xffffu;
}

Written take(Task task, uint texel, Pixels pixels) {
    const uint inside = inside_bits(texel);
    const uint inside_lower = ragged == 0u || 2u * task.strip + 1u < push.height ? inside : 0u;
    const uint upper = bits_of(pixels.upper_valid, inside), lower = bits_of(pixels.lower_valid, inside_lower);
    const uint invalid = (upper ^ inside) | (lower ^ inside_lower);
    const bool may_not_count = may_be_invalid != 0u || ragged != 0u;

    Written written;
    Bounds before = no_bounds, after = no_bounds, border;  // of pixels before the texel, after, and its first one
    [[unroll]] for (int k = 0; k < 8; ++k) {
        const bool upper_counts = !may_not_count || (upper >> k & 1u) != 0u;
        const bool lower_counts = !may_not_count || (lower >> k & 1u) != 0u;
        const Bounds both = bounds_of(pixels.upper[k], pixels.lower[k], upper_counts, lower_counts,
                                      may_be_invalid != 0u && (invalid >> k & 1u) != 0u);
        if (k < strip_reach) before = joined(before, both);
        else after = joined(after, both);
        if (k == strip_reach) border = both;
        // shaders/terraces.comp knows invalid codes by no_finer_code.
        const uint none = to_finer != 0u ? no_finer_code : 0u;
        written.upper.v[k] = upper_counts ? scaled(pixels.upper[k]) : none;
        written.lower.v[k] = lower_counts ? scaled(pixels.lower[k]) : none;
    }

    const uint shift = 8u * ((texel + 3u) & 3u) + 8u - uint(strip_reach);
    upper_word |= upper << shift;
    lower_word |= lower << shift;
    upper_later = upper >> strip_reach;
    lower_later = lower >> strip_reach;

    const bool at_end = 8u * texel >= push.width;
    if (at_end) border = after = no_bounds;
    const Bounds so_far = joined(tile, before);
    // The second of a tile's two texels comes later, and has the whole.
    const Bounds ended = joined(so_far, border);
    if (((texel - 1u) & 2u) == 0u) finished[0] = ended;
    else finished[1] = ended;
    tile = joined((texel & 1u) == 0u ? no_bounds : so_far, after);
    return written;
}

void finish_word(Task task, uint word) {
    const uint row = 2u * task.strip, at = row * push.validity_words + word;
    out_validity[at] = upper_word;
    if (row + 1u < push.height) out_validity[at + push.validity_words] = lower_word;
    if (to_finer == 0u)
        out_parts[task.strip * push.validity_words + word] = u64vec2(part_of(finished[0]), part_of(finished[1]));
}

void start_word() {
    upper_word = upper_later;
    lower_word = lower_later;
}

#endif
