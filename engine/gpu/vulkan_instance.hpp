#pragma once

#include <vulkan/vulkan.h>

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// "VK_ERROR_OUT_OF_DEVICE_MEMORY" and the like.
std::string_view name_of(VkResult result);

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
class VulkanInstance {
public:
    /// Null where there is a loader but no driver. Fails (ErrorKind::gpu) where validation is asked for and
    /// not installed, and where Vulkan fails.
    /// `extensions`: wanted besides, such as a window system's; one that is not here is refused by name.
    static Result<std::unique_ptr<VulkanInstance>> create(bool validation,
                                                          const std::vector<std::string>& extensions = {});
    VulkanInstance(const VulkanInstance&) = delete;
    VulkanInstance& operator=(const VulkanInstance&) = delete;
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
