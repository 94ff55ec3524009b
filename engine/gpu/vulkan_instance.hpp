#pragma once

// Vulkan itself, and what of it this engine needs: what gpu_device.cpp judges devices by and opens one of.

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <mutex>

#include "engine/base/result.hpp"

namespace touchable {

/// Vulkan's features, as asked of a device and as asked for.
struct GpuFeatures : NonCopyable {  // its parts point at each other
    GpuFeatures();

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

/// What the validation layer said, warnings and errors. Outlives the device, whose end it may speak of.
/// Every method may be called from any thread.
class GpuMessages {
public:
    void add(std::string message);
    std::vector<std::string> all() const;

private:
    mutable std::mutex mutex_;
    std::vector<std::string> messages_;
};

/// Vulkan itself, with the validation layer's watch where it was asked for.
class VulkanInstance : NonCopyable {
public:
    /// Null where there is a loader but no driver. Fails (ErrorKind::gpu) where validation is asked for and
    /// not installed, and where Vulkan fails.
    /// `extensions`: wanted besides, such as a window system's; one that is not here is refused by name.
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
