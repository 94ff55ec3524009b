#pragma once

#include <vulkan/vulkan.h>

#include <memory>
#include <string>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// A picture in the GPU's memory: drawn to, read by shaders, copied from and to. A handle, as
/// GpuBuffer is. Its first content and layout are undefined.
class GpuImage {
public:
    GpuImage() = default;
    /// Fails (ErrorKind::gpu) where it is larger than the device's images, or memory is short.
    static Result<GpuImage> create(const GpuDevice& device, const std::string& name, int width, int height,
                                   VkFormat format);

    explicit operator bool() const { return state_ != nullptr; }
    VkImage handle() const { return state_->image; }
    VkImageView view() const { return state_->view; }
    /// Of VK_FORMAT_R8G8B8A8_UNORM alone, else null: the same bytes as sRGB, so that what is drawn is light,
    /// and light is what is mixed.
    VkImageView light_view() const { return state_->light_view; }
    VkImageAspectFlags aspect() const { return state_->aspect; }
    VkExtent2D extent() const { return state_->extent; }
    std::shared_ptr<const void> keep_alive() const { return state_; }

private:
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        VkImage image = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkImageView view = VK_NULL_HANDLE, light_view = VK_NULL_HANDLE;
        VkImageAspectFlags aspect = 0;
        VkExtent2D extent{};
    };
    std::shared_ptr<const State> state_;
};

}  // namespace touchable
