#include "engine/scene/scene_description.hpp"

#include "engine/base/try.hpp"

namespace touchable {

Result<void> validate(const SceneDescription& described) {
    if (!described.unstated.far) return validate(described.scene);
    // Whether there is room for terrace removal is known with the far plane.
    Scene scene = described.scene;
    if (scene.filter.terraces == TerraceRemoval::on) scene.filter.terraces = TerraceRemoval::automatic;
    return validate(scene);
}

Result<Scene> settle(const SceneDescription& described, const FoundInClip& found) {
    SceneDescription settled = described;
    Scene& scene = settled.scene;
    const Unstated& open = described.unstated;
    if (open.camera && !found.camera)
        return input_error(
            "camera is missing: must be given in the scene file, as its folder.cameras are of the pictures "
            "of its folder alone");
    if (open.camera) scene.camera = *found.camera;
    if (open.rate && found.rate) scene.rate = *found.rate;
    if (open.far && found.far) {
        scene.depth.far = *found.far;
        derive_valid_range(scene.depth);
        settled.unstated.far = false;
    }
    TRY(validate(settled));
    return scene;
}

}  // namespace touchable
