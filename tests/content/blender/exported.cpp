#include "tests/content/blender/exported.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/formats/open_clip.hpp"

namespace touchable::test {

std::optional<double> Exported::depth(int x, int y, std::size_t frame) const {
    const std::uint16_t code = frames[frame].depth.sample(x, y);
    if (!scene().depth.is_valid(code)) return std::nullopt;
    return scene().depth.depth(code) * scene().metres_per_unit;
}

HapticProperties Exported::haptic(int x, int y, std::size_t frame) const {
    const PlaneView& plane = frames[frame].haptic;
    const auto code = [&](int channel) { return static_cast<std::uint8_t>(plane.sample(x, y, channel)); };
    return scene().haptic.at(code(0), code(1), code(2));
}

double Exported::height(int x, int y) const {
    const HeightCoding& coding = scene().height_coding;
    return coding.max_height * frames[0].height.sample(x, y) / coding.code_max * scene().metres_per_unit;
}

double Exported::codes_off(int x, int y, double true_depth) const {
    const DepthCoding& coding = scene().depth;
    return std::abs(frames[0].depth.sample(x, y) - coding.code(true_depth / scene().metres_per_unit));
}

Exported open_exported(const std::string& file) {
    Exported exported;
    auto reader = open_clip(file);
    if (!reader) {
        ADD_FAILURE() << reader.error().message;
        return exported;
    }
    exported.reader = std::move(*reader);
    for (;;) {
        auto frame = exported.reader->next();
        if (!frame) ADD_FAILURE() << frame.error().message;
        if (!frame || !*frame) return exported;
        exported.frames.push_back(std::move(**frame));
    }
}

}  // namespace touchable::test
