#include "engine/scene/frame_rate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace touchable {
namespace {

__extension__ using Wide = __int128;

std::int64_t even_time(const FrameRate& rate, std::int64_t frame) {
    const Wide numerator = Wide{frame} * rate.den * 1'000'000'000;
    Wide quotient = numerator / rate.num;
    if (numerator % rate.num < 0) --quotient;  // division truncates; a time before 0 is floored too
    constexpr Wide most = std::numeric_limits<std::int64_t>::max();
    return static_cast<std::int64_t>(std::clamp(quotient, -most, most));
}

// The largest n with floor(n 1e9 den / num) <= time, which is n 1e9 den < (time + 1) num.
std::int64_t even_frame(const FrameRate& rate, std::int64_t time_ns) {
    const Wide numerator = (Wide{time_ns} + 1) * rate.num - 1, unit = Wide{rate.den} * 1'000'000'000;
    Wide quotient = numerator / unit;
    if (numerator % unit < 0) --quotient;
    return static_cast<std::int64_t>(quotient);
}

}  // namespace

std::int64_t FrameRate::time_ns(std::int64_t frame) const {
    if (!own_times || frame < 0) return even_time(*this, frame);
    const auto last = static_cast<std::int64_t>(own_times->size()) - 1;
    if (frame <= last) return (*own_times)[static_cast<std::size_t>(frame)];
    const Wide time = Wide{own_times->back()} + even_time(*this, frame - last);
    return static_cast<std::int64_t>(std::min(time, Wide{std::numeric_limits<std::int64_t>::max()}));
}

std::int64_t FrameRate::frame_at(std::int64_t time_ns) const {
    if (!own_times || time_ns < 0) return even_frame(*this, time_ns);
    if (time_ns >= own_times->back())
        return static_cast<std::int64_t>(own_times->size()) - 1 +
               even_frame(*this, time_ns - own_times->back());
    return std::upper_bound(own_times->begin(), own_times->end(), time_ns) - own_times->begin() - 1;
}

std::int64_t FrameRate::nearest(std::int64_t time) const {
    const std::int64_t before = frame_at(time);
    return time_ns(before + 1) - time < time - time_ns(before) ? before + 1 : before;
}

std::optional<FrameRate> rate_of_own_times(std::vector<std::int64_t> times_ns) {
    constexpr std::int64_t latest_ns = 4'000'000'000'000'000'000;
    if (times_ns.size() < 2) return {};
    const std::int64_t first_ns = times_ns.front();
    for (std::size_t n = 1; n < times_ns.size(); ++n)
        if (Wide{times_ns[n]} - times_ns[n - 1] < shortest_frame_ns) return {};
    if (Wide{times_ns.back()} - first_ns > latest_ns) return {};
    for (std::int64_t& time_ns : times_ns) time_ns -= first_ns;
    const double mean = static_cast<double>(times_ns.size() - 1) * 1e9 / static_cast<double>(times_ns.back());
    const std::int64_t den = mean < 1 ? 1'000'000'000 : 1'000'000;
    const std::int64_t num = std::max<std::int64_t>(std::llround(mean * static_cast<double>(den)), 1);
    const std::int64_t common = std::gcd(num, den);
    FrameRate rate{num / common, den / common};
    rate.own_times = std::make_shared<const std::vector<std::int64_t>>(std::move(times_ns));
    return rate;
}

}  // namespace touchable
