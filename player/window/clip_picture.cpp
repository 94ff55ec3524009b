#include "player/window/clip_picture.hpp"

#include <utility>

namespace touchable {

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

Result<void> ClipPicture::reserve_canvas(int width, int height) {
    if (width == width_ && height == height_) return {};
    auto canvas = GpuImage::create(*device_, "canvas", width, height, VK_FORMAT_R8G8B8A8_UNORM);
    if (!canvas.ok()) return canvas.error();
    canvas_ = std::move(*canvas);
    width_ = width;
    height_ = height;
    return {};
}

Result<void> ClipPicture::draw(GpuCommands& commands, const WatchedMoment& moment, const HeightField& field,
                               const ViewCamera& camera, std::span<const FingerMark> fingers,
                               const MarkSizes& sizes) {
    if (auto reserved = reserve_canvas(camera.width, camera.height); !reserved.ok()) return reserved;
    if (auto shown = show(commands, moment, field); !shown.ok()) return shown;
    return drawing_->draw(commands, camera, fingers, sizes, canvas_);
}

}  // namespace touchable
