#include <optional>
#include <utility>

#include "player/screen/canvas.hpp"
#include "player/screen/imgui_vulkan.hpp"
#include "player/screen/window_graphics.hpp"
#include "player/view/cpu_drawing.hpp"
#include "player/view/surface_drawing.hpp"
#include "player/view/upload_pool.hpp"

namespace touchable {
namespace {

bool is_of_size(const GpuImage& image, int width, int height) {
    return image.extent().width == static_cast<std::uint32_t>(width) &&
           image.extent().height == static_cast<std::uint32_t>(height);
}

VkOffset3D corner_of(const GpuImage& image) {
    return {static_cast<std::int32_t>(image.extent().width), static_cast<std::int32_t>(image.extent().height),
            1};
}

/// From one that was drawn to another that is to be drawn over.
void record_stretch(GpuCommands& commands, const GpuImage& from, const GpuImage& to) {
    constexpr VkImageLayout drawn = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    record_transition(commands, from, drawn, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    record_transition(commands, to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkImageBlit region{};
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffsets[1] = corner_of(from);
    region.dstOffsets[1] = corner_of(to);
    vkCmdBlitImage(commands.handle(), from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region, VK_FILTER_LINEAR);
    record_transition(commands, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, drawn);
}

/// Draws on a canvas that stays on the GPU.
class GpuGraphics final : public WindowGraphics {
public:
    GpuGraphics(std::shared_ptr<GpuDevice> device, Screen& screen)
        : device_(std::move(device)), screen_(screen), uploads_(device_) {}

    Result<void> open(std::string_view painter) {
        if (painter == "cpu") {
            by_cpu_.emplace();
        } else {
            auto drawing = SurfaceDrawing::create(device_, painter);
            if (!drawing.ok()) return drawing.error();
            drawing_ = std::move(*drawing);
        }
        auto imgui = ImGuiVulkan::create(device_);
        if (!imgui.ok()) return imgui.error();
        imgui_ = std::move(*imgui);
        return {};
    }

    std::string_view painter() const override { return drawing_ ? drawing_->painter() : "cpu"; }
    std::string gpu() const override { return device_->facts().name; }
    bool is_lost() const override { return device_->lost(); }
    bool can_stretch() const override { return true; }

    Result<void> begin() override {
        auto commands = GpuCommands::begin(device_, "window");
        if (!commands.ok()) return commands.error();
        commands_.emplace(std::move(*commands));
        return {};
    }

    Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting) override {
        if (!drawing_) {
            by_cpu_->show(field, pair, colour, lighting);
            return {};
        }
        auto commands = GpuCommands::begin(device_, "surface");
        if (!commands.ok()) return commands.error();
        if (auto shown = drawing_->show(*commands, field, pair, colour, lighting); !shown.ok()) return shown;
        return std::move(*commands).run();
    }

    Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                      int width, int height) override {
        if (auto reserved = reserve(canvas_, "canvas", width, height); !reserved.ok()) return reserved;
        if (is_of_size(canvas_, camera.width, camera.height)) return draw_on(canvas_, camera, fingers, sizes);
        if (auto reserved = reserve(small_, "small picture", camera.width, camera.height); !reserved.ok())
            return reserved;
        if (auto drawn = draw_on(small_, camera, fingers, sizes); !drawn.ok()) return drawn;
        record_stretch(*commands_, small_, canvas_);
        commands_->mark("stretch");
        return {};
    }

    Result<void> finish() override {
        if (auto drawn = imgui_->draw(*commands_, canvas_); !drawn.ok()) return drawn;
        commands_->mark("panel");
        GpuCommands commands = std::move(*commands_);
        commands_.reset();
        return screen_.present(std::move(commands), canvas_);
    }

    Result<Image> picture() const override {
        if (!canvas_) return usage_error("there is no picture yet that could be kept");
        return read_back(device_, canvas_);
    }

private:
    Result<void> reserve(GpuImage& image, const char* name, int width, int height) const {
        if (image && is_of_size(image, width, height)) return {};
        auto made = GpuImage::create(*device_, name, width, height, VK_FORMAT_R8G8B8A8_UNORM);
        if (!made.ok()) return made.error();
        image = std::move(*made);
        return {};
    }

    Result<void> draw_on(const GpuImage& image, const ViewCamera& camera, std::span<const FingerMark> fingers,
                         const MarkSizes& sizes) {
        if (drawing_) return drawing_->draw(*commands_, camera, fingers, sizes, image);
        const auto drawn = by_cpu_->draw(camera, fingers, sizes);
        if (!drawn.ok()) return drawn.error();
        return upload(**drawn, image);
    }

    /// The CPU's picture.
    Result<void> upload(const Image& picture, const GpuImage& image) {
        const std::size_t pixels = picture.samples.size() / 3;
        const auto buffer = uploads_.take("picture", 4 * pixels);
        if (!buffer.ok()) return buffer.error();
        const auto to = buffer->mapped<PackedColour>();
        const std::uint8_t* rgb = picture.samples.data();
        for (std::size_t k = 0; k < pixels; ++k, rgb += 3) to[k] = pack_colour(rgb[0], rgb[1], rgb[2]);
        record_transition(*commands_, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {image.extent().width, image.extent().height, 1};
        vkCmdCopyBufferToImage(commands_->handle(), buffer->handle(), image.handle(),
                               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
        commands_->keep(buffer->keep_alive());
        record_transition(*commands_, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        return {};
    }

    std::shared_ptr<GpuDevice> device_;
    Screen& screen_;
    std::unique_ptr<SurfaceDrawing> drawing_;
    std::optional<CpuDrawing> by_cpu_;  // in place of it
    UploadPool uploads_;
    std::unique_ptr<ImGuiVulkan> imgui_;
    GpuImage canvas_, small_;              // small: what is stretched over it, if anything is
    std::optional<GpuCommands> commands_;  // of the picture that was begun
};

}  // namespace

Result<std::unique_ptr<WindowGraphics>> make_gpu_graphics(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter, Screen& screen) {
    auto graphics = std::make_unique<GpuGraphics>(std::move(device), screen);
    if (auto opened = graphics->open(painter); !opened.ok()) return opened.error();
    return std::unique_ptr<WindowGraphics>(std::move(graphics));
}

}  // namespace touchable
