#include "engine/formats/bag_topics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/picture_groups.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_topics = 200;  // of pictures, of which the first is looked at

bool is_of(const BagConnection& connection, const RosType& type) {
    return connection.type == type.name && connection.md5 == type.md5;
}

/// The first message of a topic; nothing where it has none of that type.
Result<std::optional<std::string>> first_message(BagFile& bag, const std::string& topic,
                                                 const RosType& type) {
    std::vector<std::uint32_t> ids;
    for (const BagConnection& connection : bag.connections())
        if (connection.topic == topic && is_of(connection, type)) ids.push_back(connection.id);
    if (ids.empty()) return std::optional<std::string>();
    TRY_ASSIGN(const auto messages, bag.messages(ids));
    if (messages.empty()) return std::optional<std::string>();
    auto bytes = bag.read_first(messages);
    if (!bytes && bag.is_given_up(messages.front())) return std::optional<std::string>();
    if (!bytes) return bytes.error();
    return std::optional(std::move(*bytes));
}

/// All topics of pictures that have any.
Result<std::vector<BagPictures>> topics_of_pictures(BagFile& bag) {
    std::vector<BagPictures> topics;
    std::size_t looked_at = 0;
    // Reading messages may find further connections, behind these.
    for (std::size_t n = 0; n < bag.connections().size(); ++n) {
        const BagConnection connection = bag.connections()[n];
        const bool is_compressed = is_of(connection, ros_compressed_image);
        if (!is_compressed && !is_of(connection, ros_image)) continue;
        if (std::any_of(topics.begin(), topics.end(), [&](const BagPictures& other) {
                return other.topic == connection.topic && other.is_compressed == is_compressed;
            }))
            continue;
        if (++looked_at > most_topics) break;
        topics.push_back({connection.topic, is_compressed, RosPictureKind::none, "", {}});
        BagPictures& pictures = topics.back();
        std::vector<std::uint32_t> ids;  // who writes it may have been started twice
        for (const BagConnection& other : bag.connections())
            if (other.topic == pictures.topic && other.type == connection.type && other.md5 == connection.md5)
                ids.push_back(other.id);
        TRY_ASSIGN(auto messages, bag.messages(ids));
        pictures.messages = std::move(messages);
        if (pictures.messages.empty()) {
            topics.pop_back();
            continue;
        }
        const auto bytes = bag.read_first(pictures.messages);
        if (!bytes && bag.is_given_up(pictures.messages.front())) {
            topics.pop_back();
            continue;
        }
        if (!bytes) return bytes.error();
        if (is_compressed) {
            const auto image = parse_ros_compressed_image(*bytes);
            if (!image) continue;
            pictures.encoding = image->format;
            pictures.kind = ros_compressed_kind(image->format);
            if (pictures.kind == RosPictureKind::colour && has_word(pictures.topic, {"depth"}) &&
                image->format.find("png") != std::string_view::npos)
                pictures.kind = RosPictureKind::depth16;
        } else if (const auto image = parse_ros_image(*bytes)) {
            pictures.encoding = image->encoding;
            pictures.kind = ros_picture_kind(image->encoding);
        }
    }
    return topics;
}

/// How well a topic goes as depth; 0: not at all.
int depth_mark(const BagPictures& pictures) {
    if (pictures.kind != RosPictureKind::depth16 && pictures.kind != RosPictureKind::depth_floats) return 0;
    const std::string& name = pictures.topic;
    if (has_word(name, {"infra", "/ir", "confidence", "fisheye", "thermal", "dispar"})) return 0;
    const bool is_named = has_word(name, {"depth"});
    if (!is_named && pictures.encoding != "16UC1" && pictures.encoding != "32FC1") return 0;
    return 1 + (is_named ? 16 : 0) + (is_registered_topic(name) ? 8 : 0) +
           (has_word(name, {"rect"}) ? 4 : 0) + (pictures.is_compressed ? 0 : 2);
}

/// How much of their beginnings two topics have in common, in names between slashes.
int common_names(const std::string& a, const std::string& b) {
    const auto end = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
    return static_cast<int>(std::count(a.begin(), end, '/'));
}

int colour_mark(const BagPictures& pictures, const BagPictures& depth) {
    if (pictures.kind != RosPictureKind::colour && pictures.kind != RosPictureKind::grey8) return 0;
    const std::string& name = pictures.topic;
    if (has_word(name, {"depth", "confidence", "mask", "label", "fisheye", "segment", "theora"})) return 0;
    const bool is_dim = has_word(name, {"infra", "/ir"});
    return 1 + 16 * common_names(pictures.topic, depth.topic) +
           (has_word(name, {"rgb", "color", "colour"}) ? 512 : 0) +
           (pictures.kind == RosPictureKind::colour ? 256 : 0) + (is_dim ? 0 : 128) +
           (has_word(name, {"rect"}) ? 4 : 0) + (pictures.is_compressed ? 0 : 2);
}

std::string found_there(const std::vector<BagPictures>& topics) {
    std::string words;
    for (std::size_t n = 0; n < std::min<std::size_t>(topics.size(), 4); ++n)
        words += (n == 0 ? "" : ", ") + printable(topics[n].topic) + " of " + printable(topics[n].encoding);
    return words.empty() ? "no pictures" : words + (topics.size() > 4 ? ", ..." : "");
}

/// Of the kinds whose terms are those of LensDistortion.
void find_lens(const RosCameraInfo& info, BagCamera& camera) {
    const auto& terms = info.distortion;
    if (std::all_of(terms.begin(), terms.end(), [](double term) { return term == 0; })) return;
    constexpr std::string_view known[] = {"plumb_bob", "rational_polynomial", "Brown Conrady",
                                          "brown_conrady"};
    const bool is_known =
        std::find(std::begin(known), std::end(known), info.distortion_model) != std::end(known) &&
        terms.size() <= camera.lens.terms.size() &&
        std::all_of(terms.begin(), terms.end(), [](double term) { return std::isfinite(term); });
    if (is_known)
        std::copy(terms.begin(), terms.end(), camera.lens.terms.begin());
    else
        camera.unknown_lens = info.distortion_model;
}

/// Without what ROS adds for the way in which pictures are packed.
std::string without_transport(std::string pictures) {
    for (const std::string transport : {"/compressedDepth", "/compressed"})
        if (pictures.ends_with(transport)) pictures.resize(pictures.size() - transport.size());
    return pictures;
}

/// Of /device_0/sensor_0/Depth_0/image/data what is before /image/data; empty for others.
std::string realsense_stream(const std::string& pictures) {
    constexpr std::string_view end = "/image/data";
    return pictures.ends_with(end) ? pictures.substr(0, pictures.size() - end.size()) : "";
}

/// Where the CameraInfo of pictures may be, the likeliest first.
std::vector<std::string> camera_topics(const std::string& pictures) {
    std::vector<std::string> topics;
    if (const std::string stream = realsense_stream(pictures); !stream.empty())
        topics.push_back(stream + "/info/camera_info");
    const std::string plain = without_transport(pictures);
    if (const auto slash = plain.rfind('/'); slash != std::string::npos)
        topics.push_back(plain.substr(0, slash) + "/camera_info");
    topics.push_back(plain + "/camera_info");
    return topics;
}

}  // namespace

Result<BagStreams> choose_bag_streams(BagFile& bag) {
    TRY_ASSIGN(auto topics, topics_of_pictures(bag));
    const auto best = [&](auto&& mark) {
        BagPictures* chosen = nullptr;
        int most = 0;
        for (BagPictures& each : topics)
            if (const int its = mark(each); its > most) {
                most = its;
                chosen = &each;
            }
        return chosen;
    };
    BagPictures* const depth = best(depth_mark);
    if (depth == nullptr)
        return input_error(bag.name() + ": has no topic of depth (there are " + found_there(topics) +
                           "): must have sensor_msgs/Image of encoding 16UC1, mono16 or 32FC1, or a "
                           "CompressedImage of such" +
                           (bag.left_out().empty() ? "" : "; " + bag.left_out()));
    BagStreams streams;
    for (const BagPictures& each : topics)
        if (&each != depth && depth_mark(each) > 0) streams.others.push_back(each.topic);
    BagPictures* const colour = best([&](const BagPictures& each) { return colour_mark(each, *depth); });
    if (colour != nullptr) streams.colour = std::move(*colour);
    streams.depth = std::move(*depth);
    return streams;
}

Result<std::optional<BagCamera>> bag_camera(BagFile& bag, const std::string& pictures) {
    for (const std::string& topic : camera_topics(pictures)) {
        TRY_ASSIGN(const auto bytes, first_message(bag, topic, ros_camera_info));
        if (!bytes) continue;
        const auto info = parse_ros_camera_info(*bytes);
        if (!info)
            return input_error(bag.name() + ": is damaged: " + printable(topic) + " has a wrong length");
        const bool is_rectified = has_word(pictures, {"rect"}) && info->projection[0] > 0;
        const auto& k = info->matrix;
        const auto& p = info->projection;
        BagCamera camera;
        camera.intrinsics =
            is_rectified ? Intrinsics{p[0], p[5], p[2], p[6]} : Intrinsics{k[0], k[4], k[2], k[5]};
        if (!(camera.intrinsics.fx > 0) || !(camera.intrinsics.fy > 0)) continue;  // nobody calibrated it
        const auto& region = info->region;
        camera.intrinsics.width = static_cast<int>(
            std::min<std::uint32_t>(region.width > 0 ? region.width : info->width, largest_picture_side));
        camera.intrinsics.height = static_cast<int>(
            std::min<std::uint32_t>(region.height > 0 ? region.height : info->height, largest_picture_side));
        *camera.intrinsics.cx -= region.x;
        *camera.intrinsics.cy -= region.y;
        camera.topic = topic;
        camera.frame = info->header.frame;
        if (!is_rectified) find_lens(*info, camera);
        return std::optional(std::move(camera));
    }
    return std::optional<BagCamera>();
}

Result<std::optional<CameraPose>> bag_pose(BagFile& bag, const std::string& pictures) {
    const std::string stream = realsense_stream(pictures);
    if (stream.empty()) return std::optional<CameraPose>();
    TRY_ASSIGN(const auto bytes, first_message(bag, stream + "/tf/0", ros_transform));
    if (!bytes) return std::optional<CameraPose>();
    const auto transform = parse_ros_transform(*bytes);
    if (!transform) return input_error(bag.name() + ": is damaged: " + printable(stream) + "/tf/0 is cut");
    auto [x, y, z, w] = transform->rotation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(length > 0.5 && length < 2)) return std::optional<CameraPose>();  // nobody measured it
    for (double* term : {&x, &y, &z, &w}) *term /= length;
    CameraPose pose;
    pose.translation = transform->translation;
    pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                     2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                     2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    return std::optional(pose);
}

bool is_registered_topic(const std::string& pictures) {
    return has_word(pictures, {"aligned", "registered"});
}

/// Of the sensor that the pictures are of: /device_0/sensor_0/option/Depth Units/value.
Result<std::optional<double>> bag_depth_unit(BagFile& bag, const std::string& pictures) {
    const auto device = pictures.find('/', 1), sensor = pictures.find('/', device + 1);
    if (!pictures.starts_with("/device_") || device == std::string::npos || sensor == std::string::npos)
        return std::optional<double>();
    for (const char* option : {"/option/Depth Units/value", "/option/Depth_Units/value"}) {
        TRY_ASSIGN(const auto bytes, first_message(bag, pictures.substr(0, sensor) + option, ros_float));
        if (!bytes) continue;
        const auto unit = parse_ros_float(*bytes);
        if (unit && *unit > 0 && std::isfinite(*unit)) return std::optional(decimal_of(*unit));
    }
    return std::optional<double>();
}

}  // namespace touchable
