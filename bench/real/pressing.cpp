// SPDX-License-Identifier: Apache-2.0
#include "bench/real/pressing.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

constexpr double lifted_mm = 2, pressed_mm = 3;
constexpr int ticks_in = 10, ticks_along = 16;
constexpr double way_right = 4, way_down = 2;  // pixels

/// Goal at `along` its path, 0 to 1, and `under` mm below its plane.
glm::dvec3 goal_at(const DepthPlane& plane, const Camera& camera, double along, double under) {
    const double x = plane.x + way_right * (along - 0.5), y = plane.y + way_down * (along - 0.5);
    return unproject(camera, x, y, plane.depth(x, y)) - under * normal_of(plane, camera);
}

FramePair held(const SurfaceFrame& frame) {
    FramePair pair;
    pair.prev = pair.next = {0, 0, &frame};
    return pair;
}

double root_mean_square(const std::vector<double>& values) {
    double squares = 0;
    for (const double value : values) squares += value * value;
    return std::sqrt(squares / static_cast<double>(values.size()));
}

double per_cent(std::size_t part, std::size_t all) {
    return 100 * static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(all, 1));
}

double over_20deg_pct(const std::vector<double>& angles) {
    const auto wrong = std::ranges::count_if(angles, [](double angle) { return angle > 20; });
    return per_cent(static_cast<std::size_t>(wrong), angles.size());
}

}  // namespace

Result<void> PressErrors::press(const Scene& scene, const SurfaceFrame& frame,
                                const std::vector<DepthPlane>& planes) {
    const auto solver = TouchSolver::create(scene, {});
    if (!solver) return solver.error();
    fingers_ += planes.size();
    std::vector<glm::dvec3> goals(planes.size());
    std::vector<FingerState> fingers(planes.size());
    std::vector<Contact> contacts(planes.size());
    const FramePair pair = held(frame);
    const HeightField field(scene, pair);
    for (int tick = 0; tick <= ticks_in + ticks_along; ++tick) {
        const double in = std::min(1.0, static_cast<double>(tick) / ticks_in);
        const double share = std::max(0.0, static_cast<double>(tick - ticks_in) / ticks_along);
        for (std::size_t k = 0; k < planes.size(); ++k)
            goals[k] = goal_at(planes[k], scene.camera, share, -lifted_mm + in * (lifted_mm + pressed_mm));
        solver->tick(field, goals, fingers, contacts);
        for (std::size_t k = 0; k < planes.size() && tick >= ticks_in; ++k) {
            const Contact& contact = contacts[k];
            if (!contact.touching) {
                ++lost_;
                continue;
            }
            const double angle = degrees_between(contact.force, normal_of(planes[k], scene.camera));
            angles_.push_back(angle);
            if (1 / planes[k].at <= trusted_to_) trusted_.push_back(angle);
            if (!(contact.error_degrees >= 0)) continue;
            bars_.push_back(contact.error_degrees);
            held_ += angle <= contact.error_degrees;
            const ErrorSigns::Block* const block = frame.signs.block_at(contact.pixel_x, contact.pixel_y);
            if (tick == ticks_in)
                places_.push_back({*frame.signs.squares(*block), angle,
                                   std::abs(glm::distance(contact.proxy, contact.goal) - pressed_mm)});
        }
    }
    return {};
}

double PressErrors::angle_deg_rms() const {
    return angles_.empty() ? 180 : root_mean_square(angles_);
}

double PressErrors::untrusted_pct() const {
    return per_cent(angles_.size() - trusted_.size(), angles_.size());
}

double PressErrors::trusted_over_20deg_pct() const {
    return over_20deg_pct(trusted_);
}

void PressErrors::report(Figures& figures) const {
    std::vector<double> sorted = angles_;
    std::sort(sorted.begin(), sorted.end());
    const auto share = [&](double of) {
        return sorted[std::min(sorted.size() - 1,
                               static_cast<std::size_t>(of * static_cast<double>(sorted.size())))];
    };
    if (sorted.empty()) sorted.push_back(180);  // no tick in contact
    figures.push_back({"presses", static_cast<double>(fingers_), ""});
    figures.push_back({"force_angle_deg_rms", root_mean_square(sorted), "deg"});
    figures.push_back({"force_angle_deg_median", share(0.5), "deg"});
    figures.push_back({"force_angle_deg_p95", share(0.95), "deg"});
    figures.push_back({"over_20deg_pct", over_20deg_pct(sorted), "%"});
    figures.push_back({"untrusted_pct", untrusted_pct(), "%"});
    figures.push_back({"trusted_over_20deg_pct", trusted_over_20deg_pct(), "%"});
    figures.push_back({"contact_lost_pct",
                       100 * static_cast<double>(lost_) / static_cast<double>(lost_ + angles_.size()), "%"});
    if (bars_.empty()) return;
    std::vector<double> bars = bars_;
    figures.push_back({"bars_hold_pct", per_cent(held_, bars.size()), "%"});
    figures.push_back({"bar_deg_median", sorted_element(bars, bars.size() / 2), "deg"});
}

}  // namespace touchable
