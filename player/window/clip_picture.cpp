#include "player/window/clip_picture.hpp"

#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
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

Result<void> ClipPicture::show(const WatchedMoment& moment, const HeightField& field, int step) {
    const FramePair& pair = moment.held.pair;
    const PlaneView colour = moment.colour();
    const Shown now{pair.epoch, pair.prev.number, pair.next.number, pair.blend, colour.data, tinted_, step};
    if (shown_ == now) return {};
    shown_.reset();
    Result<void> shown;
    if (overlay_ == Overlay::colour) {
        const PlaneView seen = tinted_ ? tint_.paint(tinted_, pair.prev.number, colour) : colour;
        shown = graphics_->show(field, pair, seen, Lighting::lit, step);
    } else {
        const OverlayPicture& picture = overlays_->paint(overlay_, field, pair);
        scale_ = picture.scale;
        shown = graphics_->show(field, pair, picture.view(), Lighting::plain, step);
    }
    if (shown.ok()) shown_ = now;
    return shown;
}

Result<void> ClipPicture::draw(const WatchedMoment& moment, const HeightField& field,
                               const ViewCamera& camera, std::span<const FingerMark> fingers,
                               const MarkSizes& sizes, int width, int height, int step) {
    if (auto shown = show(moment, field, step); !shown.ok()) return shown;
    drawn_width_ = camera.width;
    drawn_height_ = camera.height;
    return graphics_->draw(camera, fingers, sizes, width, height);
}

namespace {

constexpr double small_newtons = 0.01;

std::size_t shown_of(const WatchedMoment& moment, int count) {
    return std::min(moment.felt.fingers.size(), static_cast<std::size_t>(count));
}
const void* colour_of(const WatchedMoment& moment) {
    return moment.colour().data;
}

}  // namespace

bool DrawnState::is_other_frame(const WatchedMoment& moment) const {
    const FramePair& pair = moment.held.pair;
    return pair.epoch != epoch_ || pair.prev.number != prev_;
}

bool DrawnState::differs(const WatchedMoment& moment, int count, double small) const {
    const FramePair& pair = moment.held.pair;
    if (is_other_frame(moment) || pair.next.number != next_ || pair.blend != blend_ ||
        colour_of(moment) != colour_ || shown_of(moment, count) != fingers_.size())
        return true;
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        const WatchedFinger& now = moment.felt.fingers[k];
        if (glm::distance(now.contact.goal, fingers_[k].goal) > small ||
            glm::distance(now.contact.proxy, fingers_[k].proxy) > small ||
            glm::distance(now.force.force, fingers_[k].force) > small_newtons)
            return true;
    }
    return false;
}

void DrawnState::remember(const WatchedMoment& moment, int count) {
    const FramePair& pair = moment.held.pair;
    epoch_ = pair.epoch;
    prev_ = pair.prev.number;
    next_ = pair.next.number;
    blend_ = pair.blend;
    colour_ = colour_of(moment);
    fingers_.resize(shown_of(moment, count));
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        const WatchedFinger& now = moment.felt.fingers[k];
        fingers_[k] = {now.contact.goal, now.contact.proxy, now.force.force};
    }
}

}  // namespace touchable
