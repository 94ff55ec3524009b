#include "engine/surface/raw_check.hpp"

#include <cstdlib>

namespace touchable {
namespace {

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

/// What a plane has to be; `bytes` are those of a sample.
struct PlaneForm {
    const char* name;
    int channels, least_bytes, greatest_bytes;
};

/// What is wrong with a plane, empty where nothing is.
std::string complaint(const PlaneView& plane, const PlaneForm& form, const Scene& scene) {
    if (plane.width != scene.width || plane.height != scene.height)
        return "is " + size_text(plane.width, plane.height) + ", the scene says " +
               size_text(scene.width, scene.height);
    if (plane.channels != form.channels)
        return "has " + std::to_string(plane.channels) + " channels, " + std::to_string(form.channels) +
               " would be right";
    if (plane.bytes_per_sample < form.least_bytes || plane.bytes_per_sample > form.greatest_bytes)
        return "has samples of " + std::to_string(8 * plane.bytes_per_sample) + " bits, " +
               std::to_string(8 * form.least_bytes) + " would be right";
    const std::ptrdiff_t row_bytes = std::ptrdiff_t{plane.width} * plane.channels * plane.bytes_per_sample;
    if (plane.height > 1 && std::abs(plane.stride) < row_bytes)
        return "has rows of " + std::to_string(row_bytes) + " bytes, but only " +
               std::to_string(plane.stride) + " from one to the next";
    return {};
}

}  // namespace

Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene) {
    const auto frame = [&] { return "frame " + std::to_string(raw.number) + ": "; };
    if (raw.depth.empty()) return input_error(frame() + "there is no depth plane");
    const PlaneForm depth = scene.depth.kind == DepthCodingKind::hue
                                ? PlaneForm{"depth", 3, 1, 1}
                                : PlaneForm{"depth", 1, scene.depth_bits > 8 ? 2 : 1, 2};
    const std::pair<const PlaneView&, PlaneForm> planes[] = {
        {raw.depth, depth},
        {raw.colour, {"colour", 3, 1, 1}},
        {raw.haptic, {"haptic", 3, 1, 1}},
        {raw.height, {"height", 1, 1, 2}},
    };
    for (const auto& [plane, form] : planes) {
        if (plane.empty()) continue;
        if (const std::string wrong = complaint(plane, form, scene); !wrong.empty())
            return input_error(frame() + "the " + form.name + " plane " + wrong);
    }
    return {};
}

}  // namespace touchable
