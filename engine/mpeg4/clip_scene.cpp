// SPDX-License-Identifier: Apache-2.0
#include "engine/mpeg4/clip_scene.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable::mpeg4 {

namespace {

/// A node, with the prototypes of its scene.
class NodeView {
public:
    NodeView(const SceneTree& scene, const Node& node) : scene_(scene), node_(node) {}

    bool is(std::string_view type) const { return node_.type == type; }
    Error wrong(const std::string& what) const { return input_error(printable(node_.type) + ": " + what); }

    /// Values of a field by its name, the initial ones if it is not given; null: no such field.
    const std::vector<FieldValue>* values(std::string_view name) const {
        if (const Field* given = node_.field(name)) return &given->values;
        const auto* const specs = fields_of(scene_.prototypes, node_.type);
        const FieldSpec* const spec = specs ? field_named(*specs, name) : nullptr;
        return spec ? &spec->initial : nullptr;
    }
    template <class T>
    Result<T> value(const char* name) const {
        const auto* all = values(name);
        if (!all || all->size() != 1 || !std::holds_alternative<T>(all->front()))
            return wrong("must have a field " + std::string(name) + " of the paper's type");
        return std::get<T>(all->front());
    }
    /// The node of a field; nullopt: none.
    Result<std::optional<NodeView>> node(const char* name) const {
        TRY_ASSIGN(auto found, value<NodePtr>(name));
        if (!found) return std::optional<NodeView>();
        return std::optional(NodeView(scene_, *found));
    }
    Result<double> number(const char* name) const {
        TRY_ASSIGN(const auto number, value<float>(name));
        return decimal_of(number);
    }
    Result<PropertyRange> range(const char* name) const {
        TRY_ASSIGN(const auto ends, value<std::array<float, 2>>(name));
        return PropertyRange{decimal_of(ends[0]), decimal_of(ends[1])};
    }
    Result<std::optional<ClipNodes::Texture>> texture(const char* name) const {
        TRY_ASSIGN(const auto found, node(name));
        if (!found) return std::optional<ClipNodes::Texture>();
        const NodeView& there = *found;
        if (!there.is("ImageTexture") && !there.is("MovieTexture"))
            return wrong(std::string(name) + " is a " + printable(there.node_.type) +
                         ": must be an ImageTexture or a MovieTexture");
        const auto* urls = there.values("url");
        if (!urls || urls->size() != 1)
            return wrong(std::string(name) + " has " + std::to_string(urls ? urls->size() : 0) +
                         " urls: must be one");
        const Url* const url = std::get_if<Url>(&urls->front());
        if (!url) return wrong(std::string(name) + " is a PROTO whose url is none");
        return std::optional(ClipNodes::Texture{*url, there.is("MovieTexture")});
    }

private:
    const SceneTree& scene_;
    const Node& node_;
};

bool is_group(const Node& node) {
    return node.type == "Group" || node.type == "OrderedGroup";
}

/// The scene file that touchable wrote beside the Shape, a line each; empty if no WorldInfo is its own.
std::string scene_file_in(const SceneTree& scene) {
    const Field* children = is_group(*scene.root) ? scene.root->field("children") : nullptr;
    for (const FieldValue& each : children ? children->values : std::vector<FieldValue>()) {
        const NodePtr* const child = std::get_if<NodePtr>(&each);
        if (!child || !*child || (*child)->type != "WorldInfo") continue;
        const NodeView world(scene, **child);
        const auto title = world.value<std::string>("title");
        const auto* const info = world.values("info");
        if (!title || *title != ClipNodes::scene_file_title || !info) continue;
        std::string text;
        for (const FieldValue& line : *info) {
            if (!std::holds_alternative<std::string>(line)) return {};
            if (&line != &info->front()) text += '\n';
            text += std::get<std::string>(line);
        }
        return text;
    }
    return {};
}

/// The node with this scene file.
NodePtr scene_file_node(const std::string& text) {
    Field info{"info", {}};
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        info.values.emplace_back(text.substr(at, end - at));
        at = end + 1;
    }
    return std::make_shared<Node>(
        Node{.type = "WorldInfo",
             .fields = {std::move(info), {"title", {std::string(ClipNodes::scene_file_title)}}}});
}

/// The only Shape of a scene, or DepthImage; WorldInfo may stand beside it.
Result<NodeView> only_shape(const SceneTree& scene) {
    const Node& root = *scene.root;
    if (!is_group(root)) return NodeView(scene, root);
    const std::string& name = root.type;
    const Node* shape = nullptr;
    const Field* children = root.field("children");
    for (const FieldValue& each : children ? children->values : std::vector<FieldValue>()) {
        const NodePtr* const held = std::get_if<NodePtr>(&each);
        if (!held) return input_error(name + ": is a PROTO whose children are no nodes");
        const NodePtr& child = *held;
        if (!child || child->type == "WorldInfo") continue;
        if (shape)
            return input_error(name + ": has a " + printable(shape->type) + " and a " +
                               printable(child->type) + ": a touchable clip is one Shape");
        shape = child.get();
    }
    if (!shape) return input_error(name + ": has no Shape");
    if (is_group(*shape))
        return input_error(shape->type + ": stands in a group: the root must have the Shape itself");
    return NodeView(scene, *shape);
}

Result<void> read_depth(const NodeView& depth, ClipNodes& made) {
    for (const auto& [name, member] : {std::pair{"focalLength", &made.focal_length},
                                       {"pixelWidth", &made.pixel_width},
                                       {"nearPlane", &made.near},
                                       {"farPlane", &made.far}})
        TRY(assign(*member, depth.number(name)));
    TRY_ASSIGN(const auto texture, depth.texture("texture"));
    if (!texture) return depth.wrong("must have a texture, which is its pictures");
    made.depth = *texture;
    return {};
}

Result<void> read_surface(const NodeView& surface, ClipNodes& made) {
    if (!surface.is("HapticTextureSurface"))
        return surface.wrong("must be a HapticTextureSurface to be felt");
    for (const auto& [name, member] : {std::pair{"stiffnessRange", &made.ranges.stiffness},
                                       {"staticFrictionRange", &made.ranges.static_friction},
                                       {"dynamicFrictionRange", &made.ranges.dynamic_friction}})
        TRY(assign(*member, surface.range(name)));
    TRY_ASSIGN(made.max_height, surface.number("maxHeight"));
    for (const auto& [name, member] :
         {std::pair{"hapticTexture", &made.haptic}, {"heightTexture", &made.height}})
        TRY(assign(*member, surface.texture(name)));
    return {};
}

/// nullopt if the node has no such field, or it is NULL.
Result<std::optional<NodeView>> haptic_surface_of(const NodeView& node) {
    return node.values("hapticSurface") ? node.node("hapticSurface")
                                        : Result<std::optional<NodeView>>(std::nullopt);
}

Result<void> read_shape(const NodeView& shape, ClipNodes& made) {
    TRY_ASSIGN(const auto geometry, shape.node("geometry"));
    TRY_ASSIGN(const auto appearance, shape.node("appearance"));
    if (!geometry || !geometry->is("Depth")) return shape.wrong("its geometry must be a Depth");
    TRY(read_depth(*geometry, made));
    TRY_ASSIGN(auto surface, haptic_surface_of(*geometry));
    if (appearance) {
        TRY_ASSIGN(made.colour, appearance->texture("texture"));
        TRY_ASSIGN(auto papers, haptic_surface_of(*appearance));
        if (surface && papers)
            return shape.wrong("has a hapticSurface in its geometry and in its appearance: must be one");
        if (papers) surface.emplace(*papers);
    }
    return surface ? read_surface(*surface, made) : Result<void>();
}

/// MPEG-4's own node, of version 5.
Result<ClipNodes> from_depth_image(const NodeView& image) {
    ClipNodes made;
    TRY_ASSIGN(const auto textures, image.node("diTexture"));
    const auto angles = image.value<std::array<float, 2>>("fieldOfView");
    const auto near = image.number("nearPlane"), far = image.number("farPlane");
    const auto flat = image.value<bool>("orthographic");
    if (!textures || !textures->is("SimpleTexture"))
        return image.wrong("its diTexture must be a SimpleTexture");
    if (!angles || !near || !far || !flat) return image.wrong("its camera is damaged");
    if (*flat) return image.wrong("is orthographic: must have a perspective camera (orthographic FALSE)");
    made.angle_x = decimal_of((*angles)[0]);
    made.angle_y = decimal_of((*angles)[1]);
    made.near = *near;
    made.far = *far;
    TRY_ASSIGN(auto depth, textures->texture("depth"));
    TRY_ASSIGN(made.colour, textures->texture("texture"));
    if (!depth) return image.wrong("must have pictures of depth");
    made.depth = std::move(*depth);
    return made;
}

NodePtr texture_node(const std::optional<ClipNodes::Texture>& texture) {
    if (!texture) return {};
    Node made{.type = texture->is_movie ? "MovieTexture" : "ImageTexture"};
    if (texture->is_movie) made.fields.push_back({"loop", {true}});
    made.fields.push_back({"url", {texture->url}});
    return std::make_shared<Node>(std::move(made));
}

FieldValue real(double value) {
    return static_cast<float>(value);
}
FieldValue pair_of(const PropertyRange& range) {
    return std::array{static_cast<float>(range.min), static_cast<float>(range.max)};
}

/// The paper's node as a prototype: with its fields, all of which may change, and its initial values.
Prototype prototype_of(const char* type, NodePtr body) {
    Prototype made{.name = type, .fields = node_type(type)->fields, .body = {std::move(body)}};
    for (FieldSpec& field : made.fields) {
        field.event = FieldEvent::exposed;
        field.slot = NodeSlot::world;
    }
    return made;
}

std::vector<Prototype> clip_prototypes(int width, int height) {
    const std::array size{static_cast<float>(width), static_cast<float>(height)};
    const Node rectangle{.type = "Rectangle", .fields = {{"size", {size}}}};
    Prototype depth = prototype_of("Depth", std::make_shared<Node>(rectangle));
    depth.fields.push_back({"hapticSurface", {FieldType::node}, FieldEvent::exposed, {NodePtr()}});
    return {prototype_of("HapticTextureSurface", std::make_shared<Node>(Node{.type = "WorldInfo"})),
            std::move(depth)};
}

Result<ClipNodes> nodes_in(const SceneTree& scene) {
    TRY_ASSIGN(const auto shape, only_shape(scene));
    if (shape.is("DepthImage")) return from_depth_image(shape);
    if (!shape.is("Shape")) return shape.wrong("must be a Shape");
    ClipNodes made;
    made.scene_file = scene_file_in(scene);
    TRY(read_shape(shape, made));
    return made;
}

constexpr double pixel_width = 0.001;  // for a scene in pixels alone

bool is_in_the_middle(const Camera& camera, int width, int height) {
    const Camera paper = camera_from_focal_length(camera.fx, 1, width, height);
    return camera.fx == camera.fy && camera.cx == paper.cx && camera.cy == paper.cy;
}

/// The numbers that nodes state of a clip with this camera.
std::vector<double> numbers_of(const ClipNodes& nodes, const Camera& camera) {
    std::vector<double> all{camera.fx, nodes.near, nodes.far, nodes.max_height};
    for (const PropertyRange* range :
         {&nodes.ranges.stiffness, &nodes.ranges.static_friction, &nodes.ranges.dynamic_friction})
        all.insert(all.end(), {range->min, range->max});
    return all;
}

bool is_same(double a, double b) {
    constexpr double rounding = 1e-6;  // of numbers of four bytes; one is a quotient of two
    return std::fabs(a - b) <= rounding * std::fmax(std::fabs(a), std::fabs(b));
}

/// Half of the picture is seen under half of the angle.
double focal_length_in_pixels(double angle, int pixels) {
    return pixels / 2.0 * cosine(angle / 2) / sine(angle / 2);
}

/// Bits of a picture of depth: 8 or 16.
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

Result<ClipNodes> clip_nodes_of(const SceneTree& scene) {
    auto nodes = nodes_in(scene);
    if (nodes || scene.has_names || scene.prototypes.empty()) return nodes;
    return input_error(nodes.error().message +
                       " (the scene is encoded without names, so a PROTO is known by the types of its fields "
                       "alone; MP4Box -def writes names)");
}

SceneTree scene_of(const ClipNodes& nodes, int width, int height) {
    Node surface{.type = "HapticTextureSurface",
                 .fields = {{"stiffnessRange", {pair_of(nodes.ranges.stiffness)}},
                            {"staticFrictionRange", {pair_of(nodes.ranges.static_friction)}},
                            {"dynamicFrictionRange", {pair_of(nodes.ranges.dynamic_friction)}},
                            {"maxHeight", {real(nodes.max_height)}}}};
    if (nodes.haptic) surface.fields.push_back({"hapticTexture", {texture_node(nodes.haptic)}});
    if (nodes.height) surface.fields.push_back({"heightTexture", {texture_node(nodes.height)}});
    const Node depth{.type = "Depth",
                     .fields = {{"focalLength", {real(nodes.focal_length)}},
                                {"pixelWidth", {real(nodes.pixel_width)}},
                                {"nearPlane", {real(nodes.near)}},
                                {"farPlane", {real(nodes.far)}},
                                {"texture", {texture_node(nodes.depth)}},
                                {"hapticSurface", {std::make_shared<Node>(std::move(surface))}}}};
    Node shape{.type = "Shape"};
    if (nodes.colour)
        shape.fields.push_back(
            {"appearance",
             {std::make_shared<Node>(
                 Node{.type = "Appearance", .fields = {{"texture", {texture_node(nodes.colour)}}}})}});
    shape.fields.push_back({"geometry", {std::make_shared<Node>(depth)}});
    Node root{.type = "OrderedGroup", .fields = {{"children", {std::make_shared<Node>(shape)}}}};
    if (!nodes.scene_file.empty()) root.fields[0].values.emplace_back(scene_file_node(nodes.scene_file));
    return {clip_prototypes(width, height), std::make_shared<Node>(root)};
}

ClipNodes nodes_from(const Scene& scene, ClipNodes::Streams streams) {
    ClipNodes nodes;
    const auto stream = [](std::uint16_t object) { return ClipNodes::Texture{{.object = object}, true}; };
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

std::vector<std::string> unsaid_by_nodes(const Scene& scene, ClipNodes::Streams streams, Textures textures) {
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
    say(!streams.haptic && !(scene.default_properties == HapticProperties()),
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
        return file.empty() ? std::nullopt : std::optional(ClipNodes::Texture{{.file = file}, false});
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
    if (nodes.focal_length == 0) {  // a DepthImage, which states no touch
        now.ranges = before.ranges;
        now.max_height = before.max_height;
    }
    if (std::ranges::equal(numbers_of(now, camera), numbers_of(before, scene.camera), is_same)) return false;
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
