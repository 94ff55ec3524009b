// SPDX-License-Identifier: Apache-2.0
#pragma once

// The remarks on a clip, in words.

#include <algorithm>
#include <string>
#include <vector>

#include "engine/clip/clip.hpp"

namespace touchable::test {

inline std::vector<std::string> clip_notes(const ClipReader& clip) {
    std::vector<std::string> told;
    for (const Remark& remark : remarks_of(clip)) told.push_back(remark_in_words(remark));
    return told;
}

/// Whether one of the notes has these words.
bool has_note(const auto& notes, const std::string& words) {
    return std::ranges::any_of(notes, [&](const auto& note) { return note.find(words) != note.npos; });
}

}  // namespace touchable::test
