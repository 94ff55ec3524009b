#include "engine/gpu/gpu_features.hpp"

#include <algorithm>

namespace touchable {
namespace {

struct Feature {
    const char* name;
    VkBool32& (*of)(GpuFeatures&);
};

#define TOUCHABLE_FEATURE(part, name)                                   \
    Feature {                                                           \
#name, [](GpuFeatures & f) -> VkBool32& { return f.part.name; } \
    }

/// What kernels declare (tests/gpu/features_test.cpp holds both against each other), and what is called.
/// Every Vulkan 1.3 has the latter, but wants to be asked.
constexpr Feature needed_features[] = {
    TOUCHABLE_FEATURE(core.features, shaderInt64), TOUCHABLE_FEATURE(v12, timelineSemaphore),
    TOUCHABLE_FEATURE(v13, synchronization2),      TOUCHABLE_FEATURE(v13, maintenance4),
    TOUCHABLE_FEATURE(v13, dynamicRendering),
};

constexpr Feature optional_features[] = {
    TOUCHABLE_FEATURE(v12, shaderBufferInt64Atomics),  // the painter raster
};

#undef TOUCHABLE_FEATURE

constexpr const char* needed_extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
constexpr const char* optional_extensions[] = {
    // Where a device has it, it is Vulkan on top of something else, not all of Vulkan, and has to be told
    // that this is known. Nothing of what may be missing then is used here.
    "VK_KHR_portability_subset",
};

bool is_on(const Feature& feature, const GpuFeatures& features) {
    return feature.of(const_cast<GpuFeatures&>(features)) == VK_TRUE;  // read only
}

std::string version_text(std::uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." +
           std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

GpuKind kind_of(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return GpuKind::discrete;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return GpuKind::integrated;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return GpuKind::virtualised;
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return GpuKind::software;
        default:
            return GpuKind::other;
    }
}

std::vector<VkQueueFamilyProperties> families_of(VkPhysicalDevice device) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    return families;
}

bool has_unified_memory(VkPhysicalDevice device) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(device, &memory);
    constexpr VkMemoryPropertyFlags unified =
        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
        VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    return std::any_of(memory.memoryTypes, memory.memoryTypes + memory.memoryTypeCount,
                       [](const VkMemoryType& type) { return (type.propertyFlags & unified) == unified; });
}

/// Chains of newer Vulkan may not be asked of older devices.
GpuFacts facts_of_old(const VkPhysicalDeviceProperties& properties) {
    GpuFacts facts;
    facts.name = properties.deviceName;
    facts.api = version_text(properties.apiVersion);
    facts.kind = kind_of(properties.deviceType);
    return facts;
}

struct Properties {
    VkPhysicalDeviceProperties2 core{};
    VkPhysicalDeviceVulkan11Properties v11{};
    VkPhysicalDeviceVulkan12Properties v12{};
    VkPhysicalDeviceVulkan13Properties v13{};
    VkPhysicalDeviceExternalMemoryHostPropertiesEXT host_memory{};
};

void ask(VkPhysicalDevice device, bool imports, Properties& properties) {
    properties.core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
    properties.v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES;
    properties.v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES;
    properties.host_memory.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_MEMORY_HOST_PROPERTIES_EXT;
    properties.core.pNext = &properties.v11;
    properties.v11.pNext = &properties.v12;
    properties.v12.pNext = &properties.v13;
    properties.v13.pNext = imports ? &properties.host_memory : nullptr;
    vkGetPhysicalDeviceProperties2(device, &properties.core);
}

GpuLimits limits_of(const Properties& properties) {
    const VkPhysicalDeviceLimits& from = properties.core.properties.limits;
    GpuLimits limits;
    limits.max_storage_buffer_range = from.maxStorageBufferRange;
    limits.max_allocation = std::min(properties.v11.maxMemoryAllocationSize, properties.v13.maxBufferSize);
    limits.max_texel_buffer_elements = from.maxTexelBufferElements;
    limits.max_push_constants = from.maxPushConstantsSize;
    limits.max_group_invocations = from.maxComputeWorkGroupInvocations;
    std::copy_n(from.maxComputeWorkGroupSize, 3, limits.max_group_size.begin());
    std::copy_n(from.maxComputeWorkGroupCount, 3, limits.max_group_count.begin());
    limits.max_shared_memory = from.maxComputeSharedMemorySize;
    limits.subgroup_size = properties.v11.subgroupSize;
    limits.min_storage_buffer_alignment = static_cast<std::uint32_t>(from.minStorageBufferOffsetAlignment);
    limits.min_texel_buffer_alignment = static_cast<std::uint32_t>(from.minTexelBufferOffsetAlignment);
    return limits;
}

}  // namespace

GpuFeatures::GpuFeatures() {
    core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
}

std::vector<std::string> missing_from(const GpuOffer& offer, const GpuFeatures& features) {
    std::vector<std::string> missing;
    if (offer.api_version < VK_API_VERSION_1_3)
        return {"Vulkan 1.3 (it has " + version_text(offer.api_version) + ")"};  // the rest would be guesses
    if (!offer.computes) missing.emplace_back("a queue that computes");
    for (const char* extension : needed_extensions)
        if (!has_extension(offer.extensions, extension)) missing.emplace_back(extension);
    for (const Feature& feature : needed_features)
        if (!is_on(feature, features)) missing.emplace_back(feature.name);
    return missing;
}

void enable(GpuFeatures& wanted, const GpuFeatures& here) {
    for (const Feature& feature : needed_features) feature.of(wanted) = VK_TRUE;
    for (const Feature& feature : optional_features)
        if (is_on(feature, here)) feature.of(wanted) = VK_TRUE;
}

bool has_extension(const std::vector<std::string>& here, std::string_view name) {
    return std::find(here.begin(), here.end(), name) != here.end();
}

std::vector<const char*> extensions_to_enable(const std::vector<std::string>& here) {
    std::vector<const char*> enabled(std::begin(needed_extensions), std::end(needed_extensions));
    for (const char* extension : optional_extensions)
        if (has_extension(here, extension)) enabled.push_back(extension);
    return enabled;
}

int queue_family_of(VkPhysicalDevice device) {
    const auto families = families_of(device);
    for (const VkQueueFlags wanted : {VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT, VK_QUEUE_COMPUTE_BIT + 0})
        for (std::size_t i = 0; i < families.size(); ++i)
            if (families[i].queueCount > 0 && (families[i].queueFlags & wanted) == wanted)
                return static_cast<int>(i);
    return -1;
}

std::vector<std::string> extensions_of(VkPhysicalDevice device) {
    std::uint32_t count = 0;
    std::vector<VkExtensionProperties> found;
    if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) == VK_SUCCESS)
        found.resize(count);
    if (vkEnumerateDeviceExtensionProperties(device, nullptr, &count, found.data()) != VK_SUCCESS)
        found.clear();
    std::vector<std::string> names;
    for (const VkExtensionProperties& extension : found) names.emplace_back(extension.extensionName);
    return names;
}

GpuFacts facts_of(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties oldest;
    vkGetPhysicalDeviceProperties(device, &oldest);
    GpuFacts facts = facts_of_old(oldest);
    GpuFeatures features;
    GpuOffer offer{oldest.apiVersion, extensions_of(device), false};
    if (oldest.apiVersion < VK_API_VERSION_1_3) {
        facts.missing = missing_from(offer, features);
        return facts;
    }

    const bool imports = has_extension(offer.extensions, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
    Properties properties;
    ask(device, imports, properties);
    vkGetPhysicalDeviceFeatures2(device, &features.core);
    facts.driver = properties.v12.driverName;
    facts.driver_info = properties.v12.driverInfo;
    facts.limits = limits_of(properties);
    facts.unified_memory = has_unified_memory(device);
    facts.int64_atomics = features.v12.shaderBufferInt64Atomics == VK_TRUE;
    facts.float64 = features.core.features.shaderFloat64 == VK_TRUE;
    facts.import_alignment = imports ? properties.host_memory.minImportedHostPointerAlignment : 0;
    if (const int family = queue_family_of(device); family >= 0) {
        const VkQueueFamilyProperties queue = families_of(device)[static_cast<std::size_t>(family)];
        offer.computes = true;
        facts.draws_triangles = (queue.queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
        facts.limits.timestamp_bits = queue.timestampValidBits;
        facts.limits.timestamp_period_ns = queue.timestampValidBits > 0 ? oldest.limits.timestampPeriod : 0;
    }
    facts.missing = missing_from(offer, features);
    return facts;
}

}  // namespace touchable
