#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/gltf_file.hpp"
#include "engine/formats/haptic_layers.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// One property in a haptic material of glTF.
struct GltfLayer {
    std::size_t texture = 0;               ///< of the array "textures"
    int channel = 0;                       ///< 0, red, where it does not say another; 2 at most
    std::optional<PropertyRange> range{};  ///< at black and white, where it says that
};

/// What a material of MPEG_haptic_material has. The extension knows one friction; beside a texture "extras"
/// may say more: "touchable_range" [black, white], "touchable_channel" 0 to 2, "touchable_kind" "static",
/// "dynamic", and of a custom texture "height".
struct GltfTouch {
    std::array<std::optional<GltfLayer>, 3> properties;  ///< as property_names
    std::optional<GltfLayer> height;
    bool has_one_friction = false;     ///< for static and dynamic alike
    std::vector<std::string> notes{};  ///< what of it is not used
};

/// Whether a file has a material with stiffness, friction or heights.
bool has_touch(const GltfFile& gltf);
/// Of the material that the file's first mesh with one names, or of the first with any of these.
/// Throws checked_json::Refusal where there is none.
GltfTouch touch_of(const GltfFile& gltf);

/// The same as pictures. The extension has no units: black and white are the ends of the scene's haptic
/// ranges where the file states no range (N/mm for stiffness). A property without a texture is as in the
/// scene's default_properties. `bytes`: of a file, .gltf or .glb.
Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene);

/// What `read` makes of a file, with its name before what is wrong.
template <class Read>
auto read_gltf(const std::filesystem::path& file, const Read& read) -> decltype(read()) {
    try {
        return read();
    } catch (const checked_json::Refusal& reason) {
        return input_error(file.string() + ": " + reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return input_error(file.string() + ": " + fault.what());
    } catch (const Error& error) {
        return error;
    }
}

}  // namespace touchable
