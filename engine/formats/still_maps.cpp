#include "engine/formats/still_maps.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/codecs.hpp"
#include "engine/formats/gltf_material.hpp"
#include "engine/formats/haptic_layers.hpp"
#include "engine/formats/x3d_surface.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {
namespace {

std::string ending_of(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending;
}

/// After a byte order mark and blanks.
char first_letter(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    const std::size_t at = text.find_first_not_of(" \t\r\n");
    return at == std::string_view::npos ? '\0' : text[at];
}

Result<StillPlane> refuse_file(const std::filesystem::path& file) {
    return input_error(file.string() +
                       ": is no haptic map: must be a picture (RGB: stiffness, static and dynamic friction; "
                       "grey: stiffness), X3D (.x3d) or glTF (.gltf, .glb)");
}

TrackInfo track_of(PlaneRole role, const StoredImage& stored) {
    return {std::string(role_name(role)), stored.codec, stored.pixel_format, stored.image.width,
            stored.image.height};
}

/// What a picture has to be to be touched.
Result<StoredImage> touch_picture(std::string_view bytes, PlaneRole role, const std::string& where) {
    auto stored = decode_stored_image(std::string(bytes), where);
    if (!stored) return stored;
    if (!stored->values.empty()) return input_error(where + ": is a picture of floats: must be of integers");
    if (role == PlaneRole::haptic && stored->codec == "mjpeg")
        return input_error(where + ": is JPEG, which mixes materials; haptic is PNG");
    if (stored->interlaced)
        return input_error(where + ": is an interlaced PNG: must be a plain one to be touched");
    return stored;
}

/// Fewer bits than 8 as 8.
void widen(StoredImage& stored) {
    if (stored.bits >= 8) return;
    const int white = 255 / ((1 << stored.bits) - 1);
    for (auto& sample : stored.image.samples) sample = static_cast<std::uint8_t>(white * sample);
    stored.bits = 8;
}

Result<StillPlane> haptic_picture(const std::filesystem::path& file, std::string_view bytes, Scene& scene) {
    TRY_ASSIGN(auto stored, touch_picture(bytes, PlaneRole::haptic, file.string()));
    StillPlane still{PlaneRole::haptic, {}, track_of(PlaneRole::haptic, stored), {file}, {}};
    if (stored.image.channels == 1) {
        widen(stored);
        still.notes.push_back(take_grey_haptic(scene));
    }
    still.plane = plane_from(std::move(stored.image), stored.bits);
    return still;
}

/// A length for white where the scene has none: a level, but no more than half of the nearest depth. Metric
/// codes begin at next to nothing; those that no height could be taken off become no depth.
void give_height(Scene& scene) {
    HeightCoding& height = scene.height_coding;
    DepthCoding& depth = scene.depth;
    const bool in_levels = depth.kind == DepthCodingKind::linear;
    double length = depth.level();
    if (depth.kind == DepthCodingKind::metric && depth.near < 2 * length) {
        depth.near = 2 * length;
        derive_valid_range(depth);
        add_remark(scene.remarks, {"depths below " + short_number(depth.near * scene.metres_per_unit * 1000) +
                                   " mm are taken for none, so that heights have room before the camera"});
    }
    length = std::min(length, depth.nearest_depth() / 2);
    height.units = in_levels ? HeightUnits::levels : HeightUnits::world;
    height.max_height = in_levels ? length / depth.level() : length;
}

}  // namespace

bool is_surface_file(const std::filesystem::path& file) {
    constexpr std::array<std::string_view, 4> endings{".x3d", ".x3dv", ".gltf", ".glb"};
    return std::find(endings.begin(), endings.end(), ending_of(file)) != endings.end();
}

Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene) {
    TRY_ASSIGN(const auto bytes, read_picture_bytes(file));
    if (!picture_kind(bytes).empty()) return haptic_picture(file, bytes, scene);
    const std::string ending = ending_of(file);
    const bool is_gltf = bytes.starts_with("glTF") || ending == ".gltf" || first_letter(bytes) == '{';
    const bool is_x3d = first_letter(bytes) == '<' || first_letter(bytes) == '#' || ending == ".x3d";
    if (!is_gltf && !is_x3d) return refuse_file(file);
    TRY_ASSIGN(auto layers,
               is_gltf ? read_gltf_material(file, bytes, scene) : read_x3d_surface(file, bytes, scene));
    return join_layers(std::move(layers), is_gltf ? "gltf" : "x3d", scene);
}

Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene) {
    TRY_ASSIGN(const auto bytes, read_picture_bytes(file));
    TRY_ASSIGN(auto stored, touch_picture(bytes, PlaneRole::height, file.string()));
    if (stored.image.channels == 3)
        if (auto grey = as_grey(stored.image)) stored.image = std::move(*grey);
    widen(stored);
    StillPlane still{PlaneRole::height, {}, track_of(PlaneRole::height, stored), {file}, {}};
    if (auto note = lossy_note(PlaneRole::height, stored.codec)) still.notes.push_back(std::move(*note));
    const bool is_stated = scene.height_coding.max_height > 0;
    if (!is_stated) {
        scene.height_coding.code_max = static_cast<std::uint16_t>((1 << stored.bits) - 1);
        give_height(scene);
    }
    const std::string white =
        "white in " + file.filename().string() + " is " +
        short_number(largest_height(scene.height_coding, scene.depth) * scene.metres_per_unit * 1000) +
        " mm high";
    if (is_stated)
        still.notes.push_back(white + ", as height_map says");
    else
        add_remark(scene.remarks, {white, true, "height_map.max in a scene file says otherwise"});
    still.plane = plane_from(std::move(stored.image), stored.bits);
    return still;
}

Result<std::unique_ptr<ClipReader>> with_still_maps(Result<std::unique_ptr<ClipReader>> clip,
                                                    const StillMaps& maps) {
    if (!clip) return clip;
    Scene scene = (*clip)->scene();
    std::vector<StillPlane> planes;
    if (maps.haptic) {
        TRY_ASSIGN(auto read, read_haptic_map(*maps.haptic, scene));
        planes.push_back(std::move(read));
    }
    if (maps.height) {
        TRY_ASSIGN(auto read, read_height_map(*maps.height, scene));
        planes.push_back(std::move(read));
    }
    return with_still_planes(std::move(*clip), std::move(planes), scene);
}

}  // namespace touchable
