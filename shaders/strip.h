// SPDX-License-Identifier: Apache-2.0
// The march along a strip, for GLSL: a lane holds two rows and goes along them texel by texel. Columns of the
// window are ranked once and rolled on, and no value is loaded twice by a lane. This suits a software Vulkan,
// whose only fast loads are texels and whose slowest stores are single codes; it does not branch, so invalid
// codes go through the same minima and maxima as all others.
//
// The includer defines before: strip_rows, the number of rows of the two rows' window; strip_centre, which of
// them is the upper of the two; strip_reach, the columns of the window to each side, at least 1;
// outside_repeats, whether the border repeats beyond the picture, or nothing there is valid; `Column`, what
// is kept of a column of the window, and rank_column. And after: filtered, take, finish_word, start_word, and
// main, which calls `march`.
#ifndef TOUCHABLE_SHADERS_STRIP_H
#define TOUCHABLE_SHADERS_STRIP_H

#include "shaders/texels.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint sample_bytes = 2u;
layout(constant_id = 2) const uint may_be_invalid = 1u;
layout(constant_id = 3) const uint may_be_excluded = 1u;
layout(constant_id = 4) const uint ragged = 1u;
layout(constant_id = 5) const uint to_finer = 0u;
layout(constant_id = 6) const uint looked_up = 0u;

layout(push_constant, std430) uniform Push { StripPush push; };
layout(set = 0, binding = 0) uniform utextureBuffer stored_texels;
layout(set = 0, binding = 1, std430) writeonly buffer Codes { u64vec2 out_codes[]; };

const uint greatest_code = 65535u;

/// One lane's work: strip `strip` from texel `first` to before `end`; none if not `there`.
struct Task {
    bool there;
    uint strip, first, end;
};

/// The results of eight neighbours in both rows.
struct Pixels {
    uint upper[8], lower[8];
    bool upper_valid[8], lower_valid[8];
};
/// The codes to be written.
struct Written {
    Eight upper, lower;
};

/// Pixels 8 t - strip_reach + k for k = 0 to 7, from the columns 8 t - 2 strip_reach and on.
Pixels filtered(Column columns[8 + 2 * strip_reach]);
/// Takes the pixels that start strip_reach before a texel. At task.end only the first strip_reach of them are
/// the task's, at task.first only the others; pixels outside the picture may be anything.
Written take(Task task, uint texel, Pixels pixels);
/// Called when a word of validity's pixels, 32 or the rest of a row, and the first one after it are taken.
void finish_word(Task task, uint word);
/// Pixels belong to the next word from here on; of those taken last all but the first strip_reach do.
void start_word();

Eight unpacked_bytes(uvec2 words) {
    Eight codes;
    [[unroll]] for (int k = 0; k < 8; ++k) codes.v[k] = bitfieldExtract(words[k / 4], 8 * (k % 4), 8);
    return codes;
}

/// Stored values 8 `texel` to 8 `texel` + 7 of the row that starts at texel `start`; those beyond the width
/// repeat the last one. The texel at the width is read, too: its first values are the last one.
Eight load(uint start, uint texel) {
    const uint last = (push.width - 1u) >> 3;
    const uint there = min(texel, last);
    Eight codes;
    if (sample_bytes == 1u) {
        const uvec4 bytes = texelFetch(stored_texels, int(start + (there >> 1)));
        codes = unpacked_bytes((there & 1u) == 0u ? bytes.xy : bytes.zw);
    } else {
        codes = unpacked_halves(texelFetch(stored_texels, int(start + there)));
    }
    if (ragged != 0u) {
        [[unroll]] for (int k = 1; k < 8; ++k)
            codes.v[k] = 8u * there + uint(k) < push.width ? codes.v[k] : codes.v[k - 1];
    }
    [[unroll]] for (int k = 0; k < strip_reach; ++k) codes.v[k] = texel > last ? codes.v[7] : codes.v[k];
    return codes;
}

Task task_of(uint lane) {
    const uint strips = (push.height + 1u) >> 1, texels = (push.width + 7u) >> 3;
    Task task;
    const uint segment = push.along_x != 0u ? lane % push.segments : lane / strips;
    task.strip = push.along_x != 0u ? lane / push.segments : lane % strips;
    task.there = task.strip < strips && segment < push.segments;
    task.first = segment * push.segment_texels;
    task.end = min(task.first + push.segment_texels, texels);
    return task;
}

/// A texel of each row of a strip's window, or its substitute.
struct Window {
    Eight rows[strip_rows];
};
/// Where these rows start.
struct Starts {
    uint rows[strip_rows];
};

Starts starts_of(uint strip) {
    Starts starts;
    [[unroll]] for (int k = 0; k < strip_rows; ++k)
        starts.rows[k] = push.in_pitch * uint(clamp(2 * int(strip) + k - strip_centre, 0, int(push.height) - 1));
    return starts;
}

Window load_window(Starts starts, uint texel) {
    Window window;
    [[unroll]] for (int k = 0; k < strip_rows; ++k) window.rows[k] = load(starts.rows[k], texel);
    return window;
}

/// Column `k` of a window, which is column `x` of the picture.
Column column_of(Window window, uint strip, int k, int x) {
    uint codes[strip_rows];
    bool valid[strip_rows];
    [[unroll]] for (int n = 0; n < strip_rows; ++n) {
        codes[n] = window.rows[n].v[k];
        valid[n] = true;
        if (may_be_invalid != 0u) {
            const int row = 2 * int(strip) + n - strip_centre;
            valid[n] = code_is_in_range(codes[n], push.valid);
            if (may_be_excluded != 0u) valid[n] = valid[n] && !code_is_excluded(codes[n], push.valid);
            if (!outside_repeats)
                valid[n] = valid[n] && row >= 0 && row < int(push.height) && x >= 0 && x < int(push.width);
        }
    }
    return rank_column(codes, valid);
}

/// The columns before the first of a task.
void start_columns(Task task, Starts starts, inout Column columns[8 + 2 * strip_reach]) {
    const bool border = task.first == 0u;
    Window window = load_window(starts, border ? 0u : task.first - 1u);
    [[unroll]] for (int k = 0; k < 2 * strip_reach; ++k) {
        const int from = 8 - 2 * strip_reach + k;
        [[unroll]] for (int n = 0; n < strip_rows; ++n)
            if (border) window.rows[n].v[from] = window.rows[n].v[0];
        columns[k] = column_of(window, task.strip, from, 8 * int(task.first) - 2 * strip_reach + k);
    }
}

/// The words of a texel without its last pixels, which the next one brings.
uvec4 begun(Eight row) {
    uint v[8];
    [[unroll]] for (int k = 0; k < 8; ++k) v[k] = k + strip_reach < 8 ? row.v[k + strip_reach] : 0u;
    return packed_halves(v);
}
u64vec2 completed(uvec4 words, Eight next) {
    words.w |= strip_reach == 1 ? next.v[0] << 16 : next.v[0] | next.v[1] << 16;
    return u64vec2(packUint2x32(words.xy), packUint2x32(words.zw));
}

void march(Task task) {
    const Starts starts = starts_of(task.strip);
    Column columns[8 + 2 * strip_reach];
    start_columns(task, starts, columns);
    const uint row = 2u * task.strip;
    const bool two_rows = row + 1u < push.height;
    uint out_texel = row * push.out_pitch + task.first - 1u;
    uvec4 upper, lower;
    for (uint texel = task.first; texel <= task.end; ++texel, ++out_texel) {
        const Window window = load_window(starts, texel);
        [[unroll]] for (int k = 0; k < 8; ++k)
            columns[2 * strip_reach + k] = column_of(window, task.strip, k, int(8u * texel) + k);
        const Written written = take(task, texel, filtered(columns));
        if (texel > task.first) {
            out_codes[out_texel] = completed(upper, written.upper);
            if (two_rows) out_codes[out_texel + push.out_pitch] = completed(lower, written.lower);
        }
        upper = begun(written.upper);
        lower = begun(written.lower);
        [[unroll]] for (int k = 0; k < 2 * strip_reach; ++k) columns[k] = columns[8 + k];
        if ((texel & 3u) == 0u || texel == task.end) {
            if (texel > task.first) finish_word(task, (texel - 1u) >> 2);
            start_word();
        }
    }
}

/// Bits 0 to 7: which of the pixels from strip_reach before a texel lie to the left of the width.
uint inside_bits(uint texel) {
    const int inside = clamp(int(push.width) - 8 * int(texel) + strip_reach, 0, 8);
    return (1u << inside) - 1u;
}

#endif
