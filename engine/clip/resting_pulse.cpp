#include "engine/clip/resting_pulse.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace touchable {
namespace {

constexpr double picture_width = 0.16;  // metres of the device (docs/conventions.md, Units)

/// DepthCoding::depth of a code between codes.
double depth_at(const DepthCoding& coding, double code) {
    const double share =
        std::clamp((coding.near_is_high ? code : coding.code_max - code) / coding.code_max, 0.0, 1.0);
    return coding.kind == DepthCodingKind::inverse
               ? 1 / (1 / coding.far + (1 / coding.near - 1 / coding.far) * share)
               : coding.far + (coding.near - coding.far) * share;
}

double hand_metres_per_unit(const Scene& scene, const Line& line, const CellPicture& first) {
    if (scene.device_metres_per_unit) return *scene.device_metres_per_unit;
    std::vector<double> depths;
    for (const Cell& cell : first.cells)
        if (cell.depth != Cell::none)
            depths.push_back(depth_at(scene.depth, line.at(cell.depth) / Cell::per_code));
    if (depths.empty()) return 0;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return picture_width * scene.camera.fx / (scene.width * *middle);
}

}  // namespace

RestingPulse resting_pulse(const std::vector<RestingCells>& resting, const std::vector<Line>& lines,
                           const Scene& scene, const CellPicture& first) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t n = 1; n < std::min(lines.size(), resting.size()); ++n)
        for (const auto& [then, now] : resting[n]) {
            const double moved = depth_at(scene.depth, lines[n].at(now) / Cell::per_code) -
                                 depth_at(scene.depth, lines[n - 1].at(then) / Cell::per_code);
            sum += moved * moved;
            ++count;
        }
    if (count == 0 || lines.empty()) return {};
    const double metres =
        hand_metres_per_unit(scene, lines.front(), first) * std::sqrt(sum / static_cast<double>(count));
    return {metres, metres * scene.default_properties.stiffness};
}

}  // namespace touchable
