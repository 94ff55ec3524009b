#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace touchable {

/// Spread of a measured quantity.
struct Spread {
    double mean = 0, p50 = 0, p99 = 0, p999 = 0, max = 0;
};
/// The value at rank floor(share n) of n, for each share; all 0 of none.
Spread spread_of(std::vector<double> values);
nlohmann::ordered_json to_json(const Spread& spread);

/// The spread of times of which there may be more than memory has room for: a histogram whose bins grow with
/// the time, 128 from one power of 2 to the next. Mean and max are exact, the rest is within half a percent
/// (below 1/1024 of the unit that times are given in: within that). Its memory is the same however many there
/// are.
class TimeSpread {
public:
    TimeSpread();
    /// In any unit, 0 or more.
    void add(double time);
    /// In the same; all 0 of none.
    Spread spread() const;

private:
    double quantile(double share) const;

    std::vector<std::int64_t> times_;  // how many, of each bin
    std::int64_t count_ = 0;
    double sum_ = 0, least_ = 0, most_ = 0;
};

}  // namespace touchable
