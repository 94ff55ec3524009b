#pragma once

#include <vector>

namespace touchable {

/// Mean square of a series, sampled `tick_hz` times a second, in the band from `from_hz` to before `to_hz`; a
/// `to_hz` of half of tick_hz or more takes in all from from_hz on. Its mean is taken off, and it is seen
/// through a window of Hann's that hides where it begins and ends. Unit: the series' own, squared.
double band_power(const std::vector<double>& series, double tick_hz, double from_hz, double to_hz);

}  // namespace touchable
