#include "player/window/plain_line.hpp"

#include <algorithm>

namespace touchable {
namespace {

constexpr std::size_t longest_line = 200;

}  // namespace

std::string read_plain_line(const checked_json::Node& node) {
    std::string line = node.text();
    const bool has_control = std::ranges::any_of(line, [](char c) {
        return static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) == 0x7F;
    });
    if (line.empty() || line.size() > longest_line || has_control)
        node.refuse("a line of text of up to " + std::to_string(longest_line) + " bytes");
    return line;
}

bool is_language(const std::string& word) {
    const std::size_t letters = std::min(word.find('-'), word.size());
    const auto is_small = [](char c) { return c >= 'a' && c <= 'z'; };
    const auto is_other = [&](char c) {
        return is_small(c) || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    };
    if ((letters != 2 && letters != 3) ||
        !std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(letters), is_small))
        return false;
    const std::string rest = word.substr(letters);
    return rest.empty() ||
           (rest.size() >= 2 && rest.size() <= 9 && std::all_of(rest.begin() + 1, rest.end(), is_other));
}

std::string read_language(const checked_json::Node& node) {
    std::string word = node.text();
    if (!is_language(word)) node.refuse("a language, such as \"en\", \"de\" or \"pt-BR\"");
    return word;
}

}  // namespace touchable
