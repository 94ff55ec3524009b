// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

namespace touchable {
namespace {

using Names = std::vector<std::string>;

std::vector<Target> make_surface_targets() {
    using Sense = Limit::Sense;
    const Names full_hd{"1920x1080-16"}, full_hd_8{"1920x1080-8"}, large{"1920x1080-16", "3840x2160-16"};
    std::vector<Target> targets;
    const auto add = [&](const char* what, const Names& cases, const char* metric, Sense sense, double value,
                         const char* unit) {
        targets.push_back({what, cases, metric, {value, sense, unit}});
        return &targets.back();
    };
    const auto on_gpu = [&](const char* what, const Names& cases, const char* metric, Sense sense,
                            double value, const char* unit = "") {
        add(what, cases, metric, sense, value, unit)->only_where = "on_gpu";
    };
    // Times are ratios within the run, where other load counts: of CPU time. On a GPU: of wall time.
    // What bounds a software Vulkan, and frames that change in part, is in docs/measurements.md.
    add("median 3x3 by Vulkan over OpenCV's", large, "median3_cpu_vs_opencv", Sense::at_most, 8.5, "");
    on_gpu("  on a GPU", full_hd, "median3_vs_opencv", Sense::at_most, 1.3);
    on_gpu("median 5x5 over OpenCV's, on a GPU", full_hd, "median5_vs_opencv", Sense::at_most, 0.3);
    on_gpu("codes and positions over OpenCV's, on a GPU", full_hd, "positions3_vs_opencv", Sense::at_most,
           0.85);
    on_gpu("codes and cut tiles over OpenCV's, on a GPU", full_hd, "mask3_vs_opencv_mask", Sense::at_most,
           0.8);
    on_gpu("terraces over the CPU builder's, on a GPU", full_hd_8, "terraces_vs_builder", Sense::at_most,
           0.6);
    on_gpu("as fast as a copy of the bytes, on a GPU", large, "bandwidth_pct", Sense::at_least, 60, "%");
    add("the slowest by Vulkan over the CPU builder's", {full_hd.front(), full_hd_8.front(), large.back()},
        "vulkan_cpu_vs_builder_most", Sense::at_most, 7.5, "");
    add("a tenth of the tiles changed over full", full_hd, "dirty10_cpu_vs_full", Sense::at_most, 0.8, "");
    add("unchanged frame over a copy", full_hd, "unchanged_cpu_vs_copy", Sense::at_most, 1.4, "");
    add("CPU builder, codes, 3x3, over OpenCV's median", large, "cpu_builder3_1t_cpu_vs_opencv",
        Sense::at_most, 2.4, "");
    add("  with positions, over OpenCV's", large, "cpu_positions3_2t_cpu_vs_opencv", Sense::at_most, 2.1, "");
    add("  with cut tiles, over OpenCV's", large, "cpu_mask3_cpu_vs_opencv_mask", Sense::at_most, 0.8, "");
    add("  terraces, 8 bits, over OpenCV's 5x5", full_hd_8, "cpu_builder_terraces_cpu_vs_opencv",
        Sense::at_most, 1.57, "");
    add("lazy builder, 5 fingers, 5x5, added, in roots", full_hd, "lazy_roots_per_tick_5f_m5", Sense::at_most,
        900, "");
    add("device to first surface, warm over cold cache", {"1920x1080-16-start"}, "first_surface_vs_cold",
        Sense::at_most, 0.9, "");
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
