#include "player/commands/plane_loss.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "engine/clip/resized_frame.hpp"
#include "engine/frame/stored_code.hpp"

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

void add_depths(const PlaneView& before, const PlaneView& now, const Scene& scene, PlaneLoss& loss) {
    if (same_samples(before, now)) return;
    const std::vector<int> columns = nearest_samples(now.width, before.width),
                           rows = nearest_samples(now.height, before.height);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            const auto was = stored_code(before, scene.depth, x, y),
                       is = stored_code(now, scene.depth, columns[static_cast<std::size_t>(x)],
                                        rows[static_cast<std::size_t>(y)]);
            const bool was_there = scene.depth.is_valid(was), is_there = scene.depth.is_valid(is);
            loss.appeared += is_there && !was_there;
            loss.disappeared += was_there && !is_there;
            if (!was_there || !is_there) continue;
            const double metres =
                std::abs(scene.depth.depth(is) - scene.depth.depth(was)) * scene.metres_per_unit;
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
        if (role == PlaneRole::depth) add_depths(was, is, scene, loss);
    }
}

}  // namespace touchable
