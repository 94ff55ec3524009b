#include "engine/formats/gltf_clip.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip_file_reader.hpp"
#include "engine/formats/gltf_material.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/image_folder.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/still_maps.hpp"
#include "engine/formats/touch_videos.hpp"
#include "engine/formats/video_clip.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using checked_json::Refusal;

constexpr std::size_t largest_file = std::size_t{64} << 20;

/// Where a plane is.
struct ClipTexture {
    std::optional<GltfVideo> video;
    std::string picture;  ///< a file in the scene's folder or below, where it is no video
};

/// The array's element of which `choose` makes something, the first.
template <class Choose>
auto first_of(const Node& root, const char* array, const Choose& choose)
    -> decltype(choose(root, std::size_t{0})) {
    if (!root.has(array)) return {};
    const std::vector<Node> elements = gltf_array(root[array]);
    for (std::size_t k = 0; k < elements.size(); ++k)
        if (auto chosen = choose(elements[k], k)) return chosen;
    return {};
}

std::optional<Node> own_extras(const Node& mesh) {
    if (!mesh.has("extras") || !mesh["extras"].has("touchable")) return std::nullopt;
    return mesh["extras"]["touchable"];
}

class GltfClip {
public:
    GltfClip(const SourceFile& source, std::string_view bytes)
        : gltf_(source.path(), bytes),
          folder_(source.path().parent_path()),
          own_(first_of(gltf_.root(), "meshes",
                        [](const Node& mesh, std::size_t) { return own_extras(mesh); })) {}
    Result<std::unique_ptr<ClipReader>> open(const std::optional<SceneDescription>& replacement,
                                             Colour colour);

private:
    std::string name_beside(const std::string& uri) const;
    std::optional<std::size_t> depth_texture() const;
    std::optional<std::size_t> colour_texture() const;
    ClipTexture plane(std::size_t texture) const;
    bool is_video(std::size_t texture) const {
        return gltf_extension(gltf_.texture(texture), "MPEG_texture_video").has_value();
    }
    void find_planes();
    void find_touch();
    TouchSource touch_source(const GltfLayer& property);
    SceneDescription described() const;
    SceneDescription assumed() const;
    bool take_ranges(Scene& scene) const;
    bool take_height(Scene& scene) const;
    void take_touch(Scene& scene);
    const ClipTexture& depth() const { return *planes_.front(); }
    std::vector<std::filesystem::path> files_of_others() const;
    Result<std::unique_ptr<ClipReader>> open_tracks(const SceneDescription& described, Colour colour) const;
    Result<std::unique_ptr<ClipReader>> open_files(SceneDescription described, Colour colour) const;

    GltfFile gltf_;
    std::filesystem::path folder_;
    const std::optional<Node> own_;  // what we wrote of it
    std::array<std::optional<ClipTexture>, all_roles.size()> planes_;
    std::optional<GltfTouch> touch_;
    StillMaps maps_;                       // pictures that serve all frames of a video
    std::optional<TouchSources> sources_;  // of touch that is no plane of ours, and moves
    std::vector<Remark> remarks_;
};

/// In the scene's folder or below.
std::string GltfClip::name_beside(const std::string& uri) const {
    auto link = follow_link(uri, gltf_.file());
    if (!link) throw link.error();
    const std::filesystem::path named =
        link->file.lexically_normal().lexically_relative(folder_.lexically_normal());
    if (link->file.empty() || named.empty() || named.is_absolute() || *named.begin() == "..")
        throw Refusal{"a plane of it is " + in_quotes(uri.substr(0, 40)) +
                      ": must be a file beside it or in a folder below"};
    return named.string();
}

/// As its mesh says; otherwise the video whose samples are depth.
std::optional<std::size_t> GltfClip::depth_texture() const {
    if (own_) return static_cast<std::size_t>((*own_)["depth"].whole());
    return first_of(
        gltf_.root(), "textures", [](const Node& texture, std::size_t k) -> std::optional<std::size_t> {
            const auto moving = gltf_extension(texture, "MPEG_texture_video");
            const bool is_depth =
                moving && moving->has("format") && (*moving)["format"].text() == "DEPTH_COMPONENT";
            return is_depth ? std::optional(k) : std::nullopt;
        });
}

/// As its mesh says; otherwise what is drawn on the first mesh that is drawn with a picture.
std::optional<std::size_t> GltfClip::colour_texture() const {
    if (own_)
        return own_->has("colour") ? std::optional(static_cast<std::size_t>((*own_)["colour"].whole()))
                                   : std::nullopt;
    const auto of_primitive = [this](const Node& primitive, std::size_t) -> std::optional<std::size_t> {
        if (!primitive.has("material")) return std::nullopt;
        const Node material = gltf_.element("materials", primitive["material"]);
        if (!material.has("pbrMetallicRoughness")) return std::nullopt;
        const Node look = material["pbrMetallicRoughness"];
        if (!look.has("baseColorTexture")) return std::nullopt;
        return static_cast<std::size_t>(look["baseColorTexture"]["index"].whole());
    };
    return first_of(gltf_.root(), "meshes", [&](const Node& mesh, std::size_t) {
        return first_of(mesh, "primitives", of_primitive);
    });
}

ClipTexture GltfClip::plane(std::size_t index) const {
    const Node texture = gltf_.texture(index);
    if (auto video = gltf_.video(texture)) {
        video->file = name_beside(video->file);
        return {std::move(video), ""};
    }
    if (!texture.has("source")) throw Refusal{"a texture is neither a picture nor a video"};
    const Node image = gltf_.element("images", texture["source"]);
    if (image.has("bufferView"))
        throw Refusal{"a plane of it is a picture within the file: must be a file beside it"};
    return {{}, name_beside(image["uri"].text())};
}

void GltfClip::find_planes() {
    const auto depth = depth_texture();
    if (!depth)
        throw Refusal{
            "has no depth (a texture of format DEPTH_COMPONENT, or \"depth\" in the extras of a mesh): it is "
            "no clip; what it says of touch serves a clip of depth"};
    const auto at = [this](PlaneRole role) -> std::optional<ClipTexture>& {
        return planes_[static_cast<std::size_t>(role)];
    };
    at(PlaneRole::depth) = plane(*depth);
    const auto colour = colour_texture();  // a picture of it stands in for the video
    if (colour && (!at(PlaneRole::depth)->video || is_video(*colour))) at(PlaneRole::colour) = plane(*colour);
    find_touch();
}

/// The video of a property, or its picture.
TouchSource GltfClip::touch_source(const GltfLayer& property) {
    if (!is_video(property.texture))
        return TouchSource{.picture = gltf_.picture(gltf_.texture(property.texture)),
                           .channel = property.channel};
    const GltfVideo video = *plane(property.texture).video;
    if (video.tracks.size() > 1)
        throw Refusal{"a texture of touch is " + std::to_string(video.tracks.size()) +
                      " tracks of its file: must be one"};
    return TouchSource{.video = folder_ / video.file,
                       .track = video.tracks.empty() ? std::nullopt : std::optional(video.tracks.front()),
                       .channel = property.channel};
}

/// In a clip of ours a material's textures are one plane. Those of others are videos, each of its own;
/// pictures alone are a map, as of any other clip.
void GltfClip::find_touch() {
    if (!has_touch(gltf_)) return;
    touch_ = touch_of(gltf_);
    std::optional<std::size_t> texture;
    bool is_one = own_.has_value(), is_moving = false;
    for (std::size_t k = 0; k < touch_->properties.size(); ++k) {
        const auto& property = touch_->properties[k];
        if (!property) continue;
        is_one =
            is_one && (!texture || *texture == property->texture) && property->channel == static_cast<int>(k);
        texture = property->texture;
        is_moving = is_moving || is_video(*texture);
    }
    if (touch_->height) planes_[static_cast<std::size_t>(PlaneRole::height)] = plane(touch_->height->texture);
    if (!texture) return;
    if (is_one) {
        planes_[static_cast<std::size_t>(PlaneRole::haptic)] = plane(*texture);
        return;
    }
    if (!is_moving) {
        maps_.haptic = gltf_.file();
        return;
    }
    sources_.emplace();
    for (std::size_t k = 0; k < touch_->properties.size(); ++k)
        if (const auto& property = touch_->properties[k]) (*sources_)[k] = touch_source(*property);
}

/// Of depth that says nothing of lengths: of larger values as a depth buffer's are, which are farther.
SceneDescription GltfClip::assumed() const {
    const auto& video = depth().video;
    if (!video) throw Refusal{"its mesh does not say what its depth means: describe it with a scene file"};
    if (video->tracks.size() > 1)
        throw Refusal{
            "its depth is two tracks, and its mesh does not say how many bits that is: describe it with a "
            "scene "
            "file"};
    constexpr double near = 0.5, far = 1.5;  // metres
    DepthCoding coding;
    coding.semantics = DepthSemantics::planar;
    coding.near_is_high = false;
    coding.near = near;
    coding.far = far;
    StoredImage size;
    size.image = {video->width, video->height, 1, 1, {}};
    auto guessed = guess_scene(folder_, size, {}, &coding);
    if (!guessed) throw guessed.error();
    Scene& scene = guessed->scene;
    scene.name = gltf_.file().stem().string();
    for (Remark& remark : scene.remarks)
        if (remark.is_guess || !remark.hints.empty()) remark.hints = {{Setting::scene_file, "FILE"}};
    add_remark(scene.remarks, {"depth goes from 0.5 m, black, to 1.5 m, white",
                               true,
                               "a scene file's depth.near and far say otherwise",
                               {{Setting::scene_file, "FILE"}}});
    return std::move(*guessed);
}

SceneDescription GltfClip::described() const {
    if (!own_) return assumed();
    auto scene =
        parse_scene((*own_)["scene"].json(), gltf_.file().string() + ": the scene in its mesh's extras");
    if (!scene) throw scene.error();
    return std::move(*scene);
}

/// What stands beside a texture counts: somebody may have changed it there. Whether that is so.
bool GltfClip::take_ranges(Scene& scene) const {
    const std::array<PropertyRange*, 3> ranges{&scene.haptic.stiffness, &scene.haptic.static_friction,
                                               &scene.haptic.dynamic_friction};
    const HapticProperties& usual = scene.default_properties;
    const std::array<double, 3> otherwise{usual.stiffness / 1000.0, usual.static_friction,
                                          usual.dynamic_friction};
    bool is_other = false;
    for (std::size_t k = 0; k < ranges.size(); ++k) {
        const auto& property = touch_->properties[k];
        const PropertyRange stated = !property         ? PropertyRange{otherwise[k], otherwise[k]}
                                     : property->range ? *property->range
                                                       : *ranges[k];
        is_other = is_other || ranges[k]->min != stated.min || ranges[k]->max != stated.max;
        *ranges[k] = stated;
    }
    return is_other;
}

/// Likewise of heights, which are metres there.
bool GltfClip::take_height(Scene& scene) const {
    const GltfLayer& height = *touch_->height;
    if (height.channel != 0)
        throw Refusal{"its heights are channel " + std::to_string(height.channel) +
                      " of a texture: must be 0, as they are grey"};
    if (!height.range) return false;
    if (height.range->min != 0)
        throw Refusal{"black of its heights must be 0: touchable_range is [0, metres]"};
    HeightCoding& coding = scene.height_coding;
    const double now =
        coding.max_height > 0 ? largest_height(coding, scene.depth) * scene.metres_per_unit : 0;
    if (height.range->max == now) return false;
    coding.units = HeightUnits::world;
    coding.max_height = height.range->max / scene.metres_per_unit;
    return true;
}

void GltfClip::take_touch(Scene& scene) {
    const bool has_haptic = planes_[static_cast<std::size_t>(PlaneRole::haptic)] || sources_;
    const bool has_others = has_haptic && take_ranges(scene);
    const bool is_other = (touch_->height && take_height(scene)) || has_others;
    if (own_ && is_other)
        add_remark(remarks_, {"the ranges of its haptic material are others than those of the scene in its "
                              "mesh: the material's stand"});
    const bool states_all = std::none_of(touch_->properties.begin(), touch_->properties.end(),
                                         [](const auto& property) { return property && !property->range; });
    if (!own_ && has_haptic && !states_all)
        add_remark(remarks_,
                   {"its haptic material states no units: black and white are the usual ends", true,
                    "\"extras\": {\"touchable_range\": [black, white]} beside a texture say others"});
    if (auto valid = validate(scene); !valid) throw Refusal{valid.error().message};
}

/// Tracks of one file, and pictures beside them.
Result<std::unique_ptr<ClipReader>> GltfClip::open_tracks(const SceneDescription& described,
                                                          Colour colour) const {
    const std::string& file = depth().video->file;
    PlaneTracks tracks;
    StillMaps maps = maps_;
    for (const PlaneRole role : all_roles) {
        const auto& plane = planes_[static_cast<std::size_t>(role)];
        if (!plane) continue;
        const std::string name(role_name(role));
        if (!plane->video) {
            if (role == PlaneRole::haptic) maps.haptic = gltf_.file();
            if (role == PlaneRole::height) maps.height = folder_ / plane->picture;
            continue;  // a picture of colour is what others show of the video
        }
        if (plane->video->file != file)
            throw Refusal{name + " and depth are videos in two files: must be tracks of one"};
        const auto& numbers = plane->video->tracks;
        if (numbers.empty() || numbers.size() > 2)
            throw Refusal{name + " is " + std::to_string(numbers.size()) +
                          " tracks of its file: must be one, or one of the high bits and one of the low"};
        tracks[static_cast<std::size_t>(role)] =
            NumberedTrack{numbers[0], numbers.size() == 2 ? std::optional(numbers[1]) : std::nullopt};
    }
    auto reader = open_mp4_tracks(SourceFile(folder_ / file), tracks, described, colour);
    if (!maps.haptic && !maps.height) return reader;
    return with_still_maps(std::move(reader), maps);
}

/// Pictures; or videos, each a file of its own.
Result<std::unique_ptr<ClipReader>> GltfClip::open_files(SceneDescription described, Colour colour) const {
    std::array<std::string, all_roles.size()> names;
    const bool is_moving = depth().video.has_value();
    for (const PlaneRole role : all_roles) {
        const auto& plane = planes_[static_cast<std::size_t>(role)];
        if (!plane) continue;
        if (plane->video && (!is_moving || role == PlaneRole::haptic || role == PlaneRole::height))
            throw Refusal{std::string(role_name(role)) +
                          " is a video in a file of its own: must be a picture, or a track of depth's file"};
        if (!plane->video && !is_still(plane->picture))
            throw Refusal{in_quotes(plane->picture) +
                          " is a name that stands for several files (%, *, .txt): rename it"};
        if (plane->video)
            names[static_cast<std::size_t>(role)] = plane->video->file;
        else if (role != PlaneRole::colour || !is_moving)
            names[static_cast<std::size_t>(role)] = plane->picture;
    }
    const auto& [depth, of_colour, haptic, height] = names;
    Scene& scene = described.scene;
    if (is_moving) {
        scene.video = VideoSource{depth, of_colour};
        scene.video->haptic = haptic;
        scene.video->height = height;
    } else {
        scene.folder.emplace();
        scene.folder->depth = depth;
        scene.folder->colour = of_colour;
        scene.folder->haptic = haptic;
        scene.folder->height = height;
        scene.folder->count = 1;
    }
    auto reader = is_moving ? open_video_clip(folder_, described, colour)
                            : open_image_folder(folder_, described, {}, colour);
    return maps_.haptic ? with_still_maps(std::move(reader), maps_) : std::move(reader);
}

Result<std::unique_ptr<ClipReader>> GltfClip::open(const std::optional<SceneDescription>& replacement,
                                                   Colour colour) {
    find_planes();
    SceneDescription scene = replacement ? *replacement : described();
    if (!replacement && touch_) take_touch(scene.scene);
    if (touch_ && !maps_.haptic)  // otherwise the map says so
        for (const std::string& note : touch_->notes) add_remark(remarks_, {note});
    scene.scene.remarks = joined_remarks(std::move(scene.scene.remarks), remarks_);
    scene.scene.folder.reset();
    scene.scene.video.reset();
    const bool has_tracks = depth().video && !depth().video->tracks.empty();
    auto reader = has_tracks ? open_tracks(scene, colour) : open_files(std::move(scene), colour);
    if (sources_) reader = with_touch_videos(std::move(reader), *sources_);
    if (!reader) return reader;
    (*reader)->add_input(gltf_.file());
    for (auto& file : files_of_others()) (*reader)->add_input(std::move(file));
    return reader;
}

/// What it has for programs that know no depth video: nobody may write there either.
std::vector<std::filesystem::path> GltfClip::files_of_others() const {
    std::vector<std::filesystem::path> files;
    for (const char* array : {"images", "buffers"}) {
        if (!gltf_.root().has(array)) continue;
        for (const Node& each : gltf_array(gltf_.root()[array])) {
            if (!each.has("uri")) continue;
            const auto link = follow_link(each["uri"].text(), gltf_.file());
            if (link && !link->file.empty()) files.push_back(link->file);
        }
    }
    return files;
}

}  // namespace

bool is_gltf(const SourceFile& file) {
    std::string ending = file.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".gltf" || ending == ".glb" || first_bytes(file, 4) == "glTF";
}

Result<std::unique_ptr<ClipReader>> open_gltf_clip(const SourceFile& file,
                                                   const std::optional<SceneDescription>& described,
                                                   Colour colour) {
    TRY_ASSIGN(const auto bytes, file.read("a glTF scene", largest_file));
    return read_gltf(file.path(), [&] { return GltfClip(file, bytes).open(described, colour); });
}

}  // namespace touchable
