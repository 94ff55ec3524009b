#include "bench/targets.hpp"

namespace touchable {
namespace {

using Names = std::vector<std::string>;

std::vector<Target> make_surface_targets() {
    using Sense = Limit::Sense;
    const Names full_hd{"1920x1080-16"}, ultra_hd{"3840x2160-16"}, full_hd_8{"1920x1080-8"};
    std::vector<Target> targets;
    const auto add = [&](const char* what, const Names& cases, const char* metric, Sense sense, double value,
                         const char* unit) {
        targets.push_back({what, cases, metric, {value, sense, unit}});
        return &targets.back();
    };
    add("median 3x3 over OpenCV's, wall time", full_hd, "median3_vs_opencv", Sense::at_most, 1.3, "");
    add("  CPU time", full_hd, "median3_cpu_vs_opencv", Sense::none, 0, "");
    add("median 5x5 over OpenCV's, wall time", full_hd, "median5_vs_opencv", Sense::at_most, 0.3, "");
    add("  CPU time", full_hd, "median5_cpu_vs_opencv", Sense::none, 0, "");
    add("codes and bounds, 3x3", full_hd, "codes3_ms", Sense::at_most, 1.0, "ms");
    add("codes and positions, 3x3", full_hd, "positions3_ms", Sense::at_most, 3.5, "ms");
    add("  3840x2160", ultra_hd, "positions3_ms", Sense::at_most, 25, "ms");
    // Four times the pixels, plus a tenth because caches hold a smaller part of them.
    add("  3840x2160 over 1920x1080", ultra_hd, "positions3_ms", Sense::at_most, 4.4, "")->relative_to =
        full_hd.front();
    add("codes and cut tiles over OpenCV's", full_hd, "mask3_vs_opencv_mask", Sense::at_most, 0.8, "");
    add("a tenth of the tiles changed over full, CPU", full_hd, "dirty10_vs_full", Sense::at_most, 0.25, "");
    add("  by Vulkan", full_hd, "vulkan_dirty10_vs_full", Sense::at_most, 0.25, "");
    add("  CPU time", full_hd, "vulkan_dirty10_cpu_vs_full", Sense::none, 0, "");
    add("unchanged frame, CPU", full_hd, "unchanged_ms", Sense::at_most, 0.25, "ms");
    add("  by Vulkan", full_hd, "vulkan_unchanged_ms", Sense::at_most, 0.25, "ms");
    add("CPU builder, codes and bounds, 3x3", full_hd, "cpu_builder3_ms", Sense::at_most, 1.2, "ms");
    add("  with positions, 2 threads", full_hd, "cpu_positions3_2t_ms", Sense::at_most, 1.2, "ms");
    add("lazy builder, 5 fingers, 5x5, added to a tick", full_hd, "lazy_us_per_tick_5f", Sense::at_most, 5,
        "us");
    add("terraces removed, 8 bits", full_hd_8, "terraces_ms", Sense::at_most, 3, "ms");
    add("  by the CPU builder", full_hd_8, "cpu_builder_terraces_ms", Sense::at_most, 3, "ms");
    add("device to first surface, warm cache", {"1920x1080-16-start"}, "first_surface_ms", Sense::at_most,
        1000, "ms");
    add("as fast as a copy of the bytes, on a GPU", {full_hd.front(), ultra_hd.front()}, "bandwidth_pct",
        Sense::at_least, 60, "%")
        ->only_where = "on_gpu";
    add("codes that differ from the CPU builder's",
        {"320x240-8", "320x240-16", "720x480-8", "720x480-16", "1920x1080-8", "1920x1080-16",
         "1920x1080-16-holes40", "3840x2160-8", "3840x2160-16"},
        "mismatched_codes", Sense::at_most, 0, "");
    return targets;
}

}  // namespace

const std::vector<Target>& surface_targets() {
    static const std::vector<Target> targets = make_surface_targets();
    return targets;
}

}  // namespace touchable
