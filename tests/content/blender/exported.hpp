#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/clip/clip.hpp"

namespace touchable::test {

/// A clip that Blender's exporter made, all of its frames in hand.
struct Exported {
    std::unique_ptr<ClipReader> reader;
    std::vector<RawFrame> frames;

    const Scene& scene() const { return reader->scene(); }
    /// Planar depth in metres; nothing: no surface.
    std::optional<double> depth(int x, int y, std::size_t frame = 0) const;
    HapticProperties haptic(int x, int y, std::size_t frame = 0) const;
    double height(int x, int y) const;  ///< metres
    /// How far a stored depth is from the code that the true depth has.
    double codes_off(int x, int y, double true_depth) const;
};

/// Fails the test, and gives no frames, where it does not open.
Exported open_exported(const std::string& file);

}  // namespace touchable::test
