#include "engine/formats/lerobot_coding.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "engine/scene/stored_code.hpp"

namespace touchable {
namespace {

constexpr std::uint16_t largest_lerobot_code = 4095;

/// From metres to scene units, or back.
DepthCoding in_units(DepthCoding coding, double times) {
    for (double* const length : {&coding.near, &coding.far, &coding.shift, &coding.scale}) *length *= times;
    derive_valid_range(coding);
    return coding;
}

bool has_lerobot_codes(const Scene& scene) {
    const DepthCoding& depth = scene.depth;
    const bool is_of_it = depth.kind == DepthCodingKind::log || depth.kind == DepthCodingKind::linear;
    const bool is_from_0 = depth.kind == DepthCodingKind::metric && depth.near == 0 &&
                           depth.far == depth.depth(largest_lerobot_code);
    return (is_from_0 || (is_of_it && !depth.near_is_high)) && scene.depth_bits == 12 &&
           depth.code_max == largest_lerobot_code && depth.semantics == DepthSemantics::planar &&
           depth.invalid_code_count == 1 && depth.invalid_codes[0] == 0;
}

}  // namespace

DepthCoding lerobot_coding(double near, double far, double shift) {
    DepthCoding coding;
    coding.kind = DepthCodingKind::log;
    coding.semantics = DepthSemantics::planar;
    coding.near_is_high = false;
    coding.near = near;
    coding.far = far;
    coding.shift = shift;
    coding.code_max = largest_lerobot_code;
    coding.invalid_code_count = 1;  // 0
    derive_valid_range(coding);
    return coding;
}

DepthCoding lerobot_linear_coding(double near, double far) {
    DepthCoding coding = lerobot_coding(near, far, 0);
    coding.kind = near > 0 ? DepthCodingKind::linear : DepthCodingKind::metric;
    coding.scale = near > 0 ? 0 : far / coding.code_max;
    derive_valid_range(coding);
    return coding;
}

LeRobotCodes::LeRobotCodes(const Scene& scene) : from_(scene), scene_(scene) {
    scene_.height_coding = {};
    are_kept_ = has_lerobot_codes(scene);
    if (are_kept_) return;
    const DepthCoding& stored = scene.depth;
    const DepthCoding usual = lerobot_coding();
    const double metres = scene.metres_per_unit;
    scene_.depth = in_units(lerobot_coding(std::min(usual.near, stored.nearest_depth() * metres),
                                           std::max(usual.far, stored.deepest_depth() * metres)),
                            1 / metres);
    scene_.depth_bits = 12;
    table_.assign(65536, 0);
    for (int code = stored.valid_min; code <= stored.valid_max; ++code)
        if (const auto each = static_cast<std::uint16_t>(code); stored.is_valid(each))
            table_[each] = scene_.depth.code(stored.depth(each));
}

double LeRobotCodes::step_at_a_metre() const {
    const double metres = scene_.metres_per_unit;
    const int code = std::min<int>(scene_.depth.code(1 / metres), largest_lerobot_code - 1);
    const auto depth = [&](int of) { return metres * scene_.depth.depth(static_cast<std::uint16_t>(of)); };
    return depth(code + 1) - depth(code);
}

RawFrame LeRobotCodes::of(const RawFrame& frame) const {
    RawFrame made;
    made.number = frame.number;
    made.time_ns = frame.time_ns;
    made.epoch = frame.epoch;
    made.depth = frame.depth;
    made.storage = frame.storage;
    if (are_kept_) return made;
    const PlaneView& from = frame.depth;
    const DepthCoding& stored = from_.depth;
    const Camera& camera = from_.camera;
    const auto codes = std::make_shared<std::vector<std::uint16_t>>();
    codes->reserve(static_cast<std::size_t>(from.width) * static_cast<std::size_t>(from.height));
    for (int y = 0; y < from.height; ++y)
        for (int x = 0; x < from.width; ++x) {
            const std::uint16_t code = stored_code(from, stored, x, y);
            if (stored.semantics == DepthSemantics::planar || !stored.is_valid(code)) {
                codes->push_back(table_[code]);
                continue;
            }
            const double right = (x - camera.cx) / camera.fx, down = (y - camera.cy) / camera.fy;
            codes->push_back(
                scene_.depth.code(stored.depth(code) / std::sqrt(1 + right * right + down * down)));
        }
    made.depth = {reinterpret_cast<const std::uint8_t*>(codes->data()),
                  2 * std::ptrdiff_t{from.width},
                  from.width,
                  from.height,
                  2,
                  1};
    made.storage = codes;
    return made;
}

}  // namespace touchable
