#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "engine/content/scenes.hpp"

/// The makers behind make_scene, one per family of scenes. Sizes and bits have been checked; each refuses
/// what its own surface cannot be.
namespace touchable {

struct GlobeSphere;

using MadeScene = Result<std::unique_ptr<AnalyticScene>>;

MadeScene make_globe(std::string_view name, const SceneOptions& options);
/// A globe of `options.maps`, which are there; `scene` has the camera and coding of a globe.
MadeScene make_map_globe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options);
MadeScene make_height_field(std::string_view name, const SceneOptions& options);
MadeScene make_primitive(std::string_view name, const SceneOptions& options);
MadeScene make_noise(std::string_view name, const SceneOptions& options);

/// What every family starts from: name, size, bits, code_max; camera and planes are still to be set.
Scene blank_scene(std::string_view name, const SceneOptions& options);

/// That share work on so many pixels: as SceneOptions has them, or as many as pay.
int threads_for_pixels(int threads, std::int64_t pixels);

/// The camera of the height fields and primitives: 200 mm wide at 1000 mm, metres_per_unit 0.001, device one
/// to one; planar linear coding between `near` and `far`; 600 N/m, friction 0.6 and 0.4. Width at least 2.
Scene tabletop_scene(std::string_view name, const SceneOptions& options, double near, double far);
inline constexpr double tabletop_distance = 1000, tabletop_width = 200;

}  // namespace touchable
