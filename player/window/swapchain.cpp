#include "player/window/swapchain.hpp"

#include <algorithm>
#include <mutex>
#include <string>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/gpu/vulkan_instance.hpp"

namespace touchable {
namespace {

VkImageMemoryBarrier2 change_of(VkImage image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 change{};
    change.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
    change.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    change.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    change.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    change.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    change.oldLayout = from;
    change.newLayout = to;
    change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    change.image = image;
    change.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    return change;
}

void record_change(VkCommandBuffer commands, const VkImageMemoryBarrier2& change) {
    VkDependencyInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &change;
    vkCmdPipelineBarrier2(commands, &info);
}

template <class Value, class Ask>
std::vector<Value> all_of(Ask ask) {
    std::uint32_t count = 0;
    std::vector<Value> values;
    if (ask(&count, nullptr) == VK_SUCCESS) values.resize(count);
    if (ask(&count, values.data()) != VK_SUCCESS) count = 0;
    values.resize(count);
    return values;
}

}  // namespace

Result<std::unique_ptr<Swapchain>> Swapchain::create(std::shared_ptr<GpuDevice> device,
                                                     std::unique_ptr<WindowSurface> surface) {
    std::unique_ptr<Swapchain> made(new Swapchain(std::move(device), std::move(surface)));
    TRY(made->choose());
    return made;
}

Swapchain::~Swapchain() {
    if (acquiring_ || !device_->comes_to_rest()) {
        leave_for_good(device_->vulkan());
        leave_for_good(std::shared_ptr<WindowSurface>(std::move(surface_)));
        return;
    }
    destroy_chain();
    if (acquired_) vkDestroyFence(device_->vulkan()->device, acquired_, nullptr);
}

Result<void> Swapchain::choose() {
    VulkanDevice& gpu = *device_->vulkan();
    VkBool32 shows = VK_FALSE;
    const VkResult asked =
        vkGetPhysicalDeviceSurfaceSupportKHR(gpu.physical, gpu.queue_family, surface_->handle(), &shows);
    if (asked != VK_SUCCESS || !shows)
        return Error{ErrorKind::gpu,
                     gpu.facts.name + " cannot show pictures in this window; another GPU may",
                     {{Setting::gpu, "NAME"}}};
    const auto formats = all_of<VkSurfaceFormatKHR>([&](std::uint32_t* count, VkSurfaceFormatKHR* to) {
        return vkGetPhysicalDeviceSurfaceFormatsKHR(gpu.physical, surface_->handle(), count, to);
    });
    // The canvas holds what is to be seen already: a format that would make it brighter is the last resort.
    const auto plain = std::find_if(formats.begin(), formats.end(), [](const VkSurfaceFormatKHR& format) {
        return format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM;
    });
    if (formats.empty()) return Error{ErrorKind::gpu, gpu.facts.name + " has no format for this window"};
    format_ = plain == formats.end() ? formats.front() : *plain;
    const auto modes = all_of<VkPresentModeKHR>([&](std::uint32_t* count, VkPresentModeKHR* to) {
        return vkGetPhysicalDeviceSurfacePresentModesKHR(gpu.physical, surface_->handle(), count, to);
    });
    // The player paces itself: whoever waits for the screen here would only be later.
    if (std::find(modes.begin(), modes.end(), VK_PRESENT_MODE_MAILBOX_KHR) != modes.end())
        mode_ = VK_PRESENT_MODE_MAILBOX_KHR;
    VkFenceCreateInfo fence{};
    fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    const VkResult result = vkCreateFence(gpu.device, &fence, nullptr, &acquired_);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateFence", result);
    return {};
}

void Swapchain::destroy_chain() {
    if (!chain_) return;
    VulkanDevice& gpu = *device_->vulkan();
    if (!device_->lost()) {
        // What was drawn is done; what was presented may not be.
        const std::lock_guard lock(gpu.queue_mutex);
        vkQueueWaitIdle(gpu.queue);
    }
    vkDestroySwapchainKHR(gpu.device, chain_, nullptr);
    chain_ = VK_NULL_HANDLE;
    images_.clear();
}

Error Swapchain::failed(const char* call, VkResult result) {
    if (result == VK_ERROR_SURFACE_LOST_KHR) device_->lose();
    return device_->vulkan()->failed(call, result);
}

/// False where the window has no pixels. Nothing that was drawn before is still at work.
Result<bool> Swapchain::make(VkExtent2D wanted) {
    VulkanDevice& gpu = *device_->vulkan();
    destroy_chain();
    VkSurfaceCapabilitiesKHR can{};
    VkResult result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu.physical, surface_->handle(), &can);
    if (result != VK_SUCCESS) return failed("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", result);
    extent_ = can.currentExtent;
    if (extent_.width == UINT32_MAX)
        extent_ = {std::clamp(wanted.width, can.minImageExtent.width, can.maxImageExtent.width),
                   std::clamp(wanted.height, can.minImageExtent.height, can.maxImageExtent.height)};
    if (extent_.width == 0 || extent_.height == 0) return false;
    VkSwapchainCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR;
    info.surface = surface_->handle();
    info.minImageCount = std::max(can.minImageCount, 3U);
    if (can.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
    info.imageFormat = format_.format;
    info.imageColorSpace = format_.colorSpace;
    info.imageExtent = extent_;
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
    info.preTransform = can.currentTransform;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode = mode_;
    info.clipped = VK_TRUE;
    result = vkCreateSwapchainKHR(gpu.device, &info, nullptr, &chain_);
    if (result != VK_SUCCESS) return failed("vkCreateSwapchainKHR", result);
    images_ = all_of<VkImage>([&](std::uint32_t* count, VkImage* to) {
        return vkGetSwapchainImagesKHR(gpu.device, chain_, count, to);
    });
    if (images_.empty()) return Error{ErrorKind::gpu, gpu.facts.name + " has no pictures for this window"};
    outdated_ = false;
    return true;
}

/// False where the chain has to be made anew first.
Result<bool> Swapchain::acquire(std::uint32_t& index) {
    VulkanDevice& gpu = *device_->vulkan();
    constexpr std::uint64_t patience_ns = 100'000'000;
    VkResult result =
        vkAcquireNextImageKHR(gpu.device, chain_, patience_ns, VK_NULL_HANDLE, acquired_, &index);
    // A window that is covered may have no picture free: this one is not shown then.
    if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_TIMEOUT || result == VK_NOT_READY) return false;
    if (result == VK_SUBOPTIMAL_KHR) outdated_ = true;
    if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) return failed("vkAcquireNextImageKHR", result);
    acquiring_ = true;
    const std::chrono::nanoseconds patience =
        std::min<std::chrono::nanoseconds>(device_->patience(), GpuDevice::longest_picture);
    result =
        vkWaitForFences(gpu.device, 1, &acquired_, VK_TRUE, static_cast<std::uint64_t>(patience.count()));
    if (result == VK_TIMEOUT) device_->lose();
    if (result != VK_SUCCESS) return failed("vkWaitForFences", result);
    acquiring_ = false;
    vkResetFences(gpu.device, 1, &acquired_);
    return true;
}

void Swapchain::record_copy(GpuCommands& commands, const GpuImage& canvas, VkImage to) const {
    const VkCommandBuffer buffer = commands.handle();
    record_change(buffer, change_of(to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL));
    const auto corner = [](VkExtent2D extent) {
        return VkOffset3D{static_cast<std::int32_t>(extent.width), static_cast<std::int32_t>(extent.height),
                          1};
    };
    VkImageBlit2 region{};
    region.sType = VK_STRUCTURE_TYPE_IMAGE_BLIT_2;
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffsets[1] = corner(canvas.extent());
    region.dstOffsets[1] = corner(extent_);
    VkBlitImageInfo2 blit{};
    blit.sType = VK_STRUCTURE_TYPE_BLIT_IMAGE_INFO_2;
    blit.srcImage = canvas.handle();
    blit.srcImageLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    blit.dstImage = to;
    blit.dstImageLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    blit.regionCount = 1;
    blit.pRegions = &region;
    const bool same_size = canvas.extent().width == extent_.width && canvas.extent().height == extent_.height;
    blit.filter = same_size ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    vkCmdBlitImage2(buffer, &blit);
    record_change(buffer,
                  change_of(to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR));
}

Result<void> Swapchain::present(GpuCommands commands, const GpuImage& canvas, VkExtent2D wanted) {
    std::uint32_t index = 0;
    bool shown = chain_ && !outdated_;
    if (shown) {
        TRY_ASSIGN(const auto acquired, acquire(index));
        shown = acquired;
    }
    if (!shown) {
        TRY_ASSIGN(const auto made, make(wanted));
        if (made) {
            TRY_ASSIGN(const auto acquired, acquire(index));
            shown = acquired;
        }
    }
    if (shown) record_copy(commands, canvas, images_[index]);
    if (auto done = std::move(commands).run(); !done.ok()) return done;
    if (!shown) return {};
    VulkanDevice& gpu = *device_->vulkan();
    VkPresentInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR;
    info.swapchainCount = 1;
    info.pSwapchains = &chain_;
    info.pImageIndices = &index;
    VkResult result;
    {
        const std::lock_guard lock(gpu.queue_mutex);
        result = vkQueuePresentKHR(gpu.queue, &info);
    }
    outdated_ = outdated_ || result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
    if (result != VK_SUCCESS && !outdated_) return failed("vkQueuePresentKHR", result);
    return {};
}

}  // namespace touchable
