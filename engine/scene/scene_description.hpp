#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Filters that nobody stated. Whoever opens a clip to play it chooses them by what its first frames tell
/// (choose_filters); in the scene they are off.
struct UnstatedFilters {
    bool median = false, fill_holes = false, terraces = false, temporal = false, flying_pixels = false;
    /// Of terrace removal, whether that is stated or not.
    bool terrace_reach = false;
    bool any() const { return median || fill_holes || terraces || temporal || flying_pixels; }
    bool operator==(const UnstatedFilters&) const = default;
};
inline constexpr UnstatedFilters all_unstated{true, true, true, true, true, true};

/// What a description leaves open.
struct Unstated {
    bool rate = false;    ///< the frames' own times stand
    bool camera = false;  ///< the median of the cameras in `folder.cameras` stands
    bool far = false;     ///< of metric coding: what the frames reach stands (far_plane.hpp)
    UnstatedFilters filters{};
    bool operator==(const Unstated&) const = default;
};

/// What a renderer's material of this index, 0 to 65535, feels like.
struct Material {
    int index = 0;
    HapticProperties properties;
};
inline constexpr int largest_material_index = 65535;
inline constexpr std::size_t most_materials = 256;

/// What a scene file, a format or a person says of a clip. `settle` makes its scene of that, once the clip
/// itself is there.
struct SceneDescription {
    SceneDescription() = default;
    /// Of a scene, which leaves nothing open.
    SceneDescription(Scene settled) : scene(std::move(settled)) {}

    Scene scene;  ///< what is stated. Of what is not: a camera that could be, the deepest code as far plane
    Unstated unstated;
    /// Where there are any, haptic pictures are of material indices; whoever reads them makes properties of
    /// them, by Scene::haptic, which holds them all. By index, each once, at most 256.
    std::vector<Material> materials{};
};

/// As `validate` of a scene, of what is known already.
Result<void> validate(const SceneDescription& described);

/// What a clip tells of what its description leaves open.
struct FoundInClip {
    std::optional<FrameRate> rate{};  ///< without it 30 frames a second
    std::optional<Camera> camera{};
    std::optional<double> far{};  ///< without it the depth of the deepest code
};
/// The one place where a description becomes a scene. What is stated stands, and what was found fills in the
/// rest. Refused without a place: a camera that was neither stated nor found, and what `validate` refuses.
Result<Scene> settle(const SceneDescription& described, const FoundInClip& found);

}  // namespace touchable
