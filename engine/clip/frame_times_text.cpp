#include "engine/clip/frame_times_text.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"

namespace touchable {
namespace {

constexpr std::int64_t ns_a_ms = 1'000'000;

std::string_view take_line(std::string_view& text) {
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

std::optional<std::int64_t> ns_of(std::string_view line) {
    constexpr double latest_ms = 4e12;
    double ms = 0;
    const auto [end, failure] = std::from_chars(line.data(), line.data() + line.size(), ms);
    if (failure != std::errc() || end != line.data() + line.size()) return {};
    if (!(std::fabs(ms) <= latest_ms)) return {};
    return std::llround(ms * ns_a_ms);
}

}  // namespace

std::string frame_times_text(const FrameRate& rate) {
    std::string text = "# timestamp format v2\n";
    for (const std::int64_t ns : *rate.own_times)
        text += formatted("%lld.%06lld\n", static_cast<long long>(ns / ns_a_ms),
                          static_cast<long long>(ns % ns_a_ms));
    return text;
}

Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name) {
    const std::string_view head = take_line(text);
    if (head != "# timestamp format v2" && head != "# timecode format v2")
        return input_error(name + ": begins with " + in_quotes(head) +
                           ": must be a line \"# timestamp format v2\", then a line per frame, milliseconds");
    std::vector<std::int64_t> times_ns;
    for (int number = 2; !text.empty(); ++number) {
        const std::string_view line = take_line(text);
        if (line.empty() || line.starts_with('#')) continue;
        const auto time_ns = ns_of(line);
        if (!time_ns)
            return input_error(name + ", line " + std::to_string(number) + ": is " + in_quotes(line) +
                               ": must be the time of a frame, milliseconds");
        if (!times_ns.empty() && *time_ns < times_ns.back() + shortest_frame_ns)
            return input_error(name + ", line " + std::to_string(number) + ": is " + in_quotes(line) +
                               ": must be 1 ms or more after the frame before");
        times_ns.push_back(*time_ns);
    }
    if (times_ns.size() < 2)
        return input_error(name + ": has the times of " + std::to_string(times_ns.size()) +
                           " frames: must be of two or more");
    if (auto rate = rate_of_own_times(std::move(times_ns))) return std::move(*rate);
    return input_error(name + ": must be of less than 126 years");
}

}  // namespace touchable
