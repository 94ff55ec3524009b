#pragma once

#include <vulkan/vulkan.h>

#include <memory>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "player/draw/gpu_image.hpp"

namespace touchable {

/// A window system's surface for Vulkan. It must outlive every swapchain that shows on it.
class WindowSurface {
public:
    WindowSurface(std::shared_ptr<VulkanDevice> vulkan, VkSurfaceKHR surface)
        : vulkan_(std::move(vulkan)), surface_(surface) {}
    WindowSurface(const WindowSurface&) = delete;
    WindowSurface& operator=(const WindowSurface&) = delete;
    ~WindowSurface() { vkDestroySurfaceKHR(vulkan_->instance->handle(), surface_, nullptr); }
    VkSurfaceKHR handle() const { return surface_; }

private:
    std::shared_ptr<VulkanDevice> vulkan_;
    VkSurfaceKHR surface_;
};

/// The pictures that a window shows in turn. `present` waits until the drawing is done, so that nothing that
/// the drawing read has to be kept longer. A GPU that hangs is not waited for; what it may still use stays in
/// memory. A lost surface counts as a lost GPU: both have to be opened anew.
class Swapchain {
public:
    /// ErrorKind::gpu where the device cannot show on this surface.
    static Result<std::unique_ptr<Swapchain>> create(std::shared_ptr<GpuDevice> device,
                                                     std::unique_ptr<WindowSurface> surface);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /// Screen::present; `wanted`: pixels of the window, of which the surface may know better. Nothing is
    /// shown while it has none.
    Result<void> present(GpuCommands commands, const GpuImage& canvas, VkExtent2D wanted);

private:
    Swapchain(std::shared_ptr<GpuDevice> device, std::unique_ptr<WindowSurface> surface)
        : device_(std::move(device)), surface_(std::move(surface)) {}
    Result<void> choose();
    Result<bool> make(VkExtent2D wanted);
    void destroy_chain();
    Error failed(const char* call, VkResult result);
    Result<bool> acquire(std::uint32_t& index);
    void record_copy(GpuCommands& commands, const GpuImage& canvas, VkImage to) const;

    std::shared_ptr<GpuDevice> device_;
    std::unique_ptr<WindowSurface> surface_;
    VkSurfaceFormatKHR format_{};
    VkPresentModeKHR mode_ = VK_PRESENT_MODE_FIFO_KHR;
    VkSwapchainKHR chain_ = VK_NULL_HANDLE;
    VkExtent2D extent_{};
    std::vector<VkImage> images_;
    VkFence acquired_ = VK_NULL_HANDLE;
    bool outdated_ = false;
    bool acquiring_ = false;  // the window system has yet to signal the fence
};

}  // namespace touchable
