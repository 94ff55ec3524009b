#include "player/run/time_spread.hpp"

#include <algorithm>
#include <bit>

namespace touchable {

namespace {

// A bin is what has the same exponent and the same first bits behind the point: those of a double, which
// count up with it.
constexpr int bits_in_bin = 52 - 7;
constexpr double shortest = 0x1p-10, longest = 0x1p40;  // of microseconds: a nanosecond, twelve days

constexpr std::uint64_t bin_of_all(double time) {
    return std::bit_cast<std::uint64_t>(time) >> bits_in_bin;
}
constexpr std::uint64_t first_bin = bin_of_all(shortest);
constexpr std::size_t bins = bin_of_all(longest) - first_bin + 1;

std::size_t bin_of(double time) {
    if (!(time >= shortest)) return 0;  // with the first
    return time < longest ? bin_of_all(time) - first_bin : bins - 1;
}

/// The middle of a bin.
double middle_of(std::size_t bin) {
    const auto end = [](std::uint64_t of) { return std::bit_cast<double>(of << bits_in_bin); };
    return (end(first_bin + bin) + end(first_bin + bin + 1)) / 2;
}

}  // namespace

nlohmann::ordered_json to_json(const Spread& s) {
    return {{"mean", s.mean}, {"p50", s.p50}, {"p99", s.p99}, {"p999", s.p999}, {"max", s.max}};
}

Spread spread_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    auto quantile = [&values](double share) {
        const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size()));
        return values[std::min(rank, values.size() - 1)];
    };
    double sum = 0;
    for (const double value : values) sum += value;
    return {sum / static_cast<double>(values.size()), quantile(0.5), quantile(0.99), quantile(0.999),
            values.back()};
}

TimeSpread::TimeSpread() : times_(bins) {}

void TimeSpread::add(double time) {
    ++times_[bin_of(time)];
    least_ = count_ == 0 ? time : std::min(least_, time);
    most_ = count_ == 0 ? time : std::max(most_, time);
    sum_ += time;
    ++count_;
}

double TimeSpread::quantile(double share) const {
    const auto rank = std::min(static_cast<std::int64_t>(share * static_cast<double>(count_)), count_ - 1);
    std::int64_t up_to = 0;
    for (std::size_t bin = 0; bin < bins; ++bin)
        if ((up_to += times_[bin]) > rank)
            return bin + 1 == bins ? most_ : std::clamp(middle_of(bin), least_, most_);
    return most_;
}

Spread TimeSpread::spread() const {
    if (count_ == 0) return {};
    return {sum_ / static_cast<double>(count_), quantile(0.5), quantile(0.99), quantile(0.999), most_};
}

}  // namespace touchable
