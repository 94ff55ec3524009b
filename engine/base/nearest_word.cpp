#include "engine/base/nearest_word.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace touchable {
namespace {

std::size_t letters_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = corner + (a[i] == b[j] ? 0 : 1);
            corner = row[j + 1];
            row[j + 1] = std::min({changed, corner + 1, row[j] + 1});
        }
    }
    return row.back();
}

}  // namespace

std::string nearest_word(std::string_view typed, std::span<const std::string> words) {
    constexpr std::size_t most_letters = 3, longest = 64;
    std::string nearest;
    std::size_t least = std::min(most_letters, typed.size() / 2) + 1;
    for (const std::string& word : words)
        if (const std::size_t letters = letters_between(typed.substr(0, longest), word); letters < least) {
            least = letters;
            nearest = word;
        }
    return nearest;
}

}  // namespace touchable
