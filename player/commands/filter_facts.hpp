#pragma once

#include <nlohmann/json.hpp>

#include "player/session/chosen_filters.hpp"

namespace touchable {

/// What the first frames told of depth, for a program: docs/forces.md. Null: no pixel is valid.
nlohmann::ordered_json to_json(const std::optional<MeasuredDepth>& measured);
/// The filters that a scene has, which of them were chosen by measurement, and why.
nlohmann::ordered_json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen);

}  // namespace touchable
