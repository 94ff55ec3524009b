#include "engine/authoring/haptic_values.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/scene/stored_code.hpp"

namespace touchable {
namespace {

/// Largest difference of a channel.
int difference(const PlaneView& picture, int y, int x0, int x1) {
    int most = 0;
    for (int c = 0; c < 3; ++c)
        most = std::max(most, std::abs(picture.sample(x0, y, c) - picture.sample(x1, y, c)));
    return most;
}

/// Values that wander from pixel to pixel by a few codes. Neither areas nor smooth changes do.
bool is_mixed(const PlaneView& picture, int x, int y) {
    if (x < 2 || x + 2 >= picture.width) return false;
    const int left = difference(picture, y, x, x - 1), right = difference(picture, y, x, x + 1);
    const int beyond = difference(picture, y, x - 1, x + 1);
    return left > 0 && right > 0 && left <= 12 && right <= 12 && beyond < std::max(left, right);
}

}  // namespace

void HapticValuesEstimator::add(const RawFrame& frame, Where* where) {
    const std::size_t all = static_cast<std::size_t>(scene_.width) * static_cast<std::size_t>(scene_.height);
    if (where != nullptr)
        for (auto* marks : {&where->too_stiff, &where->more_dynamic, &where->mixed}) marks->assign(all, 0);
    std::array<HapticProperties, 256> of_code;
    for (int code = 0; code < 256; ++code) {
        const auto value = static_cast<std::uint8_t>(code);
        of_code[static_cast<std::size_t>(code)] = scene_.haptic.at(value, value, value);
    }
    std::size_t pixel = 0;
    for (int y = 0; y < scene_.height; ++y)
        for (int x = 0; x < scene_.width; ++x, ++pixel) {
            if (!scene_.depth.is_valid(stored_code(frame.depth, scene_.depth, x, y))) continue;
            const std::uint8_t* rgb = frame.haptic.row(y) + std::ptrdiff_t{3} * x;
            const double stiffness = of_code[rgb[0]].stiffness / 1000;
            const bool too_stiff = stiffness > stiffest_of_devices;
            const bool more_dynamic = of_code[rgb[2]].dynamic_friction > of_code[rgb[1]].static_friction;
            const bool mixed = is_mixed(frame.haptic, x, y);
            ++pixels_;
            stiffest_ = std::max(stiffest_, stiffness);
            too_stiff_ += too_stiff ? 1 : 0;
            more_dynamic_ += more_dynamic ? 1 : 0;
            mixed_ += mixed ? 1 : 0;
            if (where == nullptr) continue;
            where->too_stiff[pixel] = too_stiff ? 1 : 0;
            where->more_dynamic[pixel] = more_dynamic ? 1 : 0;
            where->mixed[pixel] = mixed ? 1 : 0;
        }
}

HapticValues HapticValuesEstimator::values() const {
    const auto share = [&](std::int64_t count) {
        return pixels_ == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(pixels_);
    };
    return {stiffest_, share(too_stiff_), share(more_dynamic_), share(mixed_)};
}

}  // namespace touchable
