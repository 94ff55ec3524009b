// SPDX-License-Identifier: Apache-2.0
#include "bench/real/generated.hpp"

#include <algorithm>

#include "bench/real/built_frames.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {
namespace {

/// Whether a pixel's depth equals the stored one to the bit, or both are invalid.
bool is_as_stored(const RawFrame& raw, const DepthCoding& stored, const SurfaceFrame& frame, int x, int y) {
    const std::uint16_t code = stored_code(raw.depth, stored, x, y);
    const DepthSample now = sample_of(frame, x, y);
    return stored.is_valid(code) ? now.valid && now.depth == stored.depth(code) : !now.valid;
}

}  // namespace

Result<void> measure_generated(const FilterChoice& choice, Figures& figures) {
    std::int64_t changed = 0, pixels = 0;
    for (const char* name : {"globe", "bumps", "rough", "moving", "spheres", "step"}) {
        const auto made = make_scene(name, {.width = 320, .height = 240});
        if (!made) return made.error();
        std::vector<RawFrame> raws;
        for (int n = 0; n < DepthEstimator::frames; ++n) raws.push_back((*made)->frame(n));
        const Scene scene = choice.of(raws, (*made)->scene());
        const auto frames = built(scene, raws);
        if (!frames) return frames.error();
        for (std::size_t n = 0; n < raws.size(); ++n)
            for (int y = 0; y < scene.height; ++y)
                for (int x = 0; x < scene.width; ++x) {
                    ++pixels;
                    changed += !is_as_stored(raws[n], scene.depth, (*frames)[n], x, y);
                }
    }
    figures.push_back({"changed_pct", 100 * static_cast<double>(changed) / static_cast<double>(pixels), "%"});
    return {};
}

}  // namespace touchable
