// SPDX-License-Identifier: Apache-2.0
// Texels of eight neighbouring codes of a row, for GLSL.
#ifndef TOUCHABLE_SHADERS_TEXELS_H
#define TOUCHABLE_SHADERS_TEXELS_H

/// Eight neighbours of a row.
struct Eight {
    uint v[8];
};

Eight unpacked_halves(uvec4 texel) {
    Eight codes;
    [[unroll]] for (int k = 0; k < 4; ++k) {
        codes.v[2 * k] = texel[k] & 0xFFFFu;
        codes.v[2 * k + 1] = texel[k] >> 16;
    }
    return codes;
}

uvec4 packed_halves(uint v[8]) {
    return uvec4(v[0] | v[1] << 16, v[2] | v[3] << 16, v[4] | v[5] << 16, v[6] | v[7] << 16);
}

/// A texel in the widest words, because stores cost by the word.
u64vec2 packed(uint v[8]) {
    const uvec4 words = packed_halves(v);
    return u64vec2(packUint2x32(words.xy), packUint2x32(words.zw));
}

#endif
