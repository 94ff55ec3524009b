#include "player/session/surface_feed.hpp"

#include <cassert>
#include <chrono>

#include "engine/frame/stored_code.hpp"
#include "engine/surface/filter_plan.hpp"

namespace touchable {

namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Ends at the first.
bool has_valid_pixel(const PlaneView& depth, const DepthCoding& coding) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (coding.is_valid(stored_code(depth, coding, x, y))) return true;
    return false;
}

}  // namespace

SurfaceFeed::SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                         const Scene& scene)
    : reader_(std::move(reader)),
      builder_(std::move(builder)),
      rate_(scene.rate),
      stored_(scene.depth),
      settles_(FilterPlan(scene).remembers()) {}

Result<std::optional<RawFrame>> SurfaceFeed::read_next() {
    const auto start = std::chrono::steady_clock::now();
    auto raw = reader_->next();
    if (raw.ok() && *raw) read_ms_.push_back(milliseconds_since(start));
    return raw;
}

Result<bool> SurfaceFeed::publish(const RawFrame& raw) {
    const auto start = std::chrono::steady_clock::now();
    const bool unchanged = !settles_ && newest_ && same_touch_planes(*newest_, raw);
    const auto published = unchanged ? timeline_.republish(raw.number, raw.time_ns) : build(raw);
    if (!published.ok() || !*published) return published;
    build_ms_.push_back(milliseconds_since(start));
    hash_.add(raw);
    any_valid_ = any_valid_ || has_valid_pixel(raw.depth, stored_);
    ++frames_;
    unchanged_frames_ += unchanged;
    skipped_frames_ += unchanged ? 1 : 1 - builder_->built_share();
    return true;
}

Result<bool> SurfaceFeed::build(const RawFrame& raw) {
    SurfaceFrame* slot = timeline_.acquire();
    if (!slot) return false;
    if (auto built = builder_->build(raw, *slot); !built.ok()) return built.error();
    if (auto published = timeline_.publish(raw.number, raw.time_ns); !published.ok())
        return published.error();
    if (!settles_ && raw.storage)
        newest_ = raw;
    else
        newest_.reset();
    return true;
}

Result<void> SurfaceFeed::publish_next() {
    const auto raw = read_next();
    if (!raw.ok()) return raw.error();
    if (!*raw) {
        ended_ = true;
        return {};
    }
    const auto published = publish(**raw);
    if (!published.ok()) return published.error();
    assert(*published && "the reader of virtual time never holds more than a pair");
    return {};
}

Result<FramePair> SurfaceFeed::pair_at(std::int64_t time_ns) {
    FramePair pair;
    // The reader's oldest frame follows it before each build, so that a slot is free however far time jumps.
    while (!ended_ && timeline_.newest_time() <= time_ns) {
        timeline_.pair_at(time_ns, pair);
        if (auto published = publish_next(); !published.ok()) return published.error();
    }
    if (!timeline_.pair_at(time_ns, pair))
        return input_error("the clip has no frames; there is nothing to touch");
    return pair;
}

Result<FramePair> SurfaceFeed::pair_of(std::int64_t prev, std::int64_t next, double blend) {
    auto pair = pair_at(rate_.time_ns(prev));
    if (!pair.ok()) return pair;
    if (next == prev) pair->next = pair->prev;
    if (pair->prev.number != prev || pair->next.number != next)
        return input_error("the clip has no frames " + std::to_string(prev) + " and " + std::to_string(next) +
                           " side by side");
    pair->blend = next == prev ? 0.0 : blend;
    return pair;
}

}  // namespace touchable
