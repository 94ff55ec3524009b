// SPDX-License-Identifier: Apache-2.0
// Programs without video support draw the scene as a still mesh (FallbackMesh). Its video, its haptic
// material and its scene file are in extensions and "extras", which programs may ignore (GltfScene).

#include "engine/formats/gltf_writer.hpp"

#include <bit>
#include <nlohmann/json.hpp>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr int most_cells = 96;  // of the mesh, along the longer side, where it has no edges
constexpr std::size_t most_fine_vertices = 1 << 16;  // beyond these, edges too have only large cells
/// Depth between two vertices over their distance across the view, at the nearer one; more is an edge.
constexpr double steepest_slope = 4;

/// Evenly spaced pixels from 0 to the last.
std::vector<int> mesh_places(int pixels, int longer_side) {
    const int cells = std::clamp(most_cells * pixels / longer_side, 1, std::max(1, pixels - 1));
    std::vector<int> places;
    for (int k = 0; k <= cells; ++k) places.push_back(k * (pixels - 1) / cells);
    return places;
}

class MeshOfFrame {
public:
    MeshOfFrame(const RawFrame& frame, const Scene& scene) : depth_(frame.depth), scene_(scene) {}

    FallbackMesh made() {
        const int longer_side = std::max(scene_.width, scene_.height);
        const std::vector<int> columns = mesh_places(scene_.width, longer_side),
                               rows = mesh_places(scene_.height, longer_side);
        vertices_.assign(pixel_count(scene_.width, scene_.height), no_vertex);
        for (std::size_t row = 0; row + 1 < rows.size(); ++row)
            for (std::size_t column = 0; column + 1 < columns.size(); ++column)
                add_cells(columns[column], rows[row], columns[column + 1], rows[row + 1]);
        if (mesh_.triangles.empty()) add_rectangle();
        return std::move(mesh_);
    }

private:
    using Corner = std::array<std::uint32_t, 3>;

    /// Adds a cell as two triangles, or, so that the mesh follows silhouettes, pixel by pixel if an edge or a
    /// hole is in it.
    void add_cells(int left, int top, int right, int bottom) {
        if (mesh_.positions.size() > most_fine_vertices || is_even(left, top, right, bottom))
            return add_cell(left, top, right, bottom);
        for (int y = top; y < bottom; ++y)
            for (int x = left; x < right; ++x) add_cell(x, y, x + 1, y + 1);
    }

    void add_cell(int left, int top, int right, int bottom) {
        const std::uint32_t first = vertex(left, top), last = vertex(right, bottom);
        add_triangle({first, vertex(left, bottom), last});
        add_triangle({first, last, vertex(right, top)});
    }

    bool is_even(int left, int top, int right, int bottom) const {
        double nearest = scene_.depth.far, deepest = 0;
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                const auto depth = planar(x, y);
                if (!depth) return false;
                nearest = std::min(nearest, *depth);
                deepest = std::max(deepest, *depth);
            }
        return deepest - nearest <= steepest_slope * nearest * (right - left) / scene_.camera.fx;
    }

    std::uint32_t vertex(int x, int y) {
        std::uint32_t& known = vertices_[pixel_place(x, y, scene_.width)];
        if (known != no_vertex) return known;
        known = static_cast<std::uint32_t>(mesh_.positions.size());
        const auto there = planar(x, y);
        is_hole_.resize(known);  // what add_behind added is none
        is_hole_.push_back(!there);
        add_position(x, y, there.value_or(scene_.depth.far));
        return known;
    }

    /// Adds a triangle if no corner is in a hole. Corners that lie far before another get its depth, so that
    /// from the clip's own camera nothing is missing between two surfaces.
    void add_triangle(Corner corners) {
        if (std::ranges::any_of(corners, [this](std::uint32_t corner) { return is_hole_[corner]; })) return;
        const std::uint32_t deepest = *std::ranges::min_element(
            corners, {}, [this](std::uint32_t corner) { return mesh_.positions[corner][2]; });
        for (std::uint32_t& corner : corners)
            if (corner != deepest && is_edge(corner, deepest)) corner = add_behind(corner, deepest);
        mesh_.triangles.push_back(corners);
    }

    /// Whether one vertex lies far behind the other.
    bool is_edge(std::uint32_t a, std::uint32_t b) const {
        const auto &from = mesh_.positions[a], &to = mesh_.positions[b];
        const double nearer = std::min(-from[2], -to[2]), deeper = to[2] - from[2];
        const double across_x = nearer * (to[0] / to[2] - from[0] / from[2]),
                     across_y = nearer * (to[1] / to[2] - from[1] / from[2]);
        return deeper * deeper >
               steepest_slope * steepest_slope * (across_x * across_x + across_y * across_y);
    }

    /// Adds a vertex that the camera sees at the place of `vertex`, as deep as `deeper`; returns its index.
    std::uint32_t add_behind(std::uint32_t vertex, std::uint32_t deeper) {
        std::array<float, 3> position = mesh_.positions[vertex];
        const float farther = mesh_.positions[deeper][2] / position[2];
        for (float& each : position) each *= farther;
        mesh_.positions.push_back(position);
        mesh_.texture_places.push_back(std::array(mesh_.texture_places[vertex]));
        return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
    }

    void add_rectangle() {
        mesh_ = {};
        for (const int y : {0, scene_.height - 1})
            for (const int x : {0, scene_.width - 1}) add_position(x, y, scene_.depth.far);
        mesh_.triangles = {{0, 2, 3}, {0, 3, 1}};
    }

    /// Depth along -Z, scene units; nothing in a hole.
    std::optional<double> planar(int x, int y) const {
        const DepthCoding& coding = scene_.depth;
        if (coding.kind == DepthCodingKind::hue) return std::nullopt;
        const int code = depth_.sample(x, y);
        if (!coding.is_valid(static_cast<std::uint16_t>(code))) return std::nullopt;
        return planar_depth(scene_.camera, coding.semantics, x, y,
                            coding.depth(static_cast<std::uint16_t>(code)));
    }

    void add_position(int x, int y, double planar) {
        const glm::dvec3 point = scene_.metres_per_unit * unproject(scene_.camera, x, y, planar);
        mesh_.positions.push_back(
            {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)});
        mesh_.texture_places.push_back(
            {static_cast<float>((x + 0.5) / scene_.width), static_cast<float>((y + 0.5) / scene_.height)});
    }

    const PlaneView& depth_;
    const Scene& scene_;
    FallbackMesh mesh_;
    static constexpr std::uint32_t no_vertex = 0xffffffff;
    std::vector<std::uint32_t> vertices_;  // of the mesh, by pixel
    std::vector<bool> is_hole_;
};

/// A track of the clip's MP4 file.
struct GltfTrack {
    std::uint32_t number = 0;
    std::string codecs;  ///< RFC 6381: "avc1.640028"
};

/// How a plane is stored: as tracks, the high bits of its samples first, or as a picture.
struct GltfPlane {
    std::vector<std::size_t> tracks;  ///< of GltfClipFiles::tracks; empty: a picture
    std::string picture;              ///< a file's name
};

/// The files of a glTF scene, all in its folder.
struct GltfClipFiles {
    std::string video;              ///< MP4; empty: pictures
    std::vector<GltfTrack> tracks;  ///< of that file
    std::string poster;             ///< shown by programs without MPEG_texture_video
    std::string mesh;               ///< has bytes_of_mesh
    std::array<std::optional<GltfPlane>, all_roles.size()> planes;

    std::optional<GltfPlane>& plane(PlaneRole role) { return planes[static_cast<std::size_t>(role)]; }
    const std::optional<GltfPlane>& plane(PlaneRole role) const {
        return planes[static_cast<std::size_t>(role)];
    }
};

/// Members stay in the order in which they are added, for human readers.
using OrderedJson = nlohmann::ordered_json;

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

/// Writes a touchable clip as glTF 2.0 (docs/codecs.md) in indented JSON: extensions of MPEG, all of which a
/// program may ignore, and the scene file in the mesh's "extras", under "touchable".
class GltfScene {
public:
    GltfScene(const SceneDescription& described, const GltfClipFiles& files, const FallbackMesh& mesh)
        : described_(described), scene_(described.scene), files_(files), mesh_(mesh) {}

    std::string text() {
        gltf_ = {{"asset", {{"version", "2.0"}, {"generator", "touchable"}}},
                 {"extensionsUsed", OrderedJson::array()},
                 {"scene", 0},
                 {"scenes", OrderedJson::array({{{"nodes", {0, 1}}}})},
                 {"nodes", OrderedJson::array(
                               {{{"name", "clip"}, {"mesh", 0}}, {{"name", "camera"}, {"camera", 0}}})}};
        add_mesh_data();
        add_textures();
        if (is_moving()) add_media();
        add_haptic_material();
        add_mesh();
        add_camera();
        OrderedJson& used = gltf_["extensionsUsed"];
        used.push_back("KHR_materials_unlit");
        if (is_moving())
            for (const char* name :
                 {"MPEG_media", "MPEG_buffer_circular", "MPEG_accessor_timed", "MPEG_texture_video"})
                used.push_back(name);
        if (is_touched_) used.push_back("MPEG_haptic_material");
        return gltf_.dump(1) + "\n";
    }

private:
    int add(const char* array, OrderedJson element) {
        OrderedJson& elements = gltf_[array];
        elements.push_back(std::move(element));
        return static_cast<int>(elements.size()) - 1;
    }
    bool is_moving() const { return !files_.video.empty(); }
    int& texture_of(PlaneRole role) { return textures_[static_cast<std::size_t>(role)]; }

    /// Adds the buffer of the still mesh, its views and their accessors.
    void add_mesh_data() {
        const std::size_t vertices = mesh_.positions.size(), corners = 3 * mesh_.triangles.size();
        const int buffer =
            add("buffers", {{"uri", as_uri(files_.mesh)}, {"byteLength", 4 * corners + (12 + 8) * vertices}});
        std::size_t at = 0;
        const auto accessor = [&](std::size_t bytes, int target, int component, std::size_t count,
                                  const char* type) -> OrderedJson {
            const int view =
                add("bufferViews",
                    {{"buffer", buffer}, {"byteOffset", at}, {"byteLength", bytes}, {"target", target}});
            at += bytes;
            return {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}};
        };
        std::array<float, 3> least = mesh_.positions.front(), most = least;
        for (const auto& position : mesh_.positions)
            for (std::size_t k = 0; k < position.size(); ++k) {
                least[k] = std::min(least[k], position[k]);
                most[k] = std::max(most[k], position[k]);
            }
        indices_ =
            add("accessors", accessor(4 * corners, gl_element_array_buffer, gl_uint, corners, "SCALAR"));
        OrderedJson positions = accessor(12 * vertices, gl_array_buffer, gl_float, vertices, "VEC3");
        positions["min"] = least;
        positions["max"] = most;
        attributes_["POSITION"] = add("accessors", std::move(positions));
        attributes_["TEXCOORD_0"] =
            add("accessors", accessor(8 * vertices, gl_array_buffer, gl_float, vertices, "VEC2"));
    }

    /// The first texture is drawn, with a picture for programs without video support; the others are data.
    void add_textures() {
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
            const auto& plane = files_.plane(role);
            const bool is_drawn = role == PlaneRole::colour;
            if (!plane && !is_drawn) continue;
            OrderedJson texture{{"name", plane ? role_name(role) : "poster"},
                                {"sampler", is_drawn ? smooth : exact}};
            if (is_drawn)
                texture["source"] = picture(files_.poster);
            else if (plane->tracks.empty())
                texture["source"] = picture(plane->picture);
            if (plane && !plane->tracks.empty())
                texture["extensions"]["MPEG_texture_video"] = video_texture(role, *plane);
            texture_of(role) = add("textures", std::move(texture));
        }
    }

    /// Makes the MPEG_texture_video of a texture; adds the buffer for its frames.
    OrderedJson video_texture(PlaneRole role, const GltfPlane& plane) {
        const bool is_wide = plane.tracks.size() > 1,
                   is_hue = role == PlaneRole::depth && scene_.depth.kind == DepthCodingKind::hue,
                   is_rgb = role == PlaneRole::colour || role == PlaneRole::haptic || is_hue;
        const std::size_t pixels = pixel_count(scene_.width, scene_.height), bytes = pixels * (is_rgb    ? 3
                                                                                               : is_wide ? 2
                                                                                                         : 1);
        const int buffer =
            add("buffers",
                {{"byteLength", bytes},
                 {"extensions",
                  {{"MPEG_buffer_circular", {{"media", 0}, {"count", 2}, {"tracks", plane.tracks}}}}}});
        const int accessor = add(
            "accessors",
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

    OrderedJson haptic_texture(PlaneRole role, const char* type, PropertyRange range, int channel,
                               const char* kind) {
        OrderedJson extras{{"touchable_range", {range.min, range.max}}, {"touchable_channel", channel}};
        if (kind) extras["touchable_kind"] = kind;
        is_touched_ = true;
        return {{"texture", {{"index", texture_of(role)}}}, {"type", type}, {"extras", std::move(extras)}};
    }

    /// The extension has one friction, no heights and no units: "extras" add these.
    void add_haptic_material() {
        OrderedJson material{{"name", "haptics"}};
        const HapticRanges& ranges = scene_.haptic;
        if (files_.plane(PlaneRole::haptic)) {
            const auto layer = [&](PropertyRange range, int channel, const char* kind) {
                return haptic_texture(PlaneRole::haptic, "High_Resolution", range, channel, kind);
            };
            material["stiffness"] = OrderedJson::array({layer(ranges.stiffness, 0, nullptr)});
            material["friction"] = OrderedJson::array(
                {layer(ranges.static_friction, 1, "static"), layer(ranges.dynamic_friction, 2, "dynamic")});
        }
        const double white = scene_.height_coding.max_height > 0
                                 ? largest_height(scene_.height_coding, scene_.depth) * scene_.metres_per_unit
                                 : 0;
        if (files_.plane(PlaneRole::height))
            material["custom"] =
                OrderedJson::array({haptic_texture(PlaneRole::height, "Other", {0, white}, 0, "height")});
        if (is_touched_)
            gltf_["extensions"]["MPEG_haptic_material"]["materials"] = OrderedJson::array({material});
    }

    void add_media() {
        OrderedJson tracks = OrderedJson::array();
        for (const GltfTrack& track : files_.tracks)
            tracks.push_back(
                {{"track", "#track_ID=" + std::to_string(track.number)}, {"codecs", track.codecs}});
        const OrderedJson file{{"uri", as_uri(files_.video)}, {"mimeType", "video/mp4"}, {"tracks", tracks}};
        gltf_["extensions"]["MPEG_media"]["media"] =
            OrderedJson::array({{{"name", scene_.name.empty() ? "clip" : scene_.name},
                                 {"autoplay", true},
                                 {"loop", true},
                                 {"alternatives", OrderedJson::array({file})}}});
    }

    void add_mesh() {
        const int look = add("materials", {{"name", "clip"},
                                           {"pbrMetallicRoughness",
                                            {{"baseColorTexture", {{"index", texture_of(PlaneRole::colour)}}},
                                             {"metallicFactor", 0},
                                             {"roughnessFactor", 1}}},
                                           {"extensions", {{"KHR_materials_unlit", OrderedJson::object()}}},
                                           {"doubleSided", true}});
        OrderedJson mesh{
            {"name", "clip"},
            {"primitives",
             OrderedJson::array({{{"attributes", attributes_}, {"indices", indices_}, {"material", look}}})}};
        if (is_touched_) mesh["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
        mesh["extras"] = own_extras();
        add("meshes", std::move(mesh));
    }

    /// Adds the clip's camera as far as glTF can: its axis goes through the picture's middle.
    void add_camera() {
        const Camera& camera = scene_.camera;
        const double across = scene_.width / camera.fx, down = scene_.height / camera.fy;
        const double near = std::max(1e-3, scene_.depth.near * scene_.metres_per_unit / 10);
        add("cameras",
            {{"type", "perspective"},
             {"perspective",
              {{"yfov", 2 * arctangent(down / 2)}, {"aspectRatio", across / down}, {"znear", near}}}});
    }

    /// What no extension says: which texture is depth, and what its values and the camera are.
    OrderedJson own_extras() {
        SceneDescription described = described_;
        described.scene.folder.reset();
        described.scene.video.reset();
        described.scene.stored = {};
        described.unstated.rate = is_moving();  // the video states it
        OrderedJson own{{"depth", texture_of(PlaneRole::depth)}};
        if (files_.plane(PlaneRole::colour)) own["colour"] = texture_of(PlaneRole::colour);
        own["scene"] = OrderedJson::parse(scene_to_json(described));
        return {{"touchable", std::move(own)}};
    }

    const SceneDescription& described_;
    const Scene& scene_;
    const GltfClipFiles& files_;
    const FallbackMesh& mesh_;
    OrderedJson gltf_;
    std::array<int, all_roles.size()> textures_{-1, -1, -1, -1};
    OrderedJson attributes_;
    int indices_ = 0;
    bool is_touched_ = false;
};

/// Indices, positions and texture coordinates, in the buffer's order, little-endian.
std::string bytes_of_mesh(const FallbackMesh& mesh) {
    static_assert(std::endian::native == std::endian::little, "numbers are written as they are stored");
    std::string bytes;
    const auto add = [&](const auto& all) {
        bytes.append(reinterpret_cast<const char*>(all.data()), all.size() * sizeof all[0]);
    };
    add(mesh.triangles);
    add(mesh.positions);
    add(mesh.texture_places);
    return bytes;
}

/// RFC 6381: the codec parameters that a player must know to decode a track; empty if not H.264.
std::string codecs_of(const AVCodecParameters& stored) {
    if (stored.codec_id != AV_CODEC_ID_H264 || stored.extradata_size < 4) return "";
    return formatted("avc1.%02X%02X%02X", stored.extradata[1], stored.extradata[2], stored.extradata[3]);
}

/// Depth as grey of 8 bits, near and far as stored.
Image as_seen(const PlaneView& depth, int code_max) {
    Image image{depth.width, depth.height, 1, 1, {}};
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            image.samples.push_back(
                static_cast<std::uint8_t>(std::min(255, 255 * depth.sample(x, y) / code_max)));
    return image;
}

class GltfClipWriter final : public ClipWriter {
public:
    GltfClipWriter(const fs::path& place, const SceneDescription& described, bool is_still, Existing existing)
        : place_(place),
          described_(described),
          is_still_(is_still),
          existing_(existing),
          hidden_(place.parent_path().empty() ? fs::path(".") : place.parent_path()) {}

    Result<void> open(const ClipStorage& storage, const std::optional<SoundPart>& sound) {
        if (hidden_.failure())
            return input_error(place_.string() + ": cannot be written: " + hidden_.failure().message());
        if (is_still_) return check_storable(place_, described_);
        return assign(video_, as_named(create_clip(hidden_.path() / name(".mp4"), described_, storage,
                                                   Existing::keep, sound)));
    }

    Result<void> write(const RawFrame& frame) override {
        if (frames_ == 0) first_ = frame;
        if (++frames_ > 1 && is_still_) return internal_error(place_.string() + ": is of one frame");
        if (!video_) return {};
        return as_named(video_->write(frame));
    }
    PlaneView stored_colour() const override { return video_ ? video_->stored_colour() : PlaneView{}; }
    bool is_full() const override { return video_ && video_->is_full(); }

    Result<fs::path> complete() override {
        if (frames_ == 0) return input_error(place_.string() + ": not written: no frame was given");
        GltfClipFiles files;
        TRY(as_named(video_ ? end_video(files) : write_planes(files)));
        TRY(as_named(write_poster(files)));
        const FallbackMesh mesh = fallback_mesh(first_, described_.scene);
        files.mesh = name(".bin");
        TRY(write_file(files.mesh, bytes_of_mesh(mesh)));
        TRY(write_file(place_.filename().string(), GltfScene(described_, files, mesh).text()));
        TRY(hidden_.sync(place_));
        is_complete_ = true;
        return hidden_.path() / place_.filename();
    }

    Result<void> finish() override {
        if (!is_complete_) TRY(complete());
        return hidden_.move_to(place_.parent_path(), names_, existing_);
    }

private:
    std::string name(const std::string& end) const { return place_.stem().string() + end; }
    /// Names the files' final folder in a message instead of the hidden one.
    template <class T>
    Result<T> as_named(Result<T> result) const {
        if (result) return result;
        Error error = result.error();
        const fs::path home = place_.parent_path();
        error.message = shown_as(error.message, hidden_.path(), home.empty() ? "." : home);
        return error;
    }

    Result<void> write_file(const std::string& name, const std::string& bytes) {
        names_.push_back(name);
        return hidden_.write(place_.parent_path(), name, bytes);
    }
    Result<void> write_picture(const std::string& name, const PlaneView& plane) {
        names_.push_back(name);
        return write_png_to(hidden_.path() / name, plane, place_.parent_path() / name, PngEffort::quick);
    }

    /// Finishes the video, and finds each plane's tracks by their handlers' names.
    Result<void> end_video(GltfClipFiles& files) {
        TRY(video_->finish());
        files.video = name(".mp4");
        names_.push_back(files.video);
        TRY_ASSIGN(const auto opened, Demuxer::open_quicktime(SourceFile(hidden_.path() / files.video)));
        for (auto [stream, plane] : opened->tagged_pictures("handler_name")) {
            if (plane.ends_with(low_track_suffix))
                plane.resize(plane.size() - std::string_view(low_track_suffix).size());
            const auto role = role_named(plane);
            if (!role) continue;
            auto& stored = files.plane(*role);
            if (!stored) stored.emplace();
            stored->tracks.push_back(files.tracks.size());
            files.tracks.push_back({static_cast<std::uint32_t>(stream->id), codecs_of(*stream->codecpar)});
        }
        return {};
    }

    Result<void> write_planes(GltfClipFiles& files) {
        for (const auto& [role, plane] : planes_of(first_)) {
            const std::string picture = name('_' + std::string(role_name(role)) + ".png");
            TRY(write_picture(picture, plane));
            files.plane(role) = GltfPlane{{}, picture};
        }
        return {};
    }

    /// Writes the poster; a still's colour serves as one.
    Result<void> write_poster(GltfClipFiles& files) {
        const auto& colour = files.plane(PlaneRole::colour);
        files.poster = colour && is_still_ ? colour->picture : name(".png");
        if (colour && is_still_) return {};
        if (!first_.colour.empty()) return write_picture(files.poster, first_.colour);
        if (first_.depth.channels == 3) return write_picture(files.poster, first_.depth);
        return write_picture(files.poster, as_seen(first_.depth, described_.scene.depth.code_max).view());
    }

    fs::path place_;
    SceneDescription described_;
    bool is_still_;
    Existing existing_;
    HiddenFolder hidden_;
    std::unique_ptr<ClipWriter> video_;  // null: a still
    RawFrame first_;
    std::int64_t frames_ = 0;
    std::vector<std::string> names_;  // in the order in which the files appear
    bool is_complete_ = false;
};

}  // namespace

FallbackMesh fallback_mesh(const RawFrame& frame, const Scene& scene) {
    return MeshOfFrame(frame, scene).made();
}

Result<std::unique_ptr<ClipWriter>> create_gltf_clip(const fs::path& path, const SceneDescription& described,
                                                     bool is_still, const ClipStorage& storage,
                                                     Existing existing,
                                                     const std::optional<SoundPart>& sound) {
    if (is_still && !touchable::is_still(path.stem().string()))
        return usage_error(path.string() + ": has a % or * in its name, which stand for numbers");
    return opened_as<ClipWriter>(std::make_unique<GltfClipWriter>(path, described, is_still, existing),
                                 storage, sound);
}

std::vector<fs::path> gltf_clip_files(const fs::path& path, bool is_still) {
    std::vector<std::string> ends{".bin", ".png"};
    if (!is_still) ends.emplace_back(".mp4");
    if (is_still)
        for (const PlaneRole role : all_roles) ends.push_back('_' + std::string(role_name(role)) + ".png");
    std::vector<fs::path> files{path};
    for (const std::string& end : ends) files.push_back(path.parent_path() / (path.stem().string() + end));
    return files;
}

}  // namespace touchable
