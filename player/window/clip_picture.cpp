#include "player/window/clip_picture.hpp"

#include <cstdint>
#include <utility>

namespace touchable {
void ClipPicture::set_overlay(Overlay overlay) {
    if (overlay == overlay_) return;
    overlay_ = overlay;
    shown_.reset();
}

void ClipPicture::forget() {
    shown_.reset();
    overlays_ = std::make_unique<Overlays>();
}

Result<void> ClipPicture::show(const WatchedMoment& moment, const HeightField& field) {
    const FramePair& pair = moment.held.pair;
    const PlaneView colour = moment.colour ? moment.colour->plane : PlaneView{};
    const Shown now{pair.epoch, pair.prev.number, pair.next.number, pair.blend, colour.data};
    if (shown_ == now) return {};
    shown_.reset();
    Result<void> shown;
    if (overlay_ == Overlay::colour) {
        shown = graphics_->show(field, pair, colour, Lighting::lit);
    } else {
        const OverlayPicture& picture = overlays_->paint(overlay_, field, pair);
        scale_ = picture.scale;
        shown = graphics_->show(field, pair, picture.view(), Lighting::plain);
    }
    if (shown.ok()) shown_ = now;
    return shown;
}

Result<void> ClipPicture::draw(const WatchedMoment& moment, const HeightField& field,
                               const ViewCamera& camera, std::span<const FingerMark> fingers,
                               const MarkSizes& sizes, int width, int height) {
    if (auto shown = show(moment, field); !shown.ok()) return shown;
    drawn_width_ = camera.width;
    drawn_height_ = camera.height;
    return graphics_->draw(camera, fingers, sizes, width, height);
}

}  // namespace touchable
