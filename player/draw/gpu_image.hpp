#pragma once

// Pictures in a GPU's memory, and what carries bytes to them.
//
// `GpuImage` is a handle like GpuBuffer: copies share one picture, which lives until the last handle and the
// last submission that uses it are gone. `record_transition` brings it from one Vulkan layout to another, as
// whatever draws, reads or copies it next needs it. `UploadPool` has the buffers that the CPU fills for each
// submission anew:
//
//     TRY_ASSIGN(const auto image,
//                GpuImage::create(*device, "canvas", width, height, VK_FORMAT_R8G8B8A8_UNORM));
//     TRY_ASSIGN(const auto bytes, pool.take("picture", 4 * width * height));
//     // fill bytes.mapped<std::uint32_t>(), then
//     record_transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
//
// Errors are of ErrorKind::gpu. Handles may be let go by any thread; a pool and commands belong to one
// thread at a time.

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
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
    /// For VK_FORMAT_R8G8B8A8_UNORM alone, else null: the same bytes as sRGB, so that what is drawn is light,
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

/// Once all before is done, and before anything after: from one layout to another. From
/// VK_IMAGE_LAYOUT_UNDEFINED the content is lost.
void record_transition(GpuCommands& commands, const GpuImage& image, VkImageLayout from, VkImageLayout to);

/// Buffers that the CPU writes anew for each submission while earlier ones are still being read: as many as
/// are in use at once, then none is made any more.
class UploadPool {
public:
    explicit UploadPool(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    /// A mapped buffer of at least `bytes` that is not in use: by neither a handle nor a submission, recorded
    /// or in flight. Its content is undefined. Fails as GpuBuffer::create does.
    Result<GpuBuffer> take(const std::string& name, std::size_t bytes);

private:
    struct Slot {
        GpuBuffer buffer;
        std::uint64_t taken;  // when last, in takes
    };
    std::shared_ptr<GpuDevice> device_;
    std::vector<Slot> slots_;
    std::uint64_t takes_ = 0;
};

}  // namespace touchable
