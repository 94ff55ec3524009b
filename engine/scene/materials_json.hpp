#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// The scene file's member `default_properties`, or an entry of `haptic.materials`: what it leaves out stays.
void read_properties(const checked_json::Node& node, HapticProperties& properties);
nlohmann::ordered_json write_properties(const HapticProperties& properties);

/// The scene file's member `haptic.materials`: properties by index. What an entry leaves out is as of
/// `otherwise`. A range that `haptic` does not state becomes that of the materials and of `otherwise`; one
/// that it states has to hold them.
std::vector<Material> read_materials(const checked_json::Node& haptic, const HapticProperties& otherwise,
                                     HapticRanges& ranges);
nlohmann::ordered_json write_materials(const std::vector<Material>& materials);

}  // namespace touchable
