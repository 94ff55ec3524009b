#include "engine/scene/remark.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/printable.hpp"

namespace touchable {
namespace {

constexpr std::string_view guess_mark = "guessed: ";
// Bytes that are no UTF-8 become three each in JSON; even so it can be read again.
constexpr std::size_t longest_made = longest_remark / 4;

}  // namespace

void add_remark(std::vector<Remark>& remarks, Remark remark) {
    remark.what = printable(remark.what, longest_made);
    const std::string text = remark_text(remark);
    const bool is_there = std::any_of(remarks.begin(), remarks.end(),
                                      [&](const Remark& other) { return remark_text(other) == text; });
    if (!is_there && remarks.size() < most_remarks) remarks.push_back(std::move(remark));
}

std::vector<Remark> joined_remarks(std::vector<Remark> first, const std::vector<Remark>& rest) {
    for (const Remark& remark : rest) add_remark(first, remark);
    return first;
}

std::string remark_text(const Remark& remark) {
    return (remark.is_guess ? std::string(guess_mark) : std::string()) + remark.what;
}

Remark remark_of_text(std::string_view text) {
    const bool is_guess = text.starts_with(guess_mark);
    if (is_guess) text.remove_prefix(guess_mark.size());
    return {std::string(text), is_guess};
}

std::string remark_in_words(const Remark& remark) {
    const std::string text = printable(remark_text(remark), longest_remark);
    if (!remark.is_guess && remark.otherwise.empty() && remark.hints.empty()) return text;
    return text + " (" + (remark.otherwise.empty() ? "a scene file says otherwise" : remark.otherwise) + ")";
}

}  // namespace touchable
