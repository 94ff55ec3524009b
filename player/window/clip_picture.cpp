// SPDX-License-Identifier: Apache-2.0
#include "player/window/clip_picture.hpp"

#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "player/window/brush.hpp"

namespace touchable {
namespace {

using TintRgb = std::array<std::uint8_t, 3>;

constexpr TintRgb tint_of_holes{24, 24, 28}, tint_of_borders{12, 12, 16};
constexpr int pale = 150;                          // blended half into a guess's colour
constexpr int grey_brightness = 160;               // without a clip colour
constexpr int darkest = 104, of_brightness = 152;  // of 256: black's brightness, and white's additional

int brightness_at(const PlaneView& colour, int x, int y, int width, int height) {
    if (colour.empty() || colour.channels < 3 || colour.bytes_per_sample != 1) return grey_brightness;
    const std::uint8_t* const rgb = colour_at(colour, x, y, width, height);
    return (77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]) >> 8;
}

/// Guesses are paler.
TintRgb tint_of(const PaintedSegments::Paint& paint) {
    TintRgb colour = material_colour(paint.material);
    if (paint.is_guess)
        for (std::uint8_t& c : colour) c = static_cast<std::uint8_t>((c + pale) / 2);
    return colour;
}

constexpr double small_newtons = 0.01;

std::span<const WatchedTick::Finger> shown_of(const WatchedMoment& moment, int count) {
    const std::span fingers(moment.felt.fingers);
    return fingers.first(std::min(fingers.size(), static_cast<std::size_t>(count)));
}

ShownFrames frames_of(const WatchedMoment& moment) {
    const FramePair& pair = moment.held.pair;
    return {pair.epoch, pair.prev.number, pair.next.number, pair.blend, moment.colour().data};
}

}  // namespace

PlaneView SegmentTint::paint(const std::shared_ptr<const PaintedSegments>& painted, std::int64_t frame,
                             const PlaneView& colour) {
    const SegmentStore& segments = *painted->segments;
    frame = std::clamp<std::int64_t>(frame, 0, segments.frames() - 1);
    if (painted != painted_ || frame != frame_ || colour.data != colour_) {
        painted_ = painted;
        frame_ = frame;
        colour_ = colour.data;
        paint_anew(colour);
    }
    const int width = segments.width();
    return {rgb_.data(), std::ptrdiff_t{3} * width, width, segments.height(), 1, 3};
}

void SegmentTint::paint_anew(const PlaneView& colour) {
    const SegmentStore& segments = *painted_->segments;
    const int width = segments.width(), height = segments.height();
    segments.read_labels(frame_, labels_);
    std::vector<TintRgb> colours(65536, material_colour(""));
    std::vector<std::uint16_t> things(65536);  // the first segment of that name, as joined ones have no
                                               // border
    std::map<std::string, std::uint16_t> by_name;
    for (const auto& [label, paint] : painted_->by_label) {
        colours[label] = tint_of(paint);
        things[label] = paint.name.empty() ? label : by_name.emplace(paint.name, label).first->second;
    }
    const auto label_at = [&](int x, int y) {
        return labels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)];
    };
    const int line = std::max(1, width / 480);
    rgb_.resize(labels_.size() * 3);
    std::uint8_t* to = rgb_.data();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, to += 3) {
            const std::uint16_t label = label_at(x, y);
            const bool is_border = things[label_at(std::min(x + line, width - 1), y)] != things[label] ||
                                   things[label_at(x, std::min(y + line, height - 1))] != things[label];
            if (label == 0 || is_border) {
                std::ranges::copy(is_border ? tint_of_borders : tint_of_holes, to);
                continue;
            }
            const int share = darkest + of_brightness * brightness_at(colour, x, y, width, height) / 255;
            for (std::size_t c = 0; c < 3; ++c)
                to[c] = static_cast<std::uint8_t>(colours[label][c] * share >> 8);
        }
}

void ClipPicture::set_overlay(Overlay overlay) {
    if (overlay == overlay_) return;
    overlay_ = overlay;
    shown_.reset();
}

void ClipPicture::set_light(Lighting light) {
    light_ = light;
    shown_.reset();
}

Result<void> ClipPicture::show(const WatchedMoment& moment, const HeightField& field, int step) {
    const FramePair& pair = moment.held.pair;
    const PlaneView colour = moment.colour();
    const Shown now{frames_of(moment), tinted_, step};
    if (shown_ == now) return {};
    shown_.reset();
    Result<void> shown;
    if (overlay_ == Overlay::colour) {
        const PlaneView seen = tinted_ ? tint_.paint(tinted_, pair.prev.number, colour) : colour;
        shown = graphics_->show(field, pair, seen, light_, step);
    } else {
        const Overlays::Picture& picture = overlays_->paint(overlay_, field, pair);
        scale_ = picture.scale;
        shown = graphics_->show(field, pair, picture.view(), Lighting::values, step);
    }
    if (shown) shown_ = now;
    return shown;
}

Result<void> ClipPicture::draw(const WatchedMoment& moment, const HeightField& field,
                               const ViewCamera& camera, std::span<const FingerMark> fingers,
                               const MarkSizes& sizes, int width, int height, int step) {
    TRY(show(moment, field, step));
    drawn_width_ = camera.width;
    drawn_height_ = camera.height;
    return graphics_->draw(camera, fingers, sizes, width, height);
}

bool DrawnState::differs(const WatchedMoment& moment, int count, double small) const {
    // A finger without a position, whose distances are no numbers, looks the same.
    const auto looks_same = [small](const WatchedTick::Finger& a, const WatchedTick::Finger& b) {
        return !(glm::distance(a.contact.goal, b.contact.goal) > small ||
                 glm::distance(a.contact.proxy, b.contact.proxy) > small ||
                 glm::distance(a.force.force, b.force.force) > small_newtons);
    };
    return frames_of(moment) != frames_ || !std::ranges::equal(shown_of(moment, count), fingers_, looks_same);
}

void DrawnState::remember(const WatchedMoment& moment, int count) {
    frames_ = frames_of(moment);
    const auto fingers = shown_of(moment, count);
    fingers_.assign(fingers.begin(), fingers.end());
}

void PictureGovernor::go_to(std::size_t level, double now_s) {
    const bool rises = level < level_;
    // A level that failed soon after a rise is retried after doubled waits.
    if (!rises) wait_s_ = rose_ && now_s - changed_s_ < wait_s_ ? std::min(2 * wait_s_, most_s) : least_s;
    level_ = level;
    rose_ = rises;
    changed_s_ = now_s;
}

void PictureGovernor::add(double now_s, std::int64_t due, std::int64_t in_time, double drawing,
                          bool coarse_saves) {
    // Without savings, coarse is the first level.
    const std::size_t least = coarse_saves ? 0 : 1;
    level_ = std::max(level_, least);
    due_ += due;
    in_time_ += in_time;
    drawing_ += drawing;
    ++pictures_;
    // Lateness can be judged before all frames are due; savings cannot.
    const bool is_lowest = level_ + 1 == std::size(levels), is_judged = before_ > 0 && is_lowest;
    if (due_ < few && (is_judged || static_cast<double>(due_ - in_time_) <= (1 - tolerated) * few)) return;
    const double drawing_each = drawing_ / static_cast<double>(pictures_);
    const bool is_late =
        drawing_each > cause && static_cast<double>(in_time_) < tolerated * static_cast<double>(due_);
    due_ = in_time_ = pictures_ = 0;
    drawing_ = 0;
    if (before_ > 0 && (is_lowest || !is_late)) {
        judge(drawing_each, is_late, now_s);
    } else if (is_late && !is_lowest && now_s >= not_before_s_) {
        if (before_ == 0) {
            before_ = drawing_each;
            from_ = level_;
            judged_ = 0;
        }
        std::size_t level = level_;
        double expected = drawing_each;
        do expected /= levels[level++].dearer;
        while (expected > 1 && level + 1 < std::size(levels));
        go_to(level, now_s);
    } else if (!is_late && level_ > least && now_s - changed_s_ >= wait_s_) {
        if (drawing_each * levels[level_ - 1].dearer < room) go_to(level_ - 1, now_s);
    }
}

/// Judges at the lowest level, as a single step may save too little time while decoding takes what it frees.
/// Just after a clip has opened, or beside a busy program, pictures may take equally long at every level:
/// while they are late, judging is repeated.
void PictureGovernor::judge(double drawing_each, bool is_late, double now_s) {
    const bool saves = drawing_each <= worth * before_;
    if (!saves && is_late && ++judged_ < judgements) return;
    before_ = 0;
    if (saves || !is_late) return;
    go_to(from_, now_s);
    not_before_s_ = now_s + most_s;
}

void FramesShown::add(const FramePair& pair, std::int64_t now_ns, std::int64_t period_ns) {
    const bool is_next = pair.epoch == epoch_ && number_ >= 0 && pair.prev.number > number_;
    if (is_next) {
        due_ += pair.prev.number - number_;
        in_time_ += now_ns - pair.prev.time_ns <= period_ns;
    }
    epoch_ = pair.epoch;
    number_ = pair.prev.number;
}

void SlowReading::add(const WatchedFigures& figures, double period_ms) {
    constexpr std::int64_t least_late = 16, one_in = 4;
    if (figures.feed.frames == frames_) return;
    frames_ = figures.feed.frames;
    ++looks_;
    read_ms_ += figures.feed.read_ms;
    build_ms_ += figures.feed.build_ms;
    const std::int64_t late = figures.late_frames + figures.feed.dropped,
                       all = frames_ + figures.feed.dropped;
    is_why_ |=
        late >= least_late && one_in * late >= all && read_ms_ > build_ms_ && read_ms() >= 0.5 * period_ms;
}

}  // namespace touchable
