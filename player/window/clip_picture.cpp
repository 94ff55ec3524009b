#include "player/window/clip_picture.hpp"

#include <cstdint>
#include <utility>

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

}  // namespace

Result<ClipPicture> ClipPicture::create(std::shared_ptr<GpuDevice> device, const std::string& painter) {
    auto drawing = SurfaceDrawing::create(device, painter);
    if (!drawing.ok()) return drawing.error();
    return ClipPicture(std::move(device), std::move(*drawing));
}

void ClipPicture::set_overlay(Overlay overlay) {
    if (overlay == overlay_) return;
    overlay_ = overlay;
    shown_.reset();
}

void ClipPicture::forget() {
    shown_.reset();
    overlays_ = std::make_unique<Overlays>();
}

Result<void> ClipPicture::show(GpuCommands& commands, const WatchedMoment& moment, const HeightField& field) {
    const FramePair& pair = moment.held.pair;
    const PlaneView colour = moment.colour ? moment.colour->plane : PlaneView{};
    const Shown now{pair.epoch, pair.prev.number, pair.next.number, pair.blend, colour.data};
    if (shown_ == now) return {};
    shown_.reset();
    Result<void> shown;
    if (overlay_ == Overlay::colour) {
        shown = drawing_->show(commands, field, pair, colour, Lighting::lit);
    } else {
        const OverlayPicture& picture = overlays_->paint(overlay_, field, pair);
        scale_ = picture.scale;
        shown = drawing_->show(commands, field, pair, picture.view(), Lighting::plain);
    }
    if (shown.ok()) shown_ = now;
    return shown;
}

Result<void> ClipPicture::reserve(GpuImage& image, const char* name, int width, int height) const {
    if (image && is_of_size(image, width, height)) return {};
    auto made = GpuImage::create(*device_, name, width, height, VK_FORMAT_R8G8B8A8_UNORM);
    if (!made.ok()) return made.error();
    image = std::move(*made);
    return {};
}

Result<void> ClipPicture::draw(GpuCommands& commands, const WatchedMoment& moment, const HeightField& field,
                               const ViewCamera& camera, std::span<const FingerMark> fingers,
                               const MarkSizes& sizes, int width, int height) {
    if (auto reserved = reserve(canvas_, "canvas", width, height); !reserved.ok()) return reserved;
    if (auto shown = show(commands, moment, field); !shown.ok()) return shown;
    drawn_width_ = camera.width;
    drawn_height_ = camera.height;
    if (is_of_size(canvas_, camera.width, camera.height))
        return drawing_->draw(commands, camera, fingers, sizes, canvas_);
    if (auto reserved = reserve(small_, "small picture", camera.width, camera.height); !reserved.ok())
        return reserved;
    if (auto drawn = drawing_->draw(commands, camera, fingers, sizes, small_); !drawn.ok()) return drawn;
    record_stretch(commands, small_, canvas_);
    commands.mark("stretch");
    return {};
}

}  // namespace touchable
