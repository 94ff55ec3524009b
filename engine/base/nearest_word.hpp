#pragma once

#include <span>
#include <string>
#include <string_view>

namespace touchable {

/// Of `words` the one that somebody may have meant who typed `typed`: the fewest letters put in, left out or
/// changed (Levenshtein's distance), three at most and less than half of them. Empty: none.
std::string nearest_word(std::string_view typed, std::span<const std::string> words);

}  // namespace touchable
