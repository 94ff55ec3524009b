// SPDX-License-Identifier: Apache-2.0
#pragma once

// The Vulkan instance, and the requirements by which gpu_device.cpp judges and opens devices.

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <mutex>

#include "engine/base/result.hpp"

namespace touchable {

/// Vulkan's features: those of a device, or those to enable.
struct GpuFeatures : NonCopyable {  // its parts point at each other
    GpuFeatures();

    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
};

/// What a device offers, as plain data: everything that `missing_from` judges.
struct GpuOffer {
    std::uint32_t api_version = 0;
    std::vector<std::string> extensions;
    bool computes = false;  ///< has a queue that does
};

/// What this engine needs and a device with this offer lacks, in words.
std::vector<std::string> missing_from(const GpuOffer& offer, const GpuFeatures& features);

/// Enables the features that this engine needs, and the optional ones that `here` has.
void enable(GpuFeatures& wanted, const GpuFeatures& here);

/// Extensions to enable: the needed ones, and the optional ones among `here`.
std::vector<const char*> extensions_to_enable(const std::vector<std::string>& here);

/// Warnings and errors of the validation layer. Outlives the device, whose destruction may add some. Every
/// method may be called from any thread.
class GpuMessages {
public:
    void add(std::string message);
    std::vector<std::string> all() const;

private:
    mutable std::mutex mutex_;
    std::vector<std::string> messages_;
};

/// A Vulkan instance, with the validation layer if requested.
class VulkanInstance : NonCopyable {
public:
    /// Null if there is a loader but no driver. Fails (ErrorKind::gpu) if validation is requested and not
    /// installed, or if Vulkan fails. `extensions`: further ones, such as a window system's; a missing one is
    /// refused by name.
    static Result<std::unique_ptr<VulkanInstance>> create(bool validation,
                                                          const std::vector<std::string>& extensions = {});
    ~VulkanInstance();

    VkInstance handle() const { return instance_; }
    bool validates() const { return validates_; }
    const std::shared_ptr<GpuMessages>& messages() const { return messages_; }
    Result<std::vector<VkPhysicalDevice>> devices() const;

private:
    VulkanInstance() = default;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    bool validates_ = false;
    std::shared_ptr<GpuMessages> messages_ = std::make_shared<GpuMessages>();
};

}  // namespace touchable
