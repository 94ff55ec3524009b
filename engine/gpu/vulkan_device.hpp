#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_facts.hpp"
#include "engine/gpu/vulkan_instance.hpp"

namespace touchable {

/// The raw Vulkan: instance, device and queue. Everything made from them (buffers, programs, images) holds a
/// shared_ptr to this, never to GpuDevice, so that it can be in flight there without keeping it alive for
/// ever.
struct VulkanDevice {
    VulkanDevice() = default;
    VulkanDevice(const VulkanDevice&) = delete;
    VulkanDevice& operator=(const VulkanDevice&) = delete;
    ~VulkanDevice();  ///< waits until the device is idle

    GpuFacts facts;
    std::unique_ptr<VulkanInstance> instance;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;  ///< externally synchronised: lock `queue_mutex`
    std::uint32_t queue_family = 0;
    std::mutex queue_mutex;
    VkPhysicalDeviceMemoryProperties memory{};

    // Functions of extensions; null where the extension is optional and absent.
    PFN_vkCmdPushDescriptorSetKHR push_descriptors = nullptr;
    PFN_vkSetDebugUtilsObjectNameEXT set_name = nullptr;

    /// Sticky: once true, every submission and every wait fails.
    std::atomic<bool> lost = false;

    /// The error of a failed call ("vkQueueSubmit2: VK_ERROR_DEVICE_LOST on llvmpipe"); marks the device lost
    /// where the result says so.
    Error failed(std::string_view call, VkResult result);

    /// What debuggers and validation messages call an object; nothing without the debug extension.
    void name_object(VkObjectType type, std::uint64_t handle, const std::string& name) const;
};

/// Keeps something until the process ends: what a GPU that hangs may still use must not be freed under it,
/// nor the device it belongs to.
void leave_for_good(std::shared_ptr<const void> what);

}  // namespace touchable
