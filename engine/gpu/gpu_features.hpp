#pragma once

#include <vulkan/vulkan.h>

#include <string>
#include <string_view>
#include <vector>

#include "engine/gpu/gpu_facts.hpp"

namespace touchable {

/// Vulkan's features, as asked of a device and as asked for.
struct GpuFeatures {
    GpuFeatures();
    GpuFeatures(const GpuFeatures&) = delete;  // its parts point at each other
    GpuFeatures& operator=(const GpuFeatures&) = delete;

    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
};

/// What a device without Vulkan's help would be asked: everything `missing_from` judges.
struct GpuOffer {
    std::uint32_t api_version = 0;
    std::vector<std::string> extensions;
    bool computes = false;  ///< has a queue that does
};

/// What this engine needs and a device that offers this lacks, in words.
std::vector<std::string> missing_from(const GpuOffer& offer, const GpuFeatures& features);

/// Turns on what this engine needs, and of what is merely good to have what `here` has.
void enable(GpuFeatures& wanted, const GpuFeatures& here);

/// Extensions to enable: the needed ones, and the optional ones among `here`.
std::vector<const char*> extensions_to_enable(const std::vector<std::string>& here);
bool has_extension(const std::vector<std::string>& here, std::string_view name);

/// The queue family to use: one that computes and draws, else one that computes; negative where there is
/// none.
int queue_family_of(VkPhysicalDevice device);

std::vector<std::string> extensions_of(VkPhysicalDevice device);
GpuFacts facts_of(VkPhysicalDevice device);

}  // namespace touchable
