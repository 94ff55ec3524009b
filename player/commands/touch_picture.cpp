#include "player/commands/touch_picture.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "engine/stop_request.hpp"
#include "player/run/field_probe.hpp"

namespace touchable {
namespace {

constexpr std::size_t trail_ticks = 500;
constexpr std::size_t trail_step = 4;  // ticks between two points that are drawn

/// A frame of the clip, read and built once more.
struct FrameAgain {
    RawFrame raw;
    SurfaceFrame surface;
};

/// The first frame that those of an epoch are made of, `number` being one of them: that one alone, or where a
/// filter remembers what it has seen since the epoch's start.
std::int64_t first_read(const TouchSetup& setup, std::uint64_t epoch, std::int64_t number) {
    if (!setup.scene.filter.temporal) return number;
    PlaybackClock clock(setup.scene.rate, setup.settings.playback);
    std::int64_t start_ns = 0;
    for (auto next = clock.next_epoch(); next && next->number <= epoch; next = clock.next_epoch())
        start_ns = next->start_ns;
    if (epoch == 0) return 0;
    const std::int64_t first = std::min(setup.scene.rate.frame_at(start_ns), number);
    return std::max<std::int64_t>(0, first - setup.warm_up_frames);
}

/// Reads on until frame `number`, and builds it, and of those before it those that it is made of.
Result<void> read_frame(ClipReader& reader, SurfaceBuilder& builder, std::int64_t number,
                        const std::function<bool(std::int64_t)>& is_part, FrameAgain& frame) {
    for (;;) {
        auto raw = reader.next();
        if (!raw.ok()) return raw.error();
        if (!*raw) return input_error("the clip ends before frame " + std::to_string(number) + " this time");
        const bool wanted = (*raw)->number == number;
        if (!wanted && !is_part((*raw)->number)) continue;
        frame.raw = **raw;
        if (auto built = builder.build(frame.raw, frame.surface); wanted || !built.ok()) return built;
    }
}

}  // namespace

std::int64_t usual_picture_tick(const TouchSetup& setup) {
    const auto known = setup.ticks();
    if (known) return *known * 6 / 10;
    if (!setup.settings.playback.empty()) return shortest_run_ns / tick_ns * 6 / 10;
    const auto frames = setup.feed->reader().frame_count();
    const std::int64_t clip_ms = frames ? setup.scene.rate.time_ns(*frames) / 1'000'000 : 0;
    return std::max<std::int64_t>(clip_ms, 3000) * 6 / 10;
}

Result<void> TouchPicture::take(const TouchTick& tick) {
    if (reached_) return {};
    trails_.resize(tick.contacts.size());
    for (std::size_t k = 0; k < trails_.size(); ++k) {
        const Contact& contact = tick.contacts[k];
        if (!contact.touching || !std::isfinite(contact.pixel_x) || !std::isfinite(contact.pixel_y)) {
            trails_[k].clear();
            continue;
        }
        trails_[k].emplace_back(contact.pixel_x, contact.pixel_y);
        if (trails_[k].size() > trail_ticks) trails_[k].pop_front();
    }
    reached_ = tick.tick >= tick_;
    moment_ = Moment{tick.pair.epoch, tick.pair.prev.number, tick.pair.next.number, tick.pair.blend, {}};
    for (std::size_t k = 0; k < trails_.size(); ++k) {
        const Contact& contact = tick.contacts[k];
        moment_->fingers.push_back({contact.goal, contact.proxy, tick.sent(k), contact.touching, {}});
    }
    return {};
}

std::vector<FingerMark> TouchPicture::fingers_on(const HeightField& field) const {
    const FieldProbe probe(field);
    std::vector<FingerMark> fingers = moment_->fingers;
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        const std::deque<Place>& trail = trails_[k];
        for (std::size_t at = trail.empty() ? 0 : (trail.size() - 1) % trail_step; at < trail.size();
             at += trail_step)
            if (const auto depth = probe.depth_under(trail[at].x, trail[at].y))
                fingers[k].trail.push_back(probe.unproject(trail[at].x, trail[at].y, *depth));
    }
    return fingers;
}

Result<void> TouchPicture::finish(const TouchSetup& setup, bool cut_short) {
    if (!moment_ || !(reached_ || cut_short))
        return usage_error("--picture: the run ended before " + std::to_string(tick_) +
                           " ms, the moment to draw; --picture-at says another");
    const WorkAfterStop drawing;  // of a run that a person has ended
    auto reader = setup.clip.open();
    if (!reader.ok()) return reader.error();
    // Frames of the GPU that also draws stay there; others are built here, whole.
    const bool on_gpu = setup.feed->builder_name() == "vulkan";
    const auto builder = make_builder(on_gpu ? setup.builder : BuilderChoice{}, setup.scene, *setup.gpu);
    if (!builder.ok()) return builder.error();
    const std::int64_t first = first_read(setup, moment_->epoch, moment_->frame_prev);
    if (auto there = (*reader)->seek(first); !there.ok()) return there;
    FrameAgain prev, next;
    const auto is_part = [&](std::int64_t number) {
        return setup.scene.filter.temporal && !setup.feed->has_dropped(moment_->epoch, number);
    };
    if (auto read = read_frame(**reader, **builder, moment_->frame_prev, is_part, prev); !read.ok())
        return read;
    const bool between = moment_->frame_next != moment_->frame_prev;
    if (between)
        if (auto read = read_frame(**reader, **builder, moment_->frame_next, is_part, next); !read.ok())
            return read;

    FramePair pair;
    pair.prev = {moment_->frame_prev, 0, &prev.surface};
    pair.next = {moment_->frame_next, 0, between ? &next.surface : &prev.surface};
    pair.blend = moment_->blend;
    const HeightField field(setup.scene, pair);
    const RawFrame& nearer = field.blend() >= 0.5 ? next.raw : prev.raw;
    if (auto done = order_.deliver(field, pair, nearer.colour, fingers_on(field)); !done.ok()) return done;
    const std::string gpu = order_.painter->gpu_name();
    std::ostringstream line;
    line << "picture: " << order_.file->target().string() << " by the " << order_.painter->name()
         << " painter" << (gpu.empty() ? "" : " on " + gpu) << "; 1 N is "
         << mark_sizes(setup.scene, subject_of(field).middle).length_per_newton << " units long\n";
    line_ = line.str();
    return {};
}

}  // namespace touchable
