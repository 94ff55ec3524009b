#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>

#include "player/check/vulkan_facts.hpp"

namespace touchable {

/// Lines of `touchable check`: each device and what it lacks, memory, limits and timings of the one used.
void print_vulkan(std::ostream& out, const VulkanFacts& facts);
nlohmann::ordered_json vulkan_json(const VulkanFacts& facts);

}  // namespace touchable
