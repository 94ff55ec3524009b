#include "engine/clip/clip_tags.hpp"

#include <charconv>

namespace touchable::clip_tags {
namespace {

std::optional<std::int64_t> whole_number(std::string_view text) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace

std::optional<std::int64_t> parse_version(std::string_view text) {
    const auto version = whole_number(text);
    return version && *version >= 1 ? version : std::nullopt;
}

std::optional<int> parse_bits(std::string_view text) {
    const auto bits = whole_number(text);
    if (!bits || *bits < 9 || *bits > 16) return std::nullopt;
    return static_cast<int>(*bits);
}

std::string rate_text(const FrameRate& rate) {
    return std::to_string(rate.num) + "/" + std::to_string(rate.den);
}

std::optional<FrameRate> parse_rate(std::string_view text) {
    const auto slash = text.find('/');
    if (slash == std::string_view::npos) return std::nullopt;
    const auto num = whole_number(text.substr(0, slash)), den = whole_number(text.substr(slash + 1));
    constexpr std::int64_t most = 1'000'000'000;  // as scenes allow
    if (!num || !den || *num < 1 || *den < 1 || *num > most || *den > most) return std::nullopt;
    return FrameRate{*num, *den};
}

bool same_rate(const FrameRate& a, const FrameRate& b) {
    return a.num * b.den == b.num * a.den;
}

std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded) {
    const bool keeps_times = !recorded.own_times || played.own_times;
    if (same_rate(played, recorded) && keeps_times) return std::nullopt;
    return "played at " + rate_text(played) + " frames/s, as the scene file has it; recorded at " +
           (recorded.own_times ? "times of their own, on average " : "") + rate_text(recorded);
}

bool is_too_fast(const FrameRate& rate) {
    return rate.num > rate.den * fastest_rate;
}

}  // namespace touchable::clip_tags
