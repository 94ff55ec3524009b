#pragma once

#include <vulkan/vulkan.h>

#include <memory>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/result.hpp"
#include "player/view/gpu_image.hpp"

namespace touchable {

/// Draws what ImGui has laid out, over a canvas (VK_FORMAT_R8G8B8A8_UNORM). One at a time, with an ImGuiLayer
/// that outlives it. What a GPU that hangs may still use of it stays in memory.
class ImGuiVulkan {
public:
    static Result<std::unique_ptr<ImGuiVulkan>> create(std::shared_ptr<GpuDevice> device);
    ~ImGuiVulkan();
    ImGuiVulkan(const ImGuiVulkan&) = delete;
    ImGuiVulkan& operator=(const ImGuiVulkan&) = delete;

    /// Records it over `canvas`, which is in VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL before and in
    /// VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL after.
    Result<void> draw(GpuCommands& commands, const GpuImage& canvas);

private:
    explicit ImGuiVulkan(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    void leave();
    Result<void> make_pass();
    Result<void> start();
    Result<void> upload_fonts();
    Result<VkFramebuffer> framebuffer_of(const GpuImage& canvas);

    std::shared_ptr<GpuDevice> device_;
    bool is_started_ = false;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
    std::shared_ptr<const void> canvas_;  // what the framebuffer is of
};

}  // namespace touchable
