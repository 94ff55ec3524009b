#include "engine/mpeg4/clip_scene.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "engine/base/trigonometry.hpp"
#include "engine/base/try.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr double pixel_width = 0.001;  // of a scene that knows pixels alone

bool is_in_the_middle(const Camera& camera, int width, int height) {
    const Camera paper = camera_from_focal_length(camera.fx, 1, width, height);
    return camera.fx == camera.fy && camera.cx == paper.cx && camera.cy == paper.cy;
}

std::array<double PropertyRange::*, 2> ends() {
    return {&PropertyRange::min, &PropertyRange::max};
}

/// The numbers that nodes have of a clip, whose camera is this one.
std::vector<double> numbers_of(const ClipNodes& nodes, const Camera& camera) {
    std::vector<double> all{camera.fx, nodes.near, nodes.far, nodes.max_height};
    for (const PropertyRange* range :
         {&nodes.ranges.stiffness, &nodes.ranges.static_friction, &nodes.ranges.dynamic_friction})
        for (const auto end : ends()) all.push_back(range->*end);
    return all;
}

bool is_same(double a, double b) {
    constexpr double rounding = 1e-6;  // of numbers of four bytes, one of them of two
    return std::fabs(a - b) <= rounding * std::fmax(std::fabs(a), std::fabs(b));
}

/// Half of the picture is seen under half of the angle.
double focal_length_in_pixels(double angle, int pixels) {
    return pixels / 2.0 * cosine(angle / 2) / sine(angle / 2);
}

/// Of a picture of depth, which has 8 or 16.
int picture_bits(const Scene& scene) {
    return scene.depth_bits > 8 ? 16 : 8;
}

Result<Camera> camera_of(const ClipNodes& nodes, int width, int height) {
    if (nodes.focal_length > 0 && nodes.pixel_width > 0)
        return camera_from_focal_length(nodes.focal_length, nodes.pixel_width, width, height);
    if (nodes.focal_length != 0 || nodes.pixel_width != 0)
        return input_error("Depth: focalLength and pixelWidth must be above 0");
    for (const double angle : {nodes.angle_x, nodes.angle_y})
        if (!(angle > 0) || !(angle < pi))
            return input_error("DepthImage: fieldOfView must be between 0 and pi");
    return Camera{focal_length_in_pixels(nodes.angle_x, width), focal_length_in_pixels(nodes.angle_y, height),
                  (width - 1) / 2.0, (height - 1) / 2.0};
}

}  // namespace

ClipNodes nodes_from(const Scene& scene, StreamsBeside streams) {
    ClipNodes nodes;
    const auto stream = [](std::uint16_t object) { return PlaneTexture{{.object = object}, true}; };
    nodes.depth = stream(depth_object);
    if (streams.colour) nodes.colour = stream(colour_object);
    if (streams.haptic) nodes.haptic = stream(haptic_object);
    if (streams.height) nodes.height = stream(height_object);
    nodes.pixel_width = pixel_width;
    nodes.focal_length = scene.camera.fx * pixel_width;
    nodes.near = scene.depth.near;
    nodes.far = scene.depth.far;
    nodes.ranges = scene.haptic;
    const HeightCoding& height = scene.height_coding;
    nodes.max_height =
        height.units == HeightUnits::levels ? height.max_height : height.max_height / scene.depth.level();
    return nodes;
}

std::vector<std::string> unsaid_by_nodes(const Scene& scene, StreamsBeside streams, Textures textures) {
    std::vector<std::string> unsaid;
    const auto say = [&](bool is_so, std::string what) {
        if (is_so) unsaid.push_back(std::move(what));
    };
    const DepthCoding& depth = scene.depth;
    say(depth.kind != DepthCodingKind::linear || !depth.near_is_high,
        "depth that is not linear from far (black) to near (white)");
    const bool are_tracks = textures == Textures::tracks;
    const int bits = are_tracks ? scene.depth_bits : picture_bits(scene);
    say(depth.kind == DepthCodingKind::linear && depth.code_max != (1U << bits) - 1,
        "a white of depth that is not the largest number of its " + std::to_string(bits) + " bits");
    say(depth.semantics != DepthSemantics::range,
        "depth along the camera's axis instead of each pixel's ray");
    say(depth.invalid_code_count > 0, "values of depth that are holes");
    const bool is_high = scene.height_coding.code_max > 255;
    say(are_tracks && (scene.depth_bits > 8 || is_high),
        "bits of depth and height below the high 8, which are tracks of their own");
    say(!are_tracks && is_high, "height of more than 8 bits");
    say(scene.metres_per_unit != Scene().metres_per_unit, "lengths that are not millimetres");
    say(!is_in_the_middle(scene.camera, scene.width, scene.height),
        "a camera whose pixels are not square, or whose axis is not in the picture's middle");
    say(are_tracks && scene.rate.own_times != nullptr, "frames at times of their own");
    say(scene.lens.any(), "a lens that bends what it shows");
    say(scene.colour_camera.has_value(), "a camera of colour");
    say(scene.interpolation != FrameInterpolation::linear, "frames that stay as they are until the next one");
    say(scene.device_metres_per_unit.has_value(), "the size of the workspace");
    say(!(scene.filter == FilterSettings()), "filters");
    say(scene.hole_stiffness.has_value(), "the stiffness of holes");
    const HapticProperties &felt = scene.default_properties, usual;
    say(!streams.haptic &&
            (felt.stiffness != usual.stiffness || felt.static_friction != usual.static_friction ||
             felt.dynamic_friction != usual.dynamic_friction),
        "how it feels, as it has no haptic picture");
    return unsaid;
}

Result<SceneDescription> described_by(const ClipNodes& nodes, int width, int height, int bits) {
    TRY_ASSIGN(const auto camera, camera_of(nodes, width, height));
    SceneDescription described;
    Scene& scene = described.scene;
    scene.width = width;
    scene.height = height;
    scene.camera = camera;
    scene.depth.near = nodes.near;
    scene.depth.far = nodes.far;
    scene.depth.code_max = static_cast<std::uint16_t>((1U << bits) - 1);
    scene.depth_bits = bits;
    derive_valid_range(scene.depth);
    scene.haptic = nodes.ranges;
    scene.height_coding = {nodes.max_height, HeightUnits::levels, 255};
    described.unstated = {.rate = true, .filters = all_unstated};
    TRY(validate(described));
    return described;
}

ClipNodes nodes_of_pictures(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const FolderSource& files = *scene.folder;
    const auto picture = [](const std::string& file) {
        return file.empty() ? std::nullopt : std::optional(PlaneTexture{{.file = file}, false});
    };
    ClipNodes nodes = nodes_from(scene);
    nodes.depth = *picture(files.depth);
    nodes.colour = picture(files.colour);
    nodes.haptic = picture(files.haptic);
    nodes.height = picture(files.height);
    const auto as_text = [&](SceneDescription said) {
        said.scene.folder.reset();
        said.scene.video.reset();
        said.scene.name = scene.name;
        said.scene.rate = {};
        said.unstated.rate = true;
        return scene_to_json(said);
    };
    const SceneTree tree = scene_of(nodes, scene.width, scene.height);
    const auto read = clip_nodes_of(tree);
    const auto alone = read ? described_by(*read, scene.width, scene.height, picture_bits(scene))
                            : Result<SceneDescription>(read.error());
    std::string whole = as_text(described);
    while (whole.ends_with('\n')) whole.pop_back();
    if (!alone || as_text(*alone) != as_text(described)) nodes.scene_file = std::move(whole);
    return nodes;
}

Result<SceneDescription> described_by_pictures(const ClipNodes& nodes, int width, int height, int bits,
                                               std::vector<std::string>& notes) {
    if (nodes.scene_file.empty()) return described_by(nodes, width, height, bits);
    const std::string node = std::string("its WorldInfo ") + ClipNodes::scene_file_title;
    auto described = parse_scene(nodes.scene_file, node);
    if (!described) return described;
    described->scene.folder.reset();  // the nodes name the pictures
    described->scene.video.reset();
    TRY_ASSIGN(const auto is_other, take_nodes(nodes, described->scene));
    if (!is_other) return described;
    notes.push_back("its nodes say another camera, other planes or ranges than " + node +
                    ": the nodes stand");
    TRY(validate(*described));
    return described;
}

Result<bool> take_nodes(const ClipNodes& nodes, Scene& scene) {
    TRY_ASSIGN(const auto camera, camera_of(nodes, scene.width, scene.height));
    const ClipNodes before = nodes_from(scene);
    ClipNodes now = nodes;
    if (nodes.focal_length == 0) {  // a DepthImage, which says nothing of touch
        now.ranges = before.ranges;
        now.max_height = before.max_height;
    }
    const auto said = numbers_of(now, camera), known = numbers_of(before, scene.camera);
    bool is_other = false;
    for (std::size_t k = 0; k < said.size(); ++k) is_other = is_other || !is_same(said[k], known[k]);
    if (!is_other) return false;
    scene.camera.fy *= camera.fx / scene.camera.fx;
    scene.camera.fx = camera.fx;
    scene.depth.near = now.near;
    scene.depth.far = now.far;
    derive_valid_range(scene.depth);
    scene.haptic = now.ranges;
    HeightCoding& height = scene.height_coding;
    height.max_height = now.max_height * (height.units == HeightUnits::levels ? 1 : scene.depth.level());
    return true;
}

}  // namespace touchable::mpeg4
