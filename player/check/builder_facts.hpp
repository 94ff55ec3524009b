#pragma once

#include <optional>
#include <string>

#include "engine/result.hpp"

namespace touchable {

/// One generated frame through all builders.
struct BuilderFacts {
    std::string scene;
    int width = 0, height = 0;
    double reference_ms = 0, cpu_ms = 0, lazy_ms = 0;  ///< every pixel asked of the lazy one
    std::optional<double> vulkan_ms;                   ///< nothing: there is no usable GPU
    bool identical = false;  ///< codes, validity and bounds; depths, for the lazy one
};
Result<BuilderFacts> builder_facts(const char* scene);

}  // namespace touchable
