#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace touchable {

/// Focal lengths and principal point, pixels.
struct Intrinsics {
    double fx = 0, fy = 0;
    std::optional<double> cx{}, cy{};  ///< otherwise the middle of the picture
    int width = 0, height = 0;         ///< of the pictures that they are of; 0: of any
    bool operator==(const Intrinsics&) const = default;
};

/// What a person says of pictures without a scene file. What is left out is guessed, and said.
struct SourceDescription {
    std::optional<Intrinsics> intrinsics;
    std::optional<double> fov;              ///< from the left edge to the right one, degrees
    std::optional<double> metres_per_code;  ///< of metric depth: of a stored 1
    std::filesystem::path file;             ///< that `intrinsics` were read from, if any
    std::string preset;                     ///< a name of presets.hpp; empty: none
    /// Of arrays with a confidence beside depth (ImageStack::trust).
    std::optional<double> least_confidence{};
    bool operator==(const SourceDescription&) const = default;
};

}  // namespace touchable
