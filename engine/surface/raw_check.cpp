#include "engine/surface/raw_check.hpp"

#include <cstdlib>

namespace touchable {
namespace {

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

/// `bytes`: the sample sizes that can be, least and greatest.
Result<void> check_plane(const PlaneView& plane, const std::string& where, const Scene& scene, int channels,
                         int least_bytes, int greatest_bytes) {
    if (plane.width != scene.width || plane.height != scene.height)
        return input_error(where + " is " + size_text(plane.width, plane.height) + ", the scene says " +
                           size_text(scene.width, scene.height));
    if (plane.channels != channels)
        return input_error(where + " has " + std::to_string(plane.channels) + " channels, " +
                           std::to_string(channels) + " would be right");
    if (plane.bytes_per_sample < least_bytes || plane.bytes_per_sample > greatest_bytes)
        return input_error(where + " has samples of " + std::to_string(8 * plane.bytes_per_sample) +
                           " bits, " + std::to_string(8 * least_bytes) + " would be right");
    const std::ptrdiff_t row_bytes = std::ptrdiff_t{plane.width} * channels * plane.bytes_per_sample;
    if (plane.height > 1 && std::abs(plane.stride) < row_bytes)
        return input_error(where + " has rows of " + std::to_string(row_bytes) + " bytes, but only " +
                           std::to_string(plane.stride) + " from one to the next");
    return {};
}

}  // namespace

Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene) {
    const std::string frame = "frame " + std::to_string(raw.number) + ": ";
    if (raw.depth.empty()) return input_error(frame + "there is no depth plane");
    const int depth_bytes = scene.depth_bits > 8 ? 2 : 1;
    if (auto ok = check_plane(raw.depth, frame + "the depth plane", scene, 1, depth_bytes, 2); !ok) return ok;
    if (!raw.colour.empty())
        if (auto ok = check_plane(raw.colour, frame + "the colour plane", scene, 3, 1, 1); !ok) return ok;
    if (!raw.haptic.empty())
        if (auto ok = check_plane(raw.haptic, frame + "the haptic plane", scene, 3, 1, 1); !ok) return ok;
    if (!raw.height.empty())
        if (auto ok = check_plane(raw.height, frame + "the height plane", scene, 1, 1, 2); !ok) return ok;
    return {};
}

}  // namespace touchable
