// SPDX-License-Identifier: Apache-2.0
// A kernel that uses everything GpuCommands can bind, and what C++ must agree on with it.
#ifndef TOUCHABLE_TESTS_GPU_MIX_WORDS_H
#define TOUCHABLE_TESTS_GPU_MIX_WORDS_H

#ifdef __cplusplus
#include <cstdint>
namespace touchable::test {
using uint = std::uint32_t;
struct vec3 {
    float x, y, z;
};
#endif

const uint mix_words_group = 32;

// A vec3 takes 12 bytes, so that `scale` follows it at once.
struct MixWordsPush {
    vec3 direction;
    float scale;
    uint count;
    uint salt;
};

#ifdef __cplusplus
inline
#endif
uint mix_word(uint word, uint salt) {
    word ^= salt;
    word *= 2654435761u;
    return word ^ (word >> 15);
}

#ifdef __cplusplus
}  // namespace touchable::test
#endif
#endif
