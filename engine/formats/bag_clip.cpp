// SPDX-License-Identifier: Apache-2.0
// Recordings of ROS as clips. Their topics are messages of connections (BagFile). One topic of pictures is
// depth, another may be its colour; cameras, poses and units are in topics beside them.

#include "engine/formats/formats_read.hpp"

#include <cmath>
#include <tuple>

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/ros_messages.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// A topic of pictures.
struct BagPictures {
    std::string topic;
    bool is_compressed = false;  ///< sensor_msgs/CompressedImage
    RosPictureKind kind = RosPictureKind::none;
    std::string encoding;              ///< or format, of the first message
    std::vector<BagMessage> messages;  ///< in the order in which they were recorded
};

/// Which of a recording's topics make a clip.
struct BagStreams {
    BagPictures depth;
    std::optional<BagPictures> colour;
    std::vector<std::string> others;  ///< topics that could be depth as well
};

constexpr std::size_t most_topics = 200;  // topics of pictures; the first message of each is read

bool is_of(const BagConnection& connection, const RosType& type) {
    return connection.type == type.name && connection.md5 == type.md5;
}

/// All messages of this type to a topic. Its writer may have been started twice.
Result<std::vector<BagMessage>> messages_of(BagFile& bag, const std::string& topic, const RosType& type) {
    std::vector<std::uint32_t> ids;
    for (const BagConnection& connection : bag.connections())
        if (connection.topic == topic && is_of(connection, type)) ids.push_back(connection.id);
    return ids.empty() ? std::vector<BagMessage>() : bag.messages(ids);
}

/// The first message of this type to a topic; nothing if there is none that can be read.
Result<std::optional<RosMessage>> first_message(BagFile& bag, const std::string& topic, const RosType& type) {
    TRY_ASSIGN(const auto messages, messages_of(bag, topic, type));
    return bag.read_first(messages);
}

/// All topics of pictures that have messages.
Result<std::vector<BagPictures>> topics_of_pictures(BagFile& bag) {
    std::vector<BagPictures> topics;
    std::size_t looked_at = 0;
    // Reading messages may add connections at the end.
    for (std::size_t n = 0; n < bag.connections().size(); ++n) {
        const BagConnection connection = bag.connections()[n];
        const bool is_compressed = is_of(connection, ros_compressed_image);
        if (!is_compressed && !is_of(connection, ros_image)) continue;
        if (std::ranges::any_of(topics, [&](const BagPictures& other) {
                return other.topic == connection.topic && other.is_compressed == is_compressed;
            }))
            continue;
        if (++looked_at > most_topics) break;
        BagPictures pictures{connection.topic, is_compressed, RosPictureKind::none, "", {}};
        TRY_ASSIGN(pictures.messages,
                   messages_of(bag, pictures.topic, is_compressed ? ros_compressed_image : ros_image));
        TRY_ASSIGN(const auto bytes, bag.read_first(pictures.messages));
        if (!bytes) continue;
        if (!is_compressed) {
            if (const auto image = parse_ros_image(*bytes)) {
                pictures.encoding = image->encoding;
                pictures.kind = ros_picture_kind(image->encoding);
            }
        } else if (const auto image = parse_ros_compressed_image(*bytes)) {
            pictures.encoding = image->format;
            pictures.kind = ros_compressed_kind(image->format);
            if (pictures.kind == RosPictureKind::colour && has_word(pictures.topic, {"depth"}) &&
                image->format.find("png") != std::string_view::npos)
                pictures.kind = RosPictureKind::depth16;
        }
        topics.push_back(std::move(pictures));
    }
    return topics;
}

/// Whether a topic's name says that its depth has colour's pixels.
bool is_registered_topic(const std::string& pictures) {
    return has_word(pictures, {"aligned", "registered"});
}

/// How likely a topic is depth; 0: not at all.
int depth_mark_of_topic(const BagPictures& pictures) {
    if (pictures.kind != RosPictureKind::depth16 && pictures.kind != RosPictureKind::depth_floats) return 0;
    const std::string& name = pictures.topic;
    if (has_word(name, {"infra", "/ir", "confidence", "fisheye", "thermal", "dispar"})) return 0;
    const bool is_named = has_word(name, {"depth"});
    if (!is_named && pictures.encoding != "16UC1" && pictures.encoding != "32FC1") return 0;
    return 1 + (is_named ? 16 : 0) + (is_registered_topic(name) ? 8 : 0) +
           (has_word(name, {"rect"}) ? 4 : 0) + (pictures.is_compressed ? 0 : 2);
}

/// How many names between slashes two topics have in common, from the beginning.
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
    const std::string words = listed(
        std::span(topics).first(std::min<std::size_t>(topics.size(), 4)),
        [](const BagPictures& each) { return printable(each.topic) + " of " + printable(each.encoding); });
    return words.empty() ? "no pictures" : words + (topics.size() > 4 ? ", ..." : "");
}

/// The pinhole camera of a topic of pictures, from the sensor_msgs/CameraInfo beside it. For rectified
/// pictures it is the camera that they are rectified to.
struct BagCamera {
    Intrinsics intrinsics;
    std::string topic;  ///< of the CameraInfo
    std::string frame;  ///< of coordinates (header.frame_id)
    /// Without distortion for rectified pictures and for an unknown kind of lens.
    LensDistortion lens;
    std::string unknown_lens;  ///< name of the unknown kind
};

/// Reads the lens, if its kind has the terms of LensDistortion.
void find_lens(const RosCameraInfo& info, BagCamera& camera) {
    const auto& terms = info.distortion;
    if (std::ranges::all_of(terms, [](double term) { return term == 0; })) return;
    constexpr std::string_view known[] = {"plumb_bob", "rational_polynomial", "Brown Conrady",
                                          "brown_conrady"};
    const bool is_known = std::ranges::count(known, info.distortion_model) > 0 &&
                          terms.size() <= camera.lens.terms.size() &&
                          std::ranges::all_of(terms, [](double term) { return std::isfinite(term); });
    if (is_known)
        std::ranges::copy(terms, camera.lens.terms.begin());
    else
        camera.unknown_lens = info.distortion_model;
}

/// The topic without ROS's suffix for the way in which pictures are packed.
std::string without_transport(std::string pictures) {
    for (const std::string transport : {"/compressedDepth", "/compressed"})
        if (pictures.ends_with(transport)) pictures.resize(pictures.size() - transport.size());
    return pictures;
}

/// The part of /device_0/sensor_0/Depth_0/image/data before /image/data; empty for other topics.
std::string realsense_stream(const std::string& pictures) {
    constexpr std::string_view end = "/image/data";
    return pictures.ends_with(end) ? pictures.substr(0, pictures.size() - end.size()) : "";
}

/// Topics that may have the pictures' CameraInfo, the likeliest first.
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

/// Chooses topics by names and encodings: depth that is registered to colour before other depth, raw before
/// compressed; colour of the same camera; infrared only if there is no colour. An error lists the topics.
Result<BagStreams> choose_bag_streams(BagFile& bag) {
    TRY_ASSIGN(auto topics, topics_of_pictures(bag));
    const auto best = [&](auto&& mark) {
        const auto chosen = std::ranges::max_element(topics, {}, mark);
        return chosen != topics.end() && mark(*chosen) > 0 ? &*chosen : nullptr;
    };
    BagPictures* const depth = best(depth_mark_of_topic);
    if (depth == nullptr)
        return input_error(bag.name() + ": has no topic of depth (there are " + found_there(topics) +
                           "): must have sensor_msgs/Image of encoding 16UC1, mono16 or 32FC1, or a "
                           "CompressedImage of such" +
                           (bag.left_out().empty() ? "" : "; " + bag.left_out()));
    BagStreams streams;
    for (const BagPictures& each : topics)
        if (&each != depth && depth_mark_of_topic(each) > 0) streams.others.push_back(each.topic);
    BagPictures* const colour = best([&](const BagPictures& each) { return colour_mark(each, *depth); });
    if (colour != nullptr) streams.colour = std::move(*colour);
    streams.depth = std::move(*depth);
    return streams;
}

/// The camera of a topic of pictures; nothing if no CameraInfo is beside them.
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
        if (!(camera.intrinsics.fx > 0) || !(camera.intrinsics.fy > 0)) continue;  // it was not calibrated
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

/// The pose of the camera of a RealSense's pictures, from the recording's reference, metres; nothing if it is
/// not stated.
Result<std::optional<CameraPose>> bag_pose(BagFile& bag, const std::string& pictures) {
    const std::string stream = realsense_stream(pictures);
    if (stream.empty()) return std::optional<CameraPose>();
    TRY_ASSIGN(const auto bytes, first_message(bag, stream + "/tf/0", ros_transform));
    if (!bytes) return std::optional<CameraPose>();
    const auto transform = parse_ros_transform(*bytes);
    if (!transform) return input_error(bag.name() + ": is damaged: " + printable(stream) + "/tf/0 is cut");
    auto [x, y, z, w] = transform->rotation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(length > 0.5 && length < 2)) return std::optional<CameraPose>();  // it was not measured
    for (double* term : {&x, &y, &z, &w}) *term /= length;
    CameraPose pose;
    pose.translation = transform->translation;
    pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                     2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                     2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    return std::optional(pose);
}

/// Metres of a stored 1, if a RealSense states it: /device_0/sensor_0/option/Depth Units/value.
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

struct Stamped {
    std::int64_t taken_ns;
    BagMessage message;
};

/// Reads the stamps of all messages, in the file's order, so that each chunk is unpacked once. Messages in
/// chunks that were given up are left out.
Result<std::vector<Stamped>> with_stamps(BagFile& bag, std::vector<BagMessage> messages) {
    std::ranges::sort(messages, {}, [](const BagMessage& each) { return std::tie(each.chunk, each.offset); });
    std::vector<Stamped> stamped;
    for (const BagMessage& message : messages) {
        if (stop_requested()) return interrupted_error();
        const auto begin = bag.read(message, ros_stamp_bytes);
        if (!begin && bag.is_given_up(message)) continue;
        if (!begin) return begin.error();
        stamped.push_back({ros_stamp(*begin).value_or(0), message});
    }
    return stamped;
}

/// Whether both have stamps by one clock.
bool tell_times(const std::vector<Stamped>& depth, const std::vector<Stamped>& colour) {
    const auto ends = [](const std::vector<Stamped>& all) {
        const auto [first, last] = std::ranges::minmax_element(all, {}, &Stamped::taken_ns);
        return std::pair(first->taken_ns, last->taken_ns);
    };
    const auto [first, last] = ends(depth);
    if (first <= 0 || (depth.size() > 1 && first == last)) return false;
    if (colour.empty()) return true;
    constexpr std::int64_t second = 1'000'000'000;
    const auto [begin, end] = ends(colour);
    return begin > 0 && begin <= last + second && first <= end + second;
}

/// Reads a recording's depth, and the colour that goes with it.
class BagRecording final : public FrameSource {
public:
    static Result<std::shared_ptr<BagRecording>> open(const SourceFile& file) {
        auto recording = std::make_shared<BagRecording>();
        TRY_ASSIGN(recording->bag_, BagFile::open(file));
        TRY_ASSIGN(recording->streams_, choose_bag_streams(*recording->bag_));
        TRY(recording->put_in_order());
        return recording;
    }

    BagFile& bag() { return *bag_; }
    const BagStreams& streams() const { return streams_; }
    std::int64_t count() const { return static_cast<std::int64_t>(streams_.depth.messages.size()); }
    bool has_colour() const { return streams_.colour.has_value(); }
    /// Times of the depth pictures, seconds, in order: from their headers, or, if the headers of depth and
    /// colour cannot be used, the times of recording.
    const std::vector<double>& times() const { return times_; }
    /// Decodes a frame's picture; for colour, the one nearest in time.
    Result<StoredImage> stored(PlaneRole role, std::int64_t frame) {
        const BagPictures& from = pictures(role);
        TRY_ASSIGN(const auto bytes,
                   bag_->read(from.messages[static_cast<std::size_t>(picture_number(role, frame))]));
        const std::string at = where(role, frame);
        const auto picture = [&](const auto& image) {
            return image ? ros_picture(*image, at) : input_error(at + ": is damaged: is cut");
        };
        return from.is_compressed ? picture(parse_ros_compressed_image(bytes))
                                  : picture(parse_ros_image(bytes));
    }

    /// "my.bag: /camera/depth/image_raw, frame 7".
    std::string where(PlaneRole role, std::int64_t frame) const override {
        return bag_->name() + ": " + printable(pictures(role).topic) + ", frame " + std::to_string(frame);
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        TRY_ASSIGN(auto image, stored(role, frame));
        return TrackPicture{std::move(image)};
    }
    /// For colour, the index among colour's pictures.
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return role == PlaneRole::depth
                   ? frame
                   : static_cast<std::int64_t>(colours_[static_cast<std::size_t>(frame)]);
    }

private:
    Result<void> put_in_order() {
        std::vector<BagMessage> all = streams_.depth.messages;
        if (has_colour())
            all.insert(all.end(), streams_.colour->messages.begin(), streams_.colour->messages.end());
        TRY_ASSIGN(auto stamped, with_stamps(*bag_, std::move(all)));
        std::vector<std::uint32_t> depth_ids;
        for (const BagMessage& message : streams_.depth.messages) depth_ids.push_back(message.connection);
        std::ranges::sort(depth_ids);
        std::vector<Stamped> depth, colour;
        depth.reserve(streams_.depth.messages.size());
        for (const Stamped& each : stamped)
            (std::ranges::binary_search(depth_ids, each.message.connection) ? depth : colour).push_back(each);
        if (depth.empty()) return input_error(bag_->name() + ": " + bag_->left_out());
        if (colour.empty()) streams_.colour.reset();
        const bool by_stamp = tell_times(depth, colour);
        const auto order = [&](std::vector<Stamped>& pictures, std::vector<BagMessage>& messages) {
            const auto time = [&](const Stamped& each) {
                return by_stamp ? each.taken_ns : each.message.time_ns;
            };
            std::ranges::stable_sort(pictures, {}, time);
            std::vector<double> times;
            messages.clear();
            for (const Stamped& each : pictures) {
                times.push_back(1e-9 * static_cast<double>(time(each)));
                messages.push_back(each.message);
            }
            return times;
        };
        times_ = order(depth, streams_.depth.messages);
        if (!has_colour()) return {};
        const std::vector<double> colour_times = order(colour, streams_.colour->messages);
        for (const double time : times_) colours_.push_back(nearest_key(colour_times, time));
        return {};
    }

    const BagPictures& pictures(PlaneRole role) const {
        return role == PlaneRole::depth ? streams_.depth : *streams_.colour;
    }

    std::unique_ptr<BagFile> bag_;
    BagStreams streams_;
    std::vector<double> times_;
    std::vector<std::size_t> colours_;  // colour's index for each depth
};

/// Completes what a person stated with what the recording says.
Result<SourceDescription> completed(BagRecording& recording, SourceDescription known,
                                    std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    const SourceDescription::Preset* const preset = preset_named(known.preset);
    TRY_ASSIGN(auto camera, bag_camera(recording.bag(), streams.depth.topic));
    if (!known.intrinsics && !known.fov && camera && !(preset && preset->intrinsics.fx > 0)) {
        known.intrinsics = camera->intrinsics;
        add_remark(remarks, {"the camera is that of " + printable(camera->topic)});
    }
    if (known.metres_per_code || !known.preset.empty()) return known;
    TRY_ASSIGN(const auto unit, bag_depth_unit(recording.bag(), streams.depth.topic));
    if (unit) {
        known.metres_per_code = unit;
        add_remark(remarks,
                   {"a code is " + short_number(1000 * *unit) + " mm, as the camera's Depth Units say"});
    }
    return known;
}

/// Sets depth's lens and colour's camera as far as the recording states them.
Result<void> add_cameras(BagRecording& recording, Scene& scene, std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    TRY_ASSIGN(const auto depth, bag_camera(recording.bag(), streams.depth.topic));
    if (depth) {
        scene.lens = depth->lens;
        if (!depth->unknown_lens.empty())
            add_remark(remarks, {"the lens of depth bends (" + printable(depth->unknown_lens) +
                                 "), which is not undone"});
    }
    if (!streams.colour || is_registered_topic(streams.depth.topic)) return {};
    TRY_ASSIGN(const auto colour, bag_camera(recording.bag(), streams.colour->topic));
    if (!depth || !colour) return {};
    TRY_ASSIGN(const auto depth_pose, bag_pose(recording.bag(), streams.depth.topic));
    TRY_ASSIGN(const auto colour_pose, bag_pose(recording.bag(), streams.colour->topic));
    if (!depth_pose || !colour_pose) {
        const bool same_frame = !depth->frame.empty() && depth->frame == colour->frame;
        if (!same_frame && !(depth->intrinsics == colour->intrinsics))
            add_remark(remarks, {"colour is not brought onto depth's pixels, as the recording does not say "
                                 "how its cameras stand (a scene file's colour_camera says it)"});
        return {};
    }
    TRY_ASSIGN(const auto first, recording.stored(PlaneRole::colour, 0));
    ColourCamera& camera = scene.colour_camera.emplace();
    camera.width = first.image.width;
    camera.height = first.image.height;
    camera.camera = scaled_camera(colour->intrinsics, camera.width, camera.height);
    camera.lens = colour->lens;
    camera.from_depth = colour_pose->after(depth_pose->inverse());
    return {};
}

void say_streams(BagRecording& recording, std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    add_remark(remarks, {"depth is " + printable(streams.depth.topic) +
                         (streams.colour ? ", colour is " + printable(streams.colour->topic)
                                         : std::string(", there is no colour"))});
    for (const std::string& other : streams.others)
        add_remark(remarks, {printable(other) + " is depth as well, and is left out"});
    if (const std::string left_out = recording.bag().left_out(); !left_out.empty())
        add_remark(remarks, {left_out});
}

}  // namespace

Result<GuessedScene> guess_bag(const SourceFile& file, const SourceDescription& known) {
    TRY_ASSIGN(const auto recording, BagRecording::open(file));
    std::vector<Remark> remarks;
    say_streams(*recording, remarks);
    TRY_ASSIGN(const auto said, completed(*recording, known, remarks));
    TRY_ASSIGN(const auto first, recording->stored(PlaneRole::depth, 0));
    // ROS defines floats as metres and integers as millimetres; drivers may write something else.
    const double usual_unit = recording->streams().depth.kind == RosPictureKind::depth_floats ? 1 : 0.001;
    TRY_ASSIGN(auto guessed, guess_scene(file.path(), first, said, nullptr, usual_unit));
    Scene& scene = guessed.scene;
    scene.video.emplace().depth = file.path().filename().string();
    TRY(add_cameras(*recording, scene, remarks));
    TRY(error_at(file.string() + ": its cameras are damaged", validate(scene)));
    const auto rate = rate_of_seconds(recording->times());
    if (rate) scene.rate = *rate;
    add_remark(remarks, {short_number(scene.rate.per_second()) + " frames a second" +
                             (scene.rate.own_times ? " on average, each at its own time"
                              : rate               ? ", by their times"
                                                   : ""),
                         !rate});
    scene.remarks = joined_remarks(std::move(remarks), scene.remarks);
    guessed.recording = recording;
    return guessed;
}

Opened open_bag_clip(const Candidate& file) {
    GuessedScene scene = *file.scene;
    auto recording = std::static_pointer_cast<BagRecording>(scene.recording);
    if (!recording) {
        TRY_ASSIGN(recording, BagRecording::open(file.source));
        say_streams(*recording, scene.scene.remarks);
    }
    StoredClip clip{recording->bag().name(), std::move(scene)};
    clip.count = recording->count();
    clip.roles = {PlaneRole::depth};
    if (recording->has_colour()) clip.roles.push_back(PlaneRole::colour);
    clip.found.rate = rate_of_seconds(recording->times());
    clip.inputs = {file.source.path()};
    clip.pictures = std::move(recording);
    return open_stored_clip(std::move(clip), file.wanted.colour);
}

Result<std::optional<fs::path>> ros2_recording_in(const fs::path& folder) {
    std::error_code failure;
    const fs::path metadata = folder / "metadata.yaml";
    constexpr std::size_t beginning = 4096;
    if (!fs::is_regular_file(metadata, failure) ||
        first_bytes(metadata, beginning).find("rosbag2_bagfile_information") == std::string::npos)
        return std::optional<fs::path>();
    constexpr std::size_t most_entries = 10'000;
    std::vector<fs::path> files, packed;
    std::size_t entries = 0;
    for (auto each = fs::directory_iterator(folder, failure);
         !failure && each != fs::end(each) && entries < most_entries; each.increment(failure), ++entries) {
        const fs::path& file = each->path();
        const fs::path plain = file.extension() == ".zstd" ? file.stem() : file;
        if (plain.extension() == ".db3" || plain.extension() == ".mcap")
            (file.extension() == ".zstd" ? packed : files).push_back(file);
    }
    std::ranges::sort(files);
    if (files.size() == 1) return std::optional(files.front());
    if (!files.empty())
        return input_error(folder.string() + ": is a recording of ROS 2 in " + std::to_string(files.size()) +
                           " files, each a clip of its own: touchable play " +
                           shell_word(files.front().string()));
    if (!packed.empty())
        return input_error(folder.string() +
                           ": is a recording of ROS 2 that is packed as a whole: unpack it first: zstd -d " +
                           shell_word(packed.front().string()));
    return input_error(
        folder.string() +
        ": has the metadata.yaml of a recording of ROS 2, but neither a .db3 nor an .mcap beside it");
}

}  // namespace touchable
