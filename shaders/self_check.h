// SPDX-License-Identifier: Apache-2.0
// Words mixed by a kernel and by C++: what `touchable check` compares, and times. Compiled as GLSL and as
// C++.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_SELF_CHECK_H
#define TOUCHABLE_SHADERS_SELF_CHECK_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#define SELF_CHECK_FUNCTION constexpr
#else
#define SELF_CHECK_FUNCTION
#endif

#define SELF_CHECK_BINDING_IN 0   // texels: four words each
#define SELF_CHECK_BINDING_OUT 1  // words
#define SELF_CHECK_GROUP 8

struct SelfCheckPush {
    uint texel_count;
    uint salt;
};

/// Products that wrap, shifts and exclusive ors: typical of integer kernels.
SELF_CHECK_FUNCTION uint self_check_word(uint word, uint salt) {
    word = (word ^ salt) * 0x9E3779B1u;
    word = (word ^ (word >> 15u)) * 0x85EBCA77u;
    return word ^ (word >> 13u);
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef SELF_CHECK_FUNCTION

#endif
