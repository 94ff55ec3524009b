#include "engine/formats/gltf_scene.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "engine/base/trigonometry.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

/// Members stay in the order in which a person reads them.
using Json = nlohmann::ordered_json;

// Numbers of OpenGL, by which glTF names types, filters and targets.
constexpr int gl_ubyte = 5121, gl_ushort = 5123, gl_uint = 5125, gl_float = 5126;
constexpr int gl_nearest = 9728, gl_linear = 9729, gl_clamp_to_edge = 33071;
constexpr int gl_array_buffer = 34962, gl_element_array_buffer = 34963;

constexpr std::array<PlaneRole, 4> texture_order{PlaneRole::colour, PlaneRole::depth, PlaneRole::haptic,
                                                 PlaneRole::height};

/// RFC 3986: all but unreserved characters as %XX.
std::string as_uri(std::string_view name) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string uri;
    for (const char c : name) {
        const bool is_plain = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                              std::string_view("-._~").find(c) != std::string_view::npos;
        const auto byte = static_cast<unsigned char>(c);
        if (is_plain)
            uri += c;
        else
            (uri += '%').append({digits[byte >> 4U], digits[byte & 15U]});
    }
    return uri;
}

class GltfScene {
public:
    GltfScene(const SceneDescription& described, const GltfClipFiles& files, const FallbackMesh& mesh)
        : described_(described), scene_(described.scene), files_(files), mesh_(mesh) {}
    std::string text();

private:
    int add(const char* array, Json element) {
        Json& elements = gltf_[array];
        elements.push_back(std::move(element));
        return static_cast<int>(elements.size()) - 1;
    }
    bool is_moving() const { return !files_.video.empty(); }
    void add_mesh_data();
    void add_textures();
    Json video_texture(PlaneRole role, const GltfPlane& plane);
    Json haptic_texture(PlaneRole role, const char* type, PropertyRange range, int channel, const char* kind);
    void add_haptic_material();
    void add_media();
    void add_mesh();
    void add_camera();
    Json own_extras() const;

    const SceneDescription& described_;
    const Scene& scene_;
    const GltfClipFiles& files_;
    const FallbackMesh& mesh_;
    Json gltf_;
    std::array<int, all_roles.size()> textures_{-1, -1, -1, -1};
    Json attributes_;
    int indices_ = 0;
    bool is_touched_ = false;
};

/// The buffer of the still mesh, its views and what they hold.
void GltfScene::add_mesh_data() {
    const std::size_t vertices = mesh_.positions.size(), corners = 3 * mesh_.triangles.size();
    const int buffer =
        add("buffers", {{"uri", as_uri(files_.mesh)}, {"byteLength", 4 * corners + (12 + 8) * vertices}});
    std::size_t at = 0;
    const auto view = [&](std::size_t bytes, int target) {
        const int number =
            add("bufferViews",
                {{"buffer", buffer}, {"byteOffset", at}, {"byteLength", bytes}, {"target", target}});
        at += bytes;
        return number;
    };
    std::array<float, 3> least = mesh_.positions.front(), most = least;
    for (const auto& position : mesh_.positions)
        for (std::size_t k = 0; k < position.size(); ++k) {
            least[k] = std::min(least[k], position[k]);
            most[k] = std::max(most[k], position[k]);
        }
    indices_ = add("accessors", {{"bufferView", view(4 * corners, gl_element_array_buffer)},
                                 {"componentType", gl_uint},
                                 {"count", corners},
                                 {"type", "SCALAR"}});
    attributes_["POSITION"] = add("accessors", {{"bufferView", view(12 * vertices, gl_array_buffer)},
                                                {"componentType", gl_float},
                                                {"count", vertices},
                                                {"type", "VEC3"},
                                                {"min", least},
                                                {"max", most}});
    attributes_["TEXCOORD_0"] = add("accessors", {{"bufferView", view(8 * vertices, gl_array_buffer)},
                                                  {"componentType", gl_float},
                                                  {"count", vertices},
                                                  {"type", "VEC2"}});
}

/// What is to be MPEG_texture_video of a texture, and the buffer that its frames come into.
Json GltfScene::video_texture(PlaneRole role, const GltfPlane& plane) {
    const bool is_wide = plane.tracks.size() > 1,
               is_hue = role == PlaneRole::depth && scene_.depth.kind == DepthCodingKind::hue,
               is_rgb = role == PlaneRole::colour || role == PlaneRole::haptic || is_hue;
    const std::size_t pixels =
                          static_cast<std::size_t>(scene_.width) * static_cast<std::size_t>(scene_.height),
                      bytes = pixels * (is_rgb    ? 3
                                        : is_wide ? 2
                                                  : 1);
    const int buffer = add(
        "buffers",
        {{"byteLength", bytes},
         {"extensions", {{"MPEG_buffer_circular", {{"media", 0}, {"count", 2}, {"tracks", plane.tracks}}}}}});
    const int accessor =
        add("accessors",
            {{"bufferView", add("bufferViews", {{"buffer", buffer}, {"byteLength", bytes}})},
             {"componentType", is_wide ? gl_ushort : gl_ubyte},
             {"normalized", true},
             {"count", pixels},
             {"type", is_rgb ? "VEC3" : "SCALAR"},
             {"extensions", {{"MPEG_accessor_timed", {{"suggestedUpdateRate", scene_.rate.per_second()}}}}}});
    return {{"accessor", accessor},
            {"width", scene_.width},
            {"height", scene_.height},
            {"format", is_rgb                     ? "RGB"
                       : role == PlaneRole::depth ? "DEPTH_COMPONENT"
                                                  : "RED"}};
}

/// What is drawn is the first, with a picture for those who know no video; the others are data.
void GltfScene::add_textures() {
    const auto sampler = [&](int filter) {
        return add("samplers", {{"magFilter", filter},
                                {"minFilter", filter},
                                {"wrapS", gl_clamp_to_edge},
                                {"wrapT", gl_clamp_to_edge}});
    };
    const int smooth = sampler(gl_linear), exact = sampler(gl_nearest);
    const auto picture = [&](const std::string& name) {
        return add("images", {{"uri", as_uri(name)}, {"mimeType", "image/png"}});
    };
    for (const PlaneRole role : texture_order) {
        const auto& plane = files_.planes[static_cast<std::size_t>(role)];
        const bool is_drawn = role == PlaneRole::colour;
        if (!plane && !is_drawn) continue;
        Json texture{{"name", plane ? role_name(role) : "poster"}, {"sampler", is_drawn ? smooth : exact}};
        if (is_drawn)
            texture["source"] = picture(files_.poster);
        else if (plane->tracks.empty())
            texture["source"] = picture(plane->picture);
        if (plane && !plane->tracks.empty())
            texture["extensions"]["MPEG_texture_video"] = video_texture(role, *plane);
        textures_[static_cast<std::size_t>(role)] = add("textures", std::move(texture));
    }
}

Json GltfScene::haptic_texture(PlaneRole role, const char* type, PropertyRange range, int channel,
                               const char* kind) {
    Json extras{{"touchable_range", {range.min, range.max}}, {"touchable_channel", channel}};
    if (kind) extras["touchable_kind"] = kind;
    is_touched_ = true;
    return {{"texture", {{"index", textures_[static_cast<std::size_t>(role)]}}},
            {"type", type},
            {"extras", std::move(extras)}};
}

/// The extension knows one friction, no heights and no units: "extras" do.
void GltfScene::add_haptic_material() {
    Json material{{"name", "haptics"}};
    const auto has = [&](PlaneRole role) {
        return files_.planes[static_cast<std::size_t>(role)].has_value();
    };
    const HapticRanges& ranges = scene_.haptic;
    if (has(PlaneRole::haptic)) {
        const auto texture = [&](PropertyRange range, int channel, const char* kind) {
            return haptic_texture(PlaneRole::haptic, "High_Resolution", range, channel, kind);
        };
        material["stiffness"] = Json::array({texture(ranges.stiffness, 0, nullptr)});
        material["friction"] = Json::array(
            {texture(ranges.static_friction, 1, "static"), texture(ranges.dynamic_friction, 2, "dynamic")});
    }
    const double white = scene_.height_coding.max_height > 0
                             ? largest_height(scene_.height_coding, scene_.depth) * scene_.metres_per_unit
                             : 0;
    if (has(PlaneRole::height))
        material["custom"] =
            Json::array({haptic_texture(PlaneRole::height, "Other", {0, white}, 0, "height")});
    if (is_touched_) gltf_["extensions"]["MPEG_haptic_material"]["materials"] = Json::array({material});
}

void GltfScene::add_media() {
    Json tracks = Json::array();
    for (const GltfTrack& track : files_.tracks)
        tracks.push_back({{"track", "#track_ID=" + std::to_string(track.number)}, {"codecs", track.codecs}});
    const Json file{{"uri", as_uri(files_.video)}, {"mimeType", "video/mp4"}, {"tracks", tracks}};
    gltf_["extensions"]["MPEG_media"]["media"] =
        Json::array({{{"name", scene_.name.empty() ? "clip" : scene_.name},
                      {"autoplay", true},
                      {"loop", true},
                      {"alternatives", Json::array({file})}}});
}

/// What no extension says: which texture is depth, and what its values and the camera are.
Json GltfScene::own_extras() const {
    SceneDescription described = described_;
    described.scene.folder.reset();
    described.scene.video.reset();
    described.scene.stored = {};
    described.unstated.rate = is_moving();  // its file says it
    Json own{{"depth", textures_[static_cast<std::size_t>(PlaneRole::depth)]}};
    if (files_.planes[static_cast<std::size_t>(PlaneRole::colour)])
        own["colour"] = textures_[static_cast<std::size_t>(PlaneRole::colour)];
    own["scene"] = Json::parse(scene_to_json(described));
    return {{"touchable", std::move(own)}};
}

void GltfScene::add_mesh() {
    const int look =
        add("materials",
            {{"name", "clip"},
             {"pbrMetallicRoughness",
              {{"baseColorTexture", {{"index", textures_[static_cast<std::size_t>(PlaneRole::colour)]}}},
               {"metallicFactor", 0},
               {"roughnessFactor", 1}}},
             {"extensions", {{"KHR_materials_unlit", Json::object()}}},
             {"doubleSided", true}});
    Json mesh{{"name", "clip"},
              {"primitives",
               Json::array({{{"attributes", attributes_}, {"indices", indices_}, {"material", look}}})}};
    if (is_touched_) mesh["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
    mesh["extras"] = own_extras();
    add("meshes", std::move(mesh));
}

/// The clip's own, as far as glTF has such: its axis goes through the picture's middle.
void GltfScene::add_camera() {
    const Camera& camera = scene_.camera;
    const double across = scene_.width / camera.fx, down = scene_.height / camera.fy;
    const double near = std::max(1e-3, scene_.depth.near * scene_.metres_per_unit / 10);
    add("cameras", {{"type", "perspective"},
                    {"perspective",
                     {{"yfov", 2 * arctangent(down / 2)}, {"aspectRatio", across / down}, {"znear", near}}}});
}

std::string GltfScene::text() {
    gltf_ = {{"asset", {{"version", "2.0"}, {"generator", "touchable"}}},
             {"extensionsUsed", Json::array()},
             {"scene", 0},
             {"scenes", Json::array({{{"nodes", {0, 1}}}})},
             {"nodes", Json::array({{{"name", "clip"}, {"mesh", 0}}, {{"name", "camera"}, {"camera", 0}}})}};
    add_mesh_data();
    add_textures();
    if (is_moving()) add_media();
    add_haptic_material();
    add_mesh();
    add_camera();
    Json& used = gltf_["extensionsUsed"];
    used.push_back("KHR_materials_unlit");
    if (is_moving())
        for (const char* name :
             {"MPEG_media", "MPEG_buffer_circular", "MPEG_accessor_timed", "MPEG_texture_video"})
            used.push_back(name);
    if (is_touched_) used.push_back("MPEG_haptic_material");
    return gltf_.dump(1) + "\n";
}

template <class Number>
void append(std::string& bytes, Number number) {
    std::uint32_t word;
    static_assert(sizeof number == sizeof word);
    std::memcpy(&word, &number, sizeof word);
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(word >> (8 * k) & 255U);
}

}  // namespace

std::string gltf_scene(const SceneDescription& described, const GltfClipFiles& files,
                       const FallbackMesh& mesh) {
    return GltfScene(described, files, mesh).text();
}

std::string bytes_of_mesh(const FallbackMesh& mesh) {
    std::string bytes;
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) append(bytes, corner);
    for (const auto& position : mesh.positions)
        for (const float number : position) append(bytes, number);
    for (const auto& place : mesh.texture_places)
        for (const float number : place) append(bytes, number);
    return bytes;
}

}  // namespace touchable
