#include "player/commands/plane_loss.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "engine/clip/resized_frame.hpp"
#include "engine/scene/stored_code.hpp"

namespace touchable {

namespace {

void add_values(const PlaneView& before, const PlaneView& now, PlaneLoss& loss) {
    loss.samples += std::int64_t{before.width} * before.height * before.channels;
    if (same_samples(before, now)) return;
    // The pixel of a smaller picture that stands for one of a larger.
    const std::vector<int> columns = nearest_samples(now.width, before.width),
                           rows = nearest_samples(now.height, before.height);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x)
            for (int channel = 0; channel < before.channels; ++channel) {
                const int was = before.sample(x, y, channel),
                          is = now.sample(columns[static_cast<std::size_t>(x)],
                                          rows[static_cast<std::size_t>(y)], channel);
                const int error = std::abs(is - was);
                loss.changed += error != 0;
                loss.largest = std::max(loss.largest, error);
                loss.squares += static_cast<double>(error) * error;
            }
}

/// Of a length along a pixel's ray, what of it is along the optical axis.
double axis_share(const Camera& camera, int x, int y) {
    const double right = (x - camera.cx) / camera.fx, down = (y - camera.cy) / camera.fy;
    return 1 / std::sqrt(1 + right * right + down * down);
}

void add_depths(const PlaneView& before, const Scene& scene, const PlaneView& now, const Scene& recoded,
                PlaneLoss& loss) {
    const bool turns_to_axis = scene.depth.semantics != recoded.depth.semantics;
    const std::vector<int> columns = nearest_samples(now.width, before.width),
                           rows = nearest_samples(now.height, before.height);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            const auto was = stored_code(before, scene.depth, x, y),
                       is = stored_code(now, recoded.depth, columns[static_cast<std::size_t>(x)],
                                        rows[static_cast<std::size_t>(y)]);
            const bool was_there = scene.depth.is_valid(was), is_there = recoded.depth.is_valid(is);
            loss.appeared += is_there && !was_there;
            loss.disappeared += was_there && !is_there;
            if (!was_there || !is_there) continue;
            const double share = turns_to_axis ? axis_share(scene.camera, x, y) : 1;
            const double metres =
                std::abs(recoded.depth.depth(is) - scene.depth.depth(was) * share) * scene.metres_per_unit;
            loss.changed += loss.is_recoded && metres > 0;
            ++loss.pixels;
            loss.largest_metres = std::max(loss.largest_metres, metres);
            loss.squares_metres += metres * metres;
        }
}

}  // namespace

void add_loss(const RawFrame& before, const RawFrame& now, const Scene& scene, PlaneLosses& losses) {
    for (const PlaneRole role : all_roles) {
        const PlaneView &was = plane_of(before, role), &is = plane_of(now, role);
        if (was.empty() || is.empty()) continue;
        PlaneLoss& loss = losses[static_cast<std::size_t>(role)];
        add_values(was, is, loss);
        if (role == PlaneRole::depth && !same_samples(was, is)) add_depths(was, scene, is, scene, loss);
    }
}

void add_recoded_loss(const RawFrame& before, const Scene& scene, const RawFrame& now, const Scene& recoded,
                      PlaneLosses& losses) {
    PlaneLoss& loss = losses[static_cast<std::size_t>(PlaneRole::depth)];
    loss.is_recoded = true;
    loss.samples += std::int64_t{before.depth.width} * before.depth.height;
    add_depths(before.depth, scene, now.depth, recoded, loss);
}

}  // namespace touchable
