#pragma once

#include <filesystem>
#include <vector>

#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// How often the error bars of forces hold, in the rooms of KnownRoom as these cameras film them: 95 of 100
/// is right. direction_..., size_...:
///   right: of 60 cameras, those of which 92 to 98 % of the errors lie within the bars; least_pct: the least
///   share; width: mean bar over the best constant one of the same camera; rank: mean correlation of ranks;
///   fit_right, fit_least_pct: with weights fitted to the other cameras; weight_1 to
///   weight_4: fitted to all of them
/// still_...: the same of single pictures, by the program's weights.
Result<void> measure_error_bars(const std::filesystem::path& data, const std::vector<SensorModel>& models,
                                bool quick, Figures& figures);

}  // namespace touchable
