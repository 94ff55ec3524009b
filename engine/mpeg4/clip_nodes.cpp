#include "engine/mpeg4/clip_nodes.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/node_types.hpp"

namespace touchable::mpeg4 {
namespace {

/// A node with what its scene says of it.
class NodeView {
public:
    NodeView(const SceneTree& scene, const Node& node) : scene_(scene), node_(node) {}

    bool is(std::string_view type) const { return node_.type == type; }
    Error wrong(const std::string& what) const { return input_error(printable(node_.type) + ": " + what); }

    /// Of a field by its name, initial where it is not given; null where there is no such field.
    const std::vector<FieldValue>* values(std::string_view name) const {
        if (const Field* given = node_.field(name)) return &given->values;
        if (const auto* specs = fields_of(scene_.prototypes, node_.type))
            for (const FieldSpec& spec : *specs)
                if (spec.name == name) return &spec.initial;
        return nullptr;
    }
    template <class T>
    Result<T> value(const char* name) const {
        const auto* all = values(name);
        if (!all || all->size() != 1 || !std::holds_alternative<T>(all->front()))
            return wrong("must have a field " + std::string(name) + " of the paper's type");
        return std::get<T>(all->front());
    }
    /// The node of a field; nothing where there is none.
    Result<std::optional<NodeView>> node(const char* name) const {
        TRY_ASSIGN(auto found, value<NodePtr>(name));
        if (!found) return std::optional<NodeView>();
        return std::optional(NodeView(scene_, *found));
    }
    Result<double> number(const char* name) const {
        const auto found = value<float>(name);
        return found ? Result<double>(decimal_of(*found)) : Result<double>(found.error());
    }
    Result<PropertyRange> range(const char* name) const {
        const auto found = value<std::array<float, 2>>(name);
        if (!found) return found.error();
        return PropertyRange{decimal_of((*found)[0]), decimal_of((*found)[1])};
    }
    Result<std::optional<PlaneTexture>> texture(const char* name) const;

private:
    const SceneTree& scene_;
    const Node& node_;
};

Result<std::optional<PlaneTexture>> NodeView::texture(const char* name) const {
    TRY_ASSIGN(const auto found, node(name));
    if (!found) return std::optional<PlaneTexture>();
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
    return std::optional(PlaneTexture{*url, there.is("MovieTexture")});
}

/// Beside the Shape: what touchable wrote for itself, a line each; empty where it is a WorldInfo of others.
std::string scene_file_in(const SceneTree& scene) {
    const Field* children = scene.root->type == "Group" ? scene.root->field("children") : nullptr;
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

/// The same as a node.
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
    if (root.type != "Group") return NodeView(scene, root);
    const Node* shape = nullptr;
    const Field* children = root.field("children");
    for (const FieldValue& each : children ? children->values : std::vector<FieldValue>()) {
        const NodePtr* const held = std::get_if<NodePtr>(&each);
        if (!held) return input_error("Group: is a PROTO whose children are no nodes");
        const NodePtr& child = *held;
        if (!child || child->type == "WorldInfo") continue;
        if (shape)
            return input_error("Group: has a " + printable(shape->type) + " and a " + printable(child->type) +
                               ": a touchable clip is one Shape");
        shape = child.get();
    }
    if (!shape) return input_error("Group: has no Shape");
    return shape->type == "Group"
               ? Result<NodeView>(input_error("Group: stands in a Group: must have the Shape itself"))
               : NodeView(scene, *shape);
}

Result<void> read_depth(const NodeView& depth, ClipNodes& made) {
    for (const auto& [name, member] : {std::pair{"focalLength", &made.focal_length},
                                       {"pixelWidth", &made.pixel_width},
                                       {"nearPlane", &made.near},
                                       {"farPlane", &made.far}}) {
        TRY_ASSIGN(const auto number, depth.number(name));
        *member = number;
    }
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
                                       {"dynamicFrictionRange", &made.ranges.dynamic_friction}}) {
        TRY_ASSIGN(const auto range, surface.range(name));
        *member = range;
    }
    TRY_ASSIGN(const auto height, surface.number("maxHeight"));
    made.max_height = height;
    for (const auto& [name, member] :
         {std::pair{"hapticTexture", &made.haptic}, {"heightTexture", &made.height}}) {
        TRY_ASSIGN(auto texture, surface.texture(name));
        *member = std::move(texture);
    }
    return {};
}

/// Nothing where the node has no such field, or it is NULL.
Result<std::optional<NodeView>> haptic_surface_of(const NodeView& node) {
    return node.values("hapticSurface") ? node.node("hapticSurface")
                                        : Result<std::optional<NodeView>>(std::nullopt);
}

Result<void> read_shape(const NodeView& shape, ClipNodes& made) {
    const auto geometry = shape.node("geometry"), appearance = shape.node("appearance");
    if (!geometry) return geometry.error();
    if (!appearance) return appearance.error();
    if (!*geometry || !(*geometry)->is("Depth")) return shape.wrong("its geometry must be a Depth");
    if (auto read = read_depth(**geometry, made); !read) return read;
    TRY_ASSIGN(auto surface, haptic_surface_of(**geometry));
    if (*appearance) {
        TRY_ASSIGN(auto colour, (*appearance)->texture("texture"));
        made.colour = std::move(colour);
        TRY_ASSIGN(auto papers, haptic_surface_of(**appearance));
        if (surface && papers)
            return shape.wrong("has a hapticSurface in its geometry and in its appearance: must be one");
        if (papers) surface.emplace(*papers);
    }
    return surface ? read_surface(*surface, made) : Result<void>();
}

/// MPEG-4's own node, of version 5.
Result<ClipNodes> from_depth_image(const NodeView& image) {
    ClipNodes made;
    const auto textures = image.node("diTexture");
    const auto angles = image.value<std::array<float, 2>>("fieldOfView");
    const auto near = image.number("nearPlane"), far = image.number("farPlane");
    const auto flat = image.value<bool>("orthographic");
    if (!textures) return textures.error();
    if (!*textures || !(*textures)->is("SimpleTexture"))
        return image.wrong("its diTexture must be a SimpleTexture");
    if (!angles || !near || !far || !flat) return image.wrong("its camera is damaged");
    if (*flat) return image.wrong("is orthographic: must have a perspective camera (orthographic FALSE)");
    made.angle_x = decimal_of((*angles)[0]);
    made.angle_y = decimal_of((*angles)[1]);
    made.near = *near;
    made.far = *far;
    auto depth = (*textures)->texture("depth"), colour = (*textures)->texture("texture");
    if (!depth) return depth.error();
    if (!colour) return colour.error();
    if (!*depth) return image.wrong("must have pictures of depth");
    made.depth = std::move(**depth);
    made.colour = std::move(*colour);
    return made;
}

NodePtr texture_node(const std::optional<PlaneTexture>& texture) {
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
    Node root{.type = "Group", .fields = {{"children", {std::make_shared<Node>(shape)}}}};
    if (!nodes.scene_file.empty()) root.fields[0].values.emplace_back(scene_file_node(nodes.scene_file));
    return {clip_prototypes(width, height), std::make_shared<Node>(root)};
}

}  // namespace touchable::mpeg4
