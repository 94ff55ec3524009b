// SPDX-License-Identifier: Apache-2.0
#pragma once

// Images in a GPU's memory, and upload buffers for them.
//
// `GpuImage` is a handle like GpuBuffer: copies share one image, which lives until the last handle and the
// last submission that uses it are gone. `record_transition` changes its Vulkan layout for the next drawing,
// shader read or copy. `UploadPool` holds the buffers that the CPU fills for each submission:
//
//     TRY_ASSIGN(const auto image,
//                GpuImage::create(*device, "canvas", width, height, VK_FORMAT_R8G8B8A8_UNORM));
//     TRY_ASSIGN(const auto bytes, pool.lease("picture", 4 * width * height));
//     // fill bytes.mapped<std::uint32_t>(), then
//     record_transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
//
// Errors are of ErrorKind::gpu.
// Threads: any may release handles; a pool and commands belong to one at a time.

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// An image in the GPU's memory: a render target, read by shaders, source and target of copies. A handle like
/// GpuBuffer. Its initial content and layout are undefined.
class GpuImage {
public:
    GpuImage() = default;
    /// Fails (ErrorKind::gpu) if it is larger than the device's images, or memory is short.
    static Result<GpuImage> create(const GpuDevice& device, const std::string& name, int width, int height,
                                   VkFormat format);

    explicit operator bool() const { return state_ != nullptr; }
    VkImage handle() const { return state_->image; }
    VkImageView view() const { return state_->view; }
    /// Null except for VK_FORMAT_R8G8B8A8_UNORM: the same bytes as sRGB, so that drawing and blending use
    /// linear light.
    VkImageView light_view() const { return state_->light_view; }
    VkImageAspectFlags aspect() const { return state_->aspect; }
    VkExtent2D extent() const { return state_->extent; }
    bool is_of_size(int width, int height) const {
        return state_->extent.width == static_cast<std::uint32_t>(width) &&
               state_->extent.height == static_cast<std::uint32_t>(height);
    }
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

/// A full barrier, and a change of layout. From VK_IMAGE_LAYOUT_UNDEFINED the content is lost.
void record_transition(GpuCommands& commands, const GpuImage& image, VkImageLayout from, VkImageLayout to);
/// The same for a colour image that a window system owns.
void record_transition(GpuCommands& commands, VkImage image, VkImageLayout from, VkImageLayout to);

/// Copies an image's pixels into a buffer, rows packed. The image is in VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL.
void copy_from_image(GpuCommands& commands, const GpuImage& image, const GpuBuffer& buffer);
/// Replaces an image's content by pixels of 4 bytes, rows of `pitch` pixels (0: packed), and changes its
/// layout to `then`.
void copy_to_image(GpuCommands& commands, const GpuBuffer& pixels, int pitch, const GpuImage& image,
                   VkImageLayout then);
/// Stretches a colour image over another one, of size `extent`, in the layouts for source and target of a
/// transfer.
void stretch_image(GpuCommands& commands, const GpuImage& from, VkImage to, VkExtent2D extent);

/// Buffers that the CPU rewrites for each submission while the GPU still reads earlier ones. The pool grows
/// to the number in use at once, then allocates no more.
class UploadPool {
public:
    explicit UploadPool(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    /// A mapped buffer of at least `bytes` without other handles, and in no submission, recorded or in
    /// flight. Its content is undefined. Fails as GpuBuffer::create does.
    Result<GpuBuffer> lease(const std::string& name, std::size_t bytes);

private:
    struct Slot {
        GpuBuffer buffer;
        std::uint64_t taken;  // the pool's count of takes at the last use
    };
    std::shared_ptr<GpuDevice> device_;
    std::vector<Slot> slots_;
    std::uint64_t takes_ = 0;
};

}  // namespace touchable
