#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "player/session/chosen_filters.hpp"

namespace touchable {

/// The filters that a scene has, in words and for a program, which of them were chosen by measurement, and
/// what was measured: docs/forces.md.
nlohmann::ordered_json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen,
                                    const std::optional<MeasuredDepth>& measured);

}  // namespace touchable
