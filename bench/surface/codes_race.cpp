#include "bench/surface/codes_race.hpp"

#include <deque>
#include <memory>

#include "bench/surface/opencv_median.hpp"
#include "bench/surface/race.hpp"

namespace touchable {
namespace {

/// OpenCV's median of a depth plane, which knows neither validity nor bounds.
class OpenCvMedian {
public:
    OpenCvMedian(const RawFrame& raw, int side)
        : depth_(raw.depth),
          side_(side),
          row_bytes_(std::ptrdiff_t{depth_.width} * depth_.bytes_per_sample),
          memory_(static_cast<std::size_t>(row_bytes_) * static_cast<std::size_t>(depth_.height)) {}

    void filter() { opencv_median(depth_, side_, memory_.data(), row_bytes_); }
    bool agrees_with(const SurfaceFrame& frame) const {
        const PlaneView filtered{memory_.data(),          row_bytes_, depth_.width, depth_.height,
                                 depth_.bytes_per_sample, 1};
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x)
                if (filtered.sample(x, y) != frame.codes[frame.index(x, y)]) return false;
        return true;
    }

private:
    const PlaneView depth_;
    const int side_;
    const std::ptrdiff_t row_bytes_;
    std::vector<std::uint8_t> memory_;
};

bool all_valid(const SurfaceFrame& frame) {
    for (const TileBounds& tile : frame.tiles)
        if (tile.any_invalid) return false;
    return true;
}

/// A frame by a builder, into a slot of its own.
struct BuiltFrames {
    SurfaceBuilder& builder;
    SurfaceFrame slot = {};
};

bool same_frames(const SurfaceFrame& a, const SurfaceFrame& b) {
    return a.codes == b.codes && a.validity == b.validity && a.tiles == b.tiles;
}

void add_ratios(Figures& figures, const std::string& side, const std::vector<Racer>& racers,
                const FrameTimes& opencv) {
    const FrameTimes& vulkan = racers.front().times;
    figures.push_back({"median" + side + "_vs_opencv", vulkan.wall_ms / opencv.wall_ms, ""});
    figures.push_back({"median" + side + "_cpu_vs_opencv", vulkan.cpu_ms / opencv.cpu_ms, ""});
    for (std::size_t n = 1; n + 1 < racers.size(); ++n)
        figures.push_back({racers[n].name + "_vs_opencv", racers[n].times.wall_ms / opencv.wall_ms, ""});
}

}  // namespace

Result<void> race_for_codes(const Scene& scene, const RawFrame& raw, VulkanSurfaceBuilder& vulkan, int rounds,
                            Figures& figures) {
    const std::string side = std::to_string(scene.filter.median), cpu = "cpu_builder" + side;
    const auto by_choice = make_cpu_builder(scene), on_one = make_cpu_builder(scene, {1}),
               on_two = make_cpu_builder(scene, {2});
    std::deque<BuiltFrames> frames;
    std::vector<Racer> racers;
    const auto add = [&](const std::string& name, SurfaceBuilder& builder) {
        BuiltFrames& built = frames.emplace_back(BuiltFrames{builder});
        racers.push_back({name, [&raw, &built] { return built.builder.build(raw, built.slot); }});
    };
    add("codes" + side, vulkan);
    add(cpu, *by_choice);
    add(cpu + "_1t", *on_one);
    add(cpu + "_2t", *on_two);

    if (auto once = race(racers, 1); !once.ok()) return once;
    for (std::size_t n = 0; n < racers.size(); ++n)
        if (!same_frames(frames[n].slot, frames[1].slot))
            return Error{ErrorKind::check, racers[n].name + " differs from the CPU builder's frame"};
    OpenCvMedian median(raw, scene.filter.median);
    const bool with_opencv = has_opencv() && scene.filter.median > 0 && all_valid(frames[1].slot);
    if (with_opencv) {
        median.filter();
        if (!median.agrees_with(frames[1].slot))
            return Error{ErrorKind::check, "OpenCV's median " + side + " differs from the CPU builder's"};
        racers.push_back({"opencv_median" + side, [&median]() -> Result<void> {
                              median.filter();
                              return {};
                          }});
    }
    for (Racer& racer : racers) racer.times = {};  // the first frames are no measure of the others
    if (auto raced = race(racers, rounds); !raced.ok()) return raced;
    for (const Racer& racer : racers) add_times(figures, racer.name, racer.times);
    if (with_opencv) add_ratios(figures, side, racers, racers.back().times);
    return {};
}

}  // namespace touchable
