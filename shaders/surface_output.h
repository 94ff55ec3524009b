// What the last stage of every frame writes, for GLSL: codes, validity, and parts of tile bounds.
#ifndef TOUCHABLE_SHADERS_SURFACE_OUTPUT_H
#define TOUCHABLE_SHADERS_SURFACE_OUTPUT_H

layout(set = 0, binding = 1, scalar) writeonly buffer Codes { u64vec2 out_codes[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Validity { uint out_validity[]; };
/// Of each strip and tile; and of the first row alone of each strip that starts a tile, for the tile above.
layout(set = 0, binding = 3, scalar) writeonly buffer Parts { uint64_t out_parts[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Tops { uint64_t out_tops[]; };

/// Least and greatest valid code of a stretch of a row, and whether one is invalid.
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

/// A texel of a row as it is written, with its bounds.
struct Finished {
    u64vec2 codes;
    uint validity;
    Bounds bounds;
};

Finished finish(uint codes[8], bool valid[8], uint inside) {
    Finished done;
    uint masked[8];
    done.bounds = no_bounds;
    done.validity = 0u;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        bool counts = valid[k];
        if (ragged != 0u) counts = counts && (inside >> k & 1u) != 0u;
        masked[k] = counts ? codes[k] : 0u;
        done.bounds.greatest = max(done.bounds.greatest, masked[k]);
        done.bounds.least = min(done.bounds.least, counts ? codes[k] : greatest_code);
        done.validity |= counts ? 1u << k : 0u;
    }
    if (before_terraces != 0u) {  // for shaders/terraces.comp, which tells invalid codes by their own
        [[unroll]] for (int k = 0; k < 8; ++k) masked[k] = (done.validity >> k & 1u) != 0u ? codes[k] * push.factor : no_finer_code;
    }
    done.codes = packed(masked);
    done.bounds.any_invalid = done.validity ^ inside;
    return done;
}

/// Of the first pixel of the next texel: the last column of the tile before it.
Bounds bounds_of(uint code, bool valid) {
    return Bounds(valid ? code : greatest_code, valid ? code : 0u, valid ? 0u : 1u);
}

// What a lane gathers until a tile or a word of validity is full.
Bounds upper_bounds = no_bounds, lower_bounds = no_bounds;
uint upper_word = 0u, lower_word = 0u;

void emit_tile(Task task, uint tile, bool two_rows) {
    const Bounds both = two_rows ? joined(upper_bounds, lower_bounds) : upper_bounds;
    out_parts[task.strip * push.tiles_x + tile] = part_of(both);
    if (task.strip % strips_per_tile == 0u)
        out_tops[task.strip / strips_per_tile * push.tiles_x + tile] = part_of(upper_bounds);
    upper_bounds = lower_bounds = no_bounds;
}

void emit(Task task, uint texel, Pixels pixels, Pixels next) {
    const uint row = 2u * task.strip, texels = (push.width + 7u) >> 3, inside = inside_bits(texel);
    const bool two_rows = row + 1u < push.height, last = texel + 1u == texels;
    const Finished upper = finish(pixels.upper, pixels.upper_valid, inside);
    const Finished lower = finish(pixels.lower, pixels.lower_valid, inside);
    out_codes[row * push.out_pitch + texel] = upper.codes;
    if (two_rows) out_codes[(row + 1u) * push.out_pitch + texel] = lower.codes;

    upper_word |= upper.validity << 8u * (texel & 3u);
    lower_word |= lower.validity << 8u * (texel & 3u);
    if ((texel & 3u) == 3u || last) {
        const uint word = texel >> 2;
        out_validity[row * push.validity_words + word] = upper_word;
        if (two_rows) out_validity[(row + 1u) * push.validity_words + word] = lower_word;
        upper_word = lower_word = 0u;
    }

    upper_bounds = joined(upper_bounds, upper.bounds);
    lower_bounds = joined(lower_bounds, lower.bounds);
    if ((texel & 1u) == 1u || last) {
        if (!last) {
            const int first = strip_reach;
            upper_bounds = joined(upper_bounds, bounds_of(next.upper[first], next.upper_valid[first]));
            lower_bounds = joined(lower_bounds, bounds_of(next.lower[first], next.lower_valid[first]));
        }
        if (texel >> 1 < push.tiles_x) emit_tile(task, texel >> 1, two_rows);
    }
}

#endif
