#include "engine/surface/frame_changes.hpp"

#include <algorithm>
#include <atomic>
#include <iterator>

#include "engine/surface/changed_pixels.hpp"

namespace touchable {
namespace {

/// Where more of all blocks have changed, the frame is built as a whole, so that no more needs to be known.
constexpr double most_changed = 0.5;

/// So many frames are then not compared at all: a clip in which all is moving goes on for a while.
constexpr int frames_of_rest = 8;

BuildNumber new_build_number() {
    static std::atomic<BuildNumber> last{0};
    return ++last;
}

}  // namespace

FrameChanges::FrameChanges(int width, int height, int reach, VectorUnit unit)
    : reach_(reach), unit_(unit), stale_(width, height) {
    for (Step& step : steps_) step.stale = stale_;
    const BlockGrid& grid = stale_.grid();
    boxes_.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
}

BuildNumber FrameChanges::advance(const RawFrame& raw, RowBands& bands) {
    std::rotate(steps_.begin(), steps_.begin() + 1, steps_.end());
    Step& step = steps_.back();
    step.build = new_build_number();
    step.all = newest_.depth.empty() || !same_form(newest_.depth, raw.depth) || rest_ > 0;
    rest_ = std::max(rest_ - 1, 0);
    step.touch_planes =
        step.all || !same_samples(newest_.haptic, raw.haptic) || !same_samples(newest_.height, raw.height);
    if (!step.all) {
        compare_depth(raw.depth, bands, step);
        if (step.all) comparing_was_in_vain();
    }
    newest_ = raw.storage ? raw : RawFrame{};
    return step.build;
}

void FrameChanges::comparing_was_in_vain() {
    rest_ = frames_of_rest;
}

void FrameChanges::compare_depth(const PlaneView& after, RowBands& bands, Step& step) {
    const BlockGrid& grid = step.stale.grid();
    const PlaneComparison planes(newest_.depth, after, unit_);
    const auto most = static_cast<std::ptrdiff_t>(most_changed * static_cast<double>(boxes_.size()));
    std::ptrdiff_t at_top = 0;
    for (int row = 0; row < grid.rows; ++row) at_top += planes.changed_at_top(row);
    step.all = at_top > most;
    if (step.all) return;

    columns_.resize(static_cast<std::size_t>(bands.threads()));
    bands.for_each_band(grid.rows, 1, [&](const RowBand& band) {
        for (int row = band.first; row < band.last; ++row)
            planes.find(row,
                        std::span(boxes_).subspan(static_cast<std::size_t>(row * grid.columns),
                                                  static_cast<std::size_t>(grid.columns)),
                        columns_[static_cast<std::size_t>(band.thread)]);
    });
    const auto unchanged =
        std::count_if(boxes_.begin(), boxes_.end(), [](const PixelBox& b) { return b.empty(); });
    step.all = std::ssize(boxes_) - unchanged > most;
    if (step.all) return;

    step.stale.clear();
    for (PixelBox& box : boxes_) {
        if (box.empty()) continue;
        planes.narrow(box);
        step.stale.add(
            PixelBox{box.left - reach_, box.top - reach_, box.right + reach_, box.bottom + reach_});
    }
}

std::optional<std::span<const FrameChanges::Step>> FrameChanges::steps_since(BuildNumber held) const {
    if (held == 0) return std::nullopt;
    const auto step =
        std::find_if(steps_.begin(), steps_.end(), [&](const Step& s) { return s.build == held; });
    if (step == steps_.end()) return std::nullopt;
    return std::span<const Step>(step + 1, steps_.end());
}

const BlockMap* FrameChanges::stale_blocks(BuildNumber held) {
    const auto steps = steps_since(held);
    if (!steps) return nullptr;
    stale_.clear();
    for (const Step& step : *steps) {
        if (step.all) return nullptr;
        stale_.add(step.stale);
    }
    return &stale_;
}

bool FrameChanges::same_touch_planes(BuildNumber held) const {
    const auto steps = steps_since(held);
    return steps && std::none_of(steps->begin(), steps->end(), [](const Step& s) { return s.touch_planes; });
}

}  // namespace touchable
