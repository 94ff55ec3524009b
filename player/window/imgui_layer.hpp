#pragma once

#include <vulkan/vulkan.h>

#include <memory>
#include <span>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/result.hpp"
#include "player/view/gpu_image.hpp"
#include "player/window/input_event.hpp"

struct ImGuiContext;

namespace touchable {

/// Dear ImGui's picture over a canvas (VK_FORMAT_R8G8B8A8_UNORM), and its input. One at a time.
class ImGuiLayer {
public:
    /// `scale` as in ScreenSize.
    static Result<std::unique_ptr<ImGuiLayer>> create(std::shared_ptr<GpuDevice> device, double scale);
    ~ImGuiLayer();
    ImGuiLayer(const ImGuiLayer&) = delete;
    ImGuiLayer& operator=(const ImGuiLayer&) = delete;

    /// Begins a picture of so many pixels, `seconds` after the one before; from here to `draw` ImGui's calls
    /// make it.
    void begin(int width, int height, double seconds, std::span<const InputEvent> events);
    /// Records it over `canvas`, which is in VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL before and in
    /// VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL after.
    Result<void> draw(GpuCommands& commands, const GpuImage& canvas);
    /// Whether something of the panel is being pressed or dragged at the moment.
    bool holds_pointer() const;

private:
    explicit ImGuiLayer(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    Result<void> make_pass();
    Result<void> start(double scale);
    Result<void> upload_fonts();
    Result<VkFramebuffer> framebuffer_of(const GpuImage& canvas);

    std::shared_ptr<GpuDevice> device_;
    ImGuiContext* context_ = nullptr;
    bool on_vulkan_ = false;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
    std::vector<InputEvent>
        later_;  // what came after a button that was let go in the picture it was pressed in
    std::shared_ptr<const void> canvas_;  // what the framebuffer is of
};

}  // namespace touchable
