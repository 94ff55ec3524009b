#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

enum class PlaneRole { depth, colour, haptic, height };

inline constexpr std::array all_roles{PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic,
                                      PlaneRole::height};

std::string_view role_name(PlaneRole role);
std::optional<PlaneRole> role_named(std::string_view name);

PlaneView& plane_of(RawFrame& frame, PlaneRole role);
const PlaneView& plane_of(const RawFrame& frame, PlaneRole role);

/// How its pictures are stored as PNG: those of haptic have few materials, each a colour.
PngColours png_colours(PlaneRole role);

/// Where a folder has the pictures of a role.
std::string& pattern_of(FolderSource& source, PlaneRole role);
const std::string& pattern_of(const FolderSource& source, PlaneRole role);

/// Of colour, haptic and height: numbers of their own.
const PictureNumbers& numbers_of(const FolderSource& source, PlaneRole role);

/// Samples and what keeps them alive.
struct Plane {
    PlaneView view;
    std::shared_ptr<const void> storage;
    int bits = 0;  ///< of a grey sample as stored, which may be fewer than its bytes have; 0: all of them
};
/// `bits`: of a grey sample as stored.
Plane plane_from(Image image, int bits = 0);

/// Refuses samples of a kind the role does not have, and values beyond what the scene says: depth beyond
/// depth_bits, height beyond its code_max. Says nothing about the size. Messages begin with `where`.
Result<void> check_plane(PlaneRole role, const PlaneView& plane, const Scene& scene, std::string_view where);

/// A checked plane of the scene's size: grey colour becomes RGB, grey haptic stiffness (take_grey_haptic),
/// and planes other than depth are resampled to the nearest sample (but colour of a colour_camera, which has
/// to be of that camera's size); a depth plane of another size is refused, and one whose samples have too few
/// bits for the codes that the scene speaks of.
Result<Plane> fit_plane(PlaneRole role, Plane plane, const Scene& scene, std::string_view where);

/// What a person should know about a plane that `fit_plane` resamples.
std::string resampling_note(PlaneRole role, int width, int height, const Scene& scene);

/// Grey haptic pictures are stiffness alone. Makes `scene` say that whatever their green and blue are,
/// friction is that of its default_properties, and gives what a person should know.
std::string take_grey_haptic(Scene& scene);

/// What a person should know about touch planes a clip does not have; nothing where it has a haptic plane.
std::optional<std::string> default_touch_note(bool has_haptic, const Scene& scene);

/// What a person should know about a frame in which no pixel of depth is valid; nothing where one is.
std::optional<std::string> no_depth_note(const RawFrame& frame, const DepthCoding& coding);

/// Puts a plane into its place; the frame's storage keeps it alive beside those added before.
void add_plane(RawFrame& frame, PlaneRole role, Plane plane);

}  // namespace touchable
