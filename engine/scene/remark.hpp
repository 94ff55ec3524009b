#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/setting.hpp"

namespace touchable {

/// What a person should know of how a scene came to mean what it means.
struct Remark {
    std::string what;       ///< "the camera sees 60 degrees from left to right"
    bool is_guess = false;  ///< neither a person nor a file said it
    std::string
        otherwise{};  ///< of one just made: what says another, as in "a scene file's rate says otherwise"
    Hints hints{};    ///< of one just made: the settings that do
};

/// What a scene file holds of them at most.
inline constexpr std::size_t most_remarks = 100, longest_remark = 2000;  ///< bytes

/// Adds one, on one line and short enough for a scene file; once only, and none beyond `most_remarks`.
void add_remark(std::vector<Remark>& remarks, Remark remark);
/// `first`, then `rest`, likewise.
std::vector<Remark> joined_remarks(std::vector<Remark> first, const std::vector<Remark>& rest);

/// As a scene file has it: a guess begins with "guessed: ". What says another is left out, as it may be of
/// the clip that was guessed alone.
std::string remark_text(const Remark& remark);
Remark remark_of_text(std::string_view text);

/// As a person reads it: of a guess that comes from a scene file another scene file says another. Without the
/// hints, whose names a program knows.
std::string remark_in_words(const Remark& remark);

}  // namespace touchable
