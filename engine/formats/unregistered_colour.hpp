#pragma once

#include <filesystem>
#include <optional>

#include "engine/scene/colour_camera.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

// Files beside pictures that say that colour does not lie on depth's pixels.

/// A matrix that takes points from depth's camera to colour's or back (depth_M_color.txt,
/// extrinsic_color.txt), and is more than the unit matrix; nothing where there is none.
std::optional<std::filesystem::path> colour_movement_in(const std::filesystem::path& folder);

/// Colour's camera as ViSP stores it: depth_M_color.txt (`movement`; to depth's camera, metres), and beside
/// depth's NAME_depth.xml colour's NAME.xml, of pictures of this size. Nothing where it is not so.
struct VispColourCamera {
    ColourCamera camera;
    std::filesystem::path file;
};
std::optional<VispColourCamera> visp_colour_camera(const std::filesystem::path& movement,
                                                   const std::filesystem::path& camera_of_depth, int width,
                                                   int height);

/// A camera of colour that sees depth's pixels elsewhere than the scene's camera does; nothing where there is
/// none. A file that does not say of how large pictures it is, is of `width` x `height` pixels.
std::optional<std::filesystem::path> camera_of_colour_in(const std::filesystem::path& folder,
                                                         const Scene& scene, int width, int height);

}  // namespace touchable
