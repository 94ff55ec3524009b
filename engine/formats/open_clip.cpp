// SPDX-License-Identifier: Apache-2.0
// How a path becomes a ClipReader: by these stages, in this file's order. No stage calls an earlier one.
//
//   find      what a path and a scene file lead to: a file, or a folder of pictures (Candidate). Scene files
//             and folders that hold one recording are followed to what they name; an archive of pictures is
//             unpacked and becomes a folder (ZipFolder).
//   probe     the first row of the table `formats` that recognises it; each probe is called once at most.
//   describe  the scene of files that do not say themselves what their depth is: a scene file's, fitted to
//             the file; otherwise read from what is beside them, with guesses for the rest. Files that were
//             opened for it are passed on (GuessedScene).
//   open      the row's reader; open_stored_clip settles the scene by what its pictures tell.
//
// A file on a server goes the same way from `probe` on; a stream has a reader of its own. At the end all
// frames are brought onto one pinhole camera. guess_clip goes as far as `describe`.

#include "engine/formats/open_clip.hpp"

#include <unistd.h>
#include <cerrno>

#include "engine/picture/image.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/formats/zip_folder.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/receiving.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr const char* own_scene_file = "scene.json";  // of a folder that describes itself

/// The settings that describe pictures without a scene.
Hints of_bare_pictures() {
    Hints hints{{Setting::intrinsics}};
    for (const SourceSetting& setting : source_settings())
        if (setting.describes) hints.push_back({setting.name});
    return hints;
}

// --- Find

/// Whether a path is a folder; an error if it is neither that nor a file.
Result<bool> leads_to_folder(const fs::path& path) {
    std::error_code failure;
    const auto status = fs::status(path, failure);
    if (status.type() == fs::file_type::not_found) return input_error(path.string() + ": does not exist");
    const bool is_folder = fs::is_directory(status);
    if (!failure && ::euidaccess(path.c_str(), is_folder ? R_OK | X_OK : R_OK) != 0)
        failure = {errno, std::generic_category()};
    if (failure) return input_error(path.string() + ": " + failure.message());
    if (is_folder || fs::is_regular_file(status)) return is_folder;
    return input_error(path.string() + ": is neither a file nor a folder" +
                       (fs::is_fifo(status)
                            ? ", but a pipe: read it as -, touchable play - < " + shell_word(path.string())
                            : ""));
}

bool is_scene_file(const fs::path& path) {
    return small_letters(path.extension().string()) == ".json";
}

/// Finds a file, or what is in a folder, as a scene file describes it.
Result<Candidate> find_described(const fs::path& path, bool is_folder, const fs::path& scene_file,
                                 const OpenSettings& wanted) {
    TRY_ASSIGN(auto described, read_scene_file(scene_file));
    const auto& video = described.scene.video;
    if ((!is_folder || video) && described.unstated.camera)  // only a folder's cameras could give one
        return error_at(scene_file.string(), settle(described, {}).error());
    if (is_folder && !video && !described.scene.folder)
        return input_error(scene_file.string() +
                           ": has no member \"folder\" or \"video\" that says which pictures to read");
    if (is_folder && video && wanted.known.least_confidence)
        return usage_error(scene_file.string() + ": describes a video, which has no least confidence");
    const SourceFile source(is_folder && video ? path / video->depth : path);
    const bool is_recording =
        is_folder && video && is_recording_of_ros(first_bytes(source, Candidate::telling_bytes));
    const auto folder = is_folder && !is_recording ? std::optional(path) : std::nullopt;
    return Candidate{source, folder, GuessedScene{std::move(described), {scene_file}}, wanted};
}

bool is_jpeg(const Candidate& candidate) {
    return candidate.begin.starts_with("\xff\xd8\xff");
}

/// Finds a file; a picture with the scene file of its name, which `init-scene` and `convert` write beside it.
Result<Candidate> find_file(const fs::path& path, const OpenSettings& wanted) {
    Candidate found{path, {}, {}, wanted};
    const fs::path beside = fs::path(path).replace_extension(".json");
    const bool is_picture = !picture_kind(found.begin).empty() || is_organised_cloud(found.source);
    if (wanted.is_known() || !is_picture || !is_file(beside)) return found;
    if (is_jpeg(found) && has_jpeg_depth(found.source)) return found;  // its own metadata describe it
    auto described = read_scene_file(beside);
    if (described && described->scene.folder && described->scene.folder->depth == path.filename())
        found.scene =
            GuessedScene{std::move(*described), {beside}, {"described by " + beside.filename().string()}};
    return found;
}

/// The depth video of a LeRobot data set, an error if it has several; nothing for any other folder.
Result<std::optional<fs::path>> lerobot_video_in(const fs::path& folder) {
    TRY_ASSIGN(const auto videos, lerobot_depth_videos(folder));
    if (videos.empty()) return std::optional<fs::path>{};
    if (videos.size() == 1) return std::optional(videos.front());
    return input_error(folder.string() + ": is a LeRobot data set with " + std::to_string(videos.size()) +
                       " videos of depth, each a clip of its own: touchable play " +
                       shell_word(videos.front().string()));
}

/// The video named depth in a folder without pictures and with one or two videos, of which the other may be
/// its colour. Nothing for any other folder.
std::optional<fs::path> depth_video_in(const fs::path& folder) {
    const auto videos = video_files_in(folder);
    const auto is_depth = [](const fs::path& video) { return is_named_as_depth_video(video); };
    if (videos.size() > 2 || std::ranges::count_if(videos, is_depth) != 1) return {};
    return picture_groups(folder).empty() ? std::optional(*std::ranges::find_if(videos, is_depth))
                                          : std::nullopt;
}

/// The one recording in a folder, which is opened in its place: of ROS 2, of the RealSense Viewer, or a depth
/// video; nothing for any other folder.
Result<std::optional<fs::path>> recording_in(const fs::path& folder) {
    TRY_ASSIGN(auto recording, ros2_recording_in(folder));
    if (!recording) recording = realsense_snapshot_in(folder);
    return recording ? recording : depth_video_in(folder);
}

/// Finds the folder's one recording, or its pictures, with or without a scene file of its own.
Result<Candidate> find_in_folder(const fs::path& folder, const OpenSettings& wanted) {
    const auto own = folder / own_scene_file;
    const bool has_own = is_file(own);
    if (has_own && wanted.is_known())
        return usage_error(
            own.string() + ": describes these pictures: leave camera, unit, preset and kind of depth out",
            of_bare_pictures());
    if (has_own) return find_described(folder, true, own, wanted);
    if (const fs::path packed = folder / packed_clip_name; is_file(packed) && is_packed_clip(packed))
        return Candidate{packed, {}, {}, wanted};
    TRY_ASSIGN(auto only, lerobot_video_in(folder));
    if (!only) TRY(assign(only, recording_in(folder)));
    return only ? Candidate{*only, {}, {}, wanted} : Candidate{folder, folder, {}, wanted};
}

Result<Candidate> find_clip(const fs::path& path, const std::optional<fs::path>& scene_file,
                            const OpenSettings& wanted) {
    TRY_ASSIGN(const bool is_folder, leads_to_folder(path));
    const bool is_known = wanted.is_known(),
               is_scene = !is_folder && is_scene_file(path) && !is_packed_clip(path);
    if (is_known && scene_file)
        return usage_error(
            path.string() + ": a scene file describes it: leave camera, unit, preset and kind of depth out",
            of_bare_pictures());
    std::error_code failure;
    const bool is_described = is_folder ? scene_file || fs::exists(path / own_scene_file, failure) : is_scene;
    if (wanted.known.least_confidence && !is_described && (is_folder || !is_npy_file(SourceFile(path))))
        return usage_error(path.string() +
                           ": is no .npz with an array conf, of which there could be a least confidence");
    if (!is_described && !is_folder) TRY(check_named_depth(wanted.known, path));
    if (is_scene && (scene_file || is_known))
        return usage_error(path.string() + ": is a scene file itself: leave " +
                               (scene_file ? "the other one" : "camera, unit and preset") + " out",
                           scene_file ? Hints{{Setting::scene_file}} : of_bare_pictures());
    if (is_scene) return find_described(path.parent_path(), true, path, wanted);
    if (scene_file) return find_described(path, is_folder, *scene_file, wanted);
    return is_folder ? find_in_folder(path, wanted) : find_file(path, wanted);
}

// --- Probe: each is called only if no earlier row of the table has recognised the file

/// A clip of ours, by its tags or its scene; also a file that is cut, even to nearly nothing, as the reader
/// of our clips tells best what is wrong.
bool is_matroska(const Candidate& candidate) {
    if (candidate.begin.size() < 4) return true;
    if (!candidate.begin.starts_with(matroska_magic)) return false;
    const auto opened = Demuxer::open_matroska(candidate.source);
    if (!opened || (*opened)->tag(clip_tags::version_tag) || (*opened)->attachment(clip_tags::scene_file))
        return true;
    const AVFormatContext& container = (*opened)->container();
    for (unsigned k = 0; k < container.nb_streams; ++k)
        if (av_dict_get(container.streams[k]->metadata, clip_tags::role_tag, nullptr, 0)) return true;
    return false;
}
/// MP4 with tags of ours or an MPEG-4 scene.
bool is_mpeg4(const Candidate& candidate) {
    return candidate.begin.size() >= 8 && candidate.begin.substr(4, 4) == "ftyp" && !is_heif(candidate) &&
           is_mp4_clip(candidate.source, candidate.scene || candidate.wanted.is_known());
}
constexpr auto is_stream_file = [](const Candidate& one) { return is_saved_stream(one.source); };
constexpr auto is_packed = [](const Candidate& one) { return !one.folder && is_packed_clip(one.source); };
constexpr auto is_any_picture = [](const Candidate& one) { return !picture_kind(one.begin).empty(); };
constexpr auto is_cloud_file = [](const Candidate& one) { return is_organised_cloud(one.source); };
constexpr auto is_ros_recording = [](const Candidate& one) { return is_recording_of_ros(one.begin); };
constexpr auto has_no_scene = [](const Candidate& one) { return !one.scene; };
constexpr auto has_scene = [](const Candidate& one) { return one.scene.has_value(); };
/// With a file of metadata beside it.
template <auto metadata_of>
constexpr auto has_metadata = [](const Candidate& one) { return metadata_of(one.source.path()).has_value(); };
/// Any JPEG but one that is a depth picture itself: without depth in its metadata, and grey all over, or in a
/// half beside colour, or described by a person.
bool is_jpeg_photo(const Candidate& candidate) {
    if (!is_jpeg(candidate)) return false;
    if (has_jpeg_depth(candidate.source)) return true;
    if (candidate.wanted.is_known()) return false;
    const auto stored = read_stored_image(candidate.source);
    return !stored || !(is_grey(stored->image) || depth_beside_colour(stored->image));
}
/// Matroska or WebM, QuickTime or MP4, AVI.
bool is_video(const Candidate& candidate) {
    const std::string_view begin = candidate.begin;
    if (begin.starts_with(matroska_magic)) return true;
    if (begin.size() < 8) return false;
    if (begin.starts_with("RIFF")) return begin.substr(8).starts_with("AVI");
    constexpr std::string_view boxes[] = {"ftyp", "moov", "mdat", "wide", "free", "skip", "pnot"};
    return std::ranges::count(boxes, begin.substr(4, 4)) > 0;
}

// --- Describe

Result<GuessedScene> describe_picture(const Candidate& candidate) {
    const std::string name = candidate.source.path().filename().string();
    if (!is_still(name))
        return input_error(candidate.source.string() +
                           ": has a % or * in its name, which stand for numbers: rename it");
    if (!candidate.scene) return guess_picture(candidate.source, candidate.wanted.known);
    GuessedScene made = *candidate.scene;
    made.pictures = std::make_shared<ReadPictures>(candidate.wanted.known, candidate.source);
    made.scene.video.reset();
    const FolderSource of = made.scene.folder.value_or(FolderSource());
    if (of.depth == name) return made;
    // Planes that share depth's files are in this file.
    FolderSource& here = made.scene.folder.emplace();
    here.depth = name;
    if (!of.depth.empty() && of.colour == of.depth) here.colour = name;
    if (!of.depth.empty() && of.haptic == of.depth) here.haptic = name;
    return made;
}

/// A scene file's contents apply even if it names another file.
Result<GuessedScene> describe_video(const Candidate& candidate) {
    if (!candidate.scene) return guess_video(candidate.source, candidate.wanted.known);
    GuessedScene made = *candidate.scene;
    Scene& scene = made.scene;
    scene.folder.reset();
    if (!scene.video) scene.video.emplace().values = usual_values(scene.depth.kind);
    scene.video->depth = candidate.source.path().filename().string();
    TRY_ASSIGN(made.video, VideoFile::open(candidate.source, PlaneRole::depth));
    return made;
}

Result<GuessedScene> describe_k4a(const Candidate& candidate) {
    if (!candidate.scene) return guess_k4a(candidate.source, candidate.wanted.known);
    TRY_ASSIGN(auto made, describe_video(candidate));
    if (made.scene.colour_camera) made.scene.video->colour = made.scene.video->depth;
    return made;
}

Result<GuessedScene> describe_bag(const Candidate& candidate) {
    if (candidate.scene) return *candidate.scene;
    return guess_bag(candidate.source, candidate.wanted.known);
}

Result<GuessedScene> describe_folder(const Candidate& candidate) {
    if (!candidate.scene) return guess_folder(*candidate.folder, candidate.wanted.known);
    GuessedScene made = *candidate.scene;
    made.pictures = std::make_shared<ReadPictures>(candidate.wanted.known);
    if (made.scene.video) TRY(assign(made.video, VideoFile::open(candidate.source, PlaneRole::depth)));
    return made;
}

// --- Open

/// Opens the pictures or videos that the scene names.
Opened open_named(const Candidate& candidate) {
    const auto open = candidate.scene->scene.video ? open_videos : open_image_folder;
    return open(candidate.home(), *candidate.scene, candidate.wanted.colour, candidate.wanted.alignment);
}

/// A clip that has its scene.
template <auto open_clip>
Opened open_whole(const Candidate& candidate) {
    return open_clip(candidate.source, candidate.described(), candidate.wanted.colour);
}

Opened open_mpeg4(const Candidate& candidate) {
    if (is_mp4_stills(candidate.source)) return open_mp4_stills(candidate);
    return open_mp4_clip(candidate.source, candidate.described(), candidate.wanted.colour);
}

/// How much files say of their own depth. From `described` on, a person's camera, unit or preset is refused.
enum class FileKind {
    folder,
    bare,       ///< nothing, or not all: the rest is stated, or guessed
    photo,      ///< all but the camera
    described,  ///< all, in a file beside it
    text,       ///< all, as the text of an MPEG-4 scene
    clip,       ///< all, and its scene can be written to a scene file
};

struct Format {
    FileKind kind;
    bool (*probe)(const Candidate&);
    Result<GuessedScene> (*describe)(const Candidate&);  ///< null: its files say all that is needed
    Opened (*open)(const Candidate&);
    const char *what, *command;  ///< ClipFormat
    Hints settings{};
};
const Format formats[] = {
    {FileKind::clip, is_matroska, nullptr, open_whole<open_matroska_clip>,
     "a touchable clip (Matroska with its scene attached)", "touchable play clip.mkv"},
    {FileKind::clip, is_mpeg4, nullptr, open_mpeg4,
     "a touchable clip in MP4, as its MPEG-4 scene describes it", "touchable play clip.mp4"},
    {FileKind::clip, is_stream_file, nullptr, open_whole<open_saved_stream>,
     "a stream of touchable serve that was saved to a file (MPEG-TS)", "touchable play stream.ts"},
    {FileKind::clip, is_packed, nullptr, open_packed_clip,
     "a clip packed for pages in browsers (clip.json beside its planes)", "touchable play folder/clip.json"},
    {FileKind::text, is_scene_text, nullptr, open_scene_text,
     "the text of an MPEG-4 scene, beside the pictures that it names", "touchable play scene.bt"},
    {FileKind::clip, is_gltf, nullptr, open_gltf_clip,
     "a glTF scene whose depth is a texture, beside its video or pictures", "touchable play clip.gltf"},
    {FileKind::photo, is_jpeg_photo, nullptr, open_jpeg_depth,
     "a phone's JPEG with depth (GDepth, Dynamic Depth, Apple's)", "touchable play portrait.jpg"},
    {FileKind::photo, is_heif, nullptr, open_heic_image,
     "a phone's HEIC, HEIF or AVIF with depth (portraits)", "touchable play portrait.heic"},
    {FileKind::bare, is_any_picture, describe_picture, open_named,
     "a picture of depth: PNG and JPEG (beside its colour, too), PGM, TIFF, PFM, .dpt, OpenEXR (a rendering "
     "with its colour, too), NumPy (.npy, .npz), HDF5 (.h5, .hdf5, MATLAB's 7.3)",
     "touchable play depth.png", Hints{{Setting::intrinsics, "525,525"}, {Setting::depth_unit, "0.001"}}},
    {FileKind::bare, is_cloud_file, describe_picture, open_named,
     "a cloud of points with rows and columns (.pcd, .ply): its z is depth, and its points tell the camera",
     "touchable play cloud.pcd"},
    {FileKind::bare, has_metadata<realsense_metadata_of>, describe_picture, open_named,
     "a snapshot of the RealSense Viewer: NAME_Depth.raw with its NAME_Depth_metadata.csv beside it",
     "touchable play snap_Depth.raw"},
    {FileKind::bare, is_ros_recording, describe_bag, open_bag_clip,
     "a recording of a RealSense or of ROS 1 (.bag), or of ROS 2 (.mcap, .db3 or their folder)",
     "touchable play recording.bag"},
    {FileKind::described, has_metadata<depthkit_metadata_of>, nullptr, open_depthkit_clip,
     "a Depthkit video with its metadata beside it", "touchable play Take.mp4"},
    {FileKind::bare, is_k4a_recording, describe_k4a, open_named,
     "a recording of an Azure Kinect or an Orbbec Femto (Matroska, calibration.json attached)",
     "touchable play recording.mkv"},
    {FileKind::bare, is_video, describe_video, open_named,
     "a video of depth, alone or beside its colour: grey, LeRobot's, or hue as of Record3D (.mp4, .mov, "
     ".webm, .mkv, .avi)",
     "touchable play depth.webm"},
    {FileKind::folder, has_no_scene, describe_folder, open_named,
     "a folder of pictures, as cameras and data sets have them (TUM, Redwood, 7-Scenes, ...), also in a ZIP "
     "archive",
     "touchable play FOLDER"},
    {FileKind::folder, has_scene, describe_folder, open_named,
     "a folder, a picture, a video or two with a scene file (docs/scene_file.md)", "touchable play FOLDER",
     Hints{{Setting::scene_file, "scene.json"}}},
};

/// The first format that recognises a candidate; null: none does.
const Format* probe(const Candidate& candidate) {
    for (const Format& format : formats)
        if ((format.kind == FileKind::folder) == candidate.folder.has_value() && format.probe(candidate))
            return &format;
    return nullptr;
}

/// The error for a camera, unit or preset that is given for a file with its own scene.
Error refused_description(const std::string& name, bool is_in_it) {
    if (!is_in_it)
        return usage_error(name +
                               ": has a scene of its own; a camera, a unit and a preset are for pictures "
                               "alone: leave them out",
                           of_bare_pictures());
    return usage_error(
        name +
            ": has its scene in it: a camera, a unit or a preset does not change that. Leave them out, or "
            "write the scene to a file (touchable init-scene " +
            shell_word(name) + "), change it and name it",
        {{Setting::scene_file, "FILE"}});
}

/// The error for a known file of another program, which is not opened.
std::optional<Error> foreign_refusal(const Format* format, const Candidate& candidate) {
    if (candidate.folder) return {};
    auto what = misleading_file(candidate.source, candidate.begin);
    if (!what && format == nullptr) what = foreign_file(candidate.source);
    if (!what) return {};
    return input_error(candidate.source.string() + ": " + *what);
}

/// Why a candidate of this format (null: none) is not opened; nothing: it is.
std::optional<Error> refusal(const Format* format, const Candidate& candidate) {
    if (auto foreign = foreign_refusal(format, candidate)) return foreign;
    const fs::path& file = candidate.source.path();
    const FileKind kind = format ? format->kind : FileKind::described;
    if (format && kind > FileKind::photo && candidate.wanted.is_known())
        return refused_description(file.string(), kind == FileKind::clip);
    // A scene's text may name pictures; if it names videos, their reader checks this.
    const bool has_codes = !candidate.scene || candidate.scene->scene.stored.is_plain();
    if (kind > FileKind::photo && kind != FileKind::text && !has_codes)
        return usage_error(file.string() +
                           ": the scene's depth.coding is of pictures in files, not of videos");
    if (format) return {};
    if (const auto video = depthkit_video_of(file))
        return input_error(file.string() + ": says what the depth of a Depthkit video is: touchable play " +
                           shell_word(video->string()));
    return input_error(file.string() +
                       ": is of no kind that is known (touchable formats lists those that open): of an array "
                       "of depth in Python, numpy.save('depth.npy', ARRAY) makes a file that opens");
}

/// Aligns the depth of a clip with its own scene only if alignment is `on`, with all its colour.
Opened open_aligned(const Format& format, Candidate candidate) {
    if (format.open == open_named || candidate.wanted.alignment != DepthAlignment::on)
        return format.open(candidate);
    const Colour colour = std::exchange(candidate.wanted.colour, Colour::wanted);
    TRY_ASSIGN(auto reader, format.open(candidate));
    TRY_ASSIGN(auto aligned, with_aligned_depth(std::move(reader), DepthAlignment::on));
    if (colour == Colour::left_out) aligned->leave_out_colour();
    return aligned;
}

/// The stages from `probe` on. Files read for the scene become the clip's inputs, so that nothing overwrites
/// them.
Opened open_found(Candidate candidate) {
    const Format* const format = probe(candidate);
    if (auto refused = refusal(format, candidate)) return std::move(*refused);
    if (format->describe) TRY(assign(candidate.scene, format->describe(candidate)));
    const auto inputs = candidate.scene ? candidate.scene->inputs : std::vector<fs::path>();
    auto reader = open_aligned(*format, std::move(candidate));
    if (reader)
        for (const fs::path& input : inputs) (*reader)->add_input(input);
    return reader;
}

/// Opens a stream or a file on a server; refuses a file that names others, as these are not fetched.
Opened open_url(const StreamUrl& url, const std::optional<GuessedScene>& scene, const OpenSettings& wanted) {
    StreamSource source{.url = url};
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) {
            Candidate candidate{*found.file, {}, scene, wanted};
            if (is_gltf(candidate) || is_scene_text(candidate) || is_scene_file(found.file->path()))
                return input_error(found.file->string() +
                                   ": names other files, which are not fetched from there; fetch them all, "
                                   "and open them here");
            auto reader = open_found(std::move(candidate));
            if (const auto failure = found.end_opening()) return error_at(url.name(), *failure);
            if (reader) (*reader)->forget_inputs();
            return reader;
        }
        source.connection = std::move(found.stream);
    }
    if (wanted.is_known())
        return usage_error(
            url.name() +
                ": is a stream, which has its scene in it: leave camera, unit, preset and kind of depth out",
            of_bare_pictures());
    return open_stream_clip(source, scene, wanted.colour);
}

/// Opens an archive of pictures as the folder that it unpacks to.
Opened open_zip_folder(const ZipPlace& place, const std::optional<fs::path>& scene_file,
                       const OpenSettings& wanted) {
    TRY_ASSIGN(auto folder, ZipFolder::unpack(place.archive, place.inner));
    auto found = find_clip(folder->opened(), scene_file, wanted);
    auto reader = found ? open_found(std::move(*found)) : Opened(found.error());
    if (!reader) return folder->named(reader.error());
    return with_zip_folder(std::move(*reader), std::move(folder));
}

Opened open_path(const fs::path& path, const std::optional<fs::path>& scene_file,
                 const OpenSettings& wanted) {
    std::string name = path.string();
    std::error_code ignored;
    // What a shell makes of <(COMMAND).
    if (name.starts_with("/dev/fd/") && fs::is_fifo(path, ignored)) name.replace(0, 8, "pipe:");
    if (is_stream_url(name)) {
        TRY_ASSIGN(const auto url, read_stream_url(name));
        std::optional<GuessedScene> scene;
        if (scene_file) {
            TRY_ASSIGN(auto described, read_scene_file(*scene_file));
            scene = GuessedScene{std::move(described)};
        }
        auto reader = open_url(url, scene, wanted);
        if (reader && scene_file) (*reader)->add_input(*scene_file);
        return reader;
    }
    if (path.extension() == ".m3u8" && is_file(path) && !scene_file && !wanted.is_known())
        return open_stream_clip({.url = playlist_in_folder(path.string())}, {}, wanted.colour);
    const auto open_here = [&]() -> Opened {
        if (const auto zip = zip_of_pictures(path)) return open_zip_folder(*zip, scene_file, wanted);
        TRY_ASSIGN(auto found, find_clip(path, scene_file, wanted));
        return open_found(std::move(found));
    };
    auto reader = open_here();
    if (reader && !wanted.known.file.empty()) (*reader)->add_input(wanted.known.file);
    return reader;
}

/// The scene in a clip of ours, without the names of the files that it was made from.
Result<GuessedScene> scene_in(const Format& format, Candidate candidate) {
    candidate.wanted.colour = Colour::left_out;
    TRY_ASSIGN(const auto reader, format.open(candidate));
    GuessedScene scene{reader->described()};
    scene.scene.folder.reset();
    scene.scene.video.reset();
    return scene;
}

/// An unused name beside a clip for the pictures that `convert` can make of it. Without an extension it is a
/// folder's, and ends in / if it has a dot.
fs::path free_name(const fs::path& clip, const char* extension) {
    const fs::path stem = clip.parent_path() / clip.stem();
    fs::path name = stem;
    name += extension;
    std::error_code ignored;
    for (int n = 2; fs::exists(name, ignored); ++n) {
        name = stem;
        name += '-' + std::to_string(n) + extension;
    }
    if (*extension == '\0' && !name.extension().empty()) name /= "";
    return name;
}

Error nothing_to_guess(const fs::path& file, const char* what, const char* extension) {
    return input_error(file.string() + what +
                       ": nothing is to be guessed; as pictures with a scene file: touchable convert " +
                       shell_word(file.string()) + ' ' + shell_word(free_name(file, extension).string()));
}

/// Guesses the scene of a file without one, or returns the one in a clip of ours.
Result<GuessedScene> guess_file(const fs::path& file, const SourceDescription& known) {
    const Candidate candidate{file, {}, {}, {known}};
    const Format* const format = probe(candidate);
    if (auto foreign = foreign_refusal(format, candidate)) return std::move(*foreign);
    const FileKind kind = format ? format->kind : FileKind::bare;
    if (kind == FileKind::photo && (!is_jpeg(candidate) || has_jpeg_depth(candidate.source)))
        return nothing_to_guess(file, ": is a photograph that says itself what its depth is", ".png");
    if (kind == FileKind::described)
        return nothing_to_guess(file, ": is a Depthkit video, whose metadata beside it say what its depth is",
                                "");
    if (kind == FileKind::clip && candidate.wanted.is_known())
        return refused_description(file.string(), true);
    if (kind == FileKind::clip) return scene_in(*format, candidate);
    return format && format->describe ? format->describe(candidate) : describe_picture(candidate);
}

Result<GuessedScene> guess_path(const fs::path& path, const SourceDescription& known) {
    if (is_stream_url(path.string())) {
        TRY(read_stream_url(path.string()));
        return usage_error(in_quotes(path.string()) + " is no file here; save it first: touchable convert " +
                           shell_word(path.string()) + " clip.mkv");
    }
    TRY_ASSIGN(const auto is_folder, leads_to_folder(path));
    if (!is_folder) return guess_file(path, known);
    TRY_ASSIGN(const auto lerobot, lerobot_video_in(path));
    if (lerobot)
        return input_error(
            path.string() +
            ": is a LeRobot data set, and a scene file is of its video: touchable init-scene " +
            shell_word(lerobot->string()));
    TRY_ASSIGN(const auto recording, recording_in(path));
    return recording ? guess_file(*recording, known) : guess_folder(path, known);
}

/// An error if the thread was asked to stop: files may have been read only in part, and the result wrong.
template <class Made>
Result<Made> unless_given_up(Result<Made> made) {
    return stop_requested() ? interrupted_error() : std::move(made);
}

}  // namespace

Opened open_video_clip(const fs::path& folder, const SceneDescription& described) {
    return open_videos(folder, GuessedScene{described}, Colour::left_out, DepthAlignment::off);
}

Result<SceneDescription> guess_clip(const fs::path& path, const SourceDescription& known) {
    TRY_ASSIGN(auto guessed, unless_given_up(guess_path(path, known)));
    return SceneDescription(std::move(guessed));
}

bool is_named_as_clip(const fs::path& file) {
    return is_named_as_video(file) ||
           is_any_of(small_letters(file.extension().string()), {".bag", ".mcap", ".db3"});
}

std::vector<ClipFormat> clip_formats() {
    std::vector<ClipFormat> said;
    for (const Format& each : formats) said.push_back({each.what, each.command, each.settings});
    return said;
}

Result<std::unique_ptr<ClipReader>> open_clip(const fs::path& path, const std::optional<fs::path>& scene_file,
                                              const SourceDescription& known, Colour colour,
                                              DepthAlignment alignment) {
    auto reader = open_path(path, scene_file, {known, colour, alignment});
    return unless_given_up(reader ? with_pinhole_frames(std::move(*reader)) : std::move(reader));
}

}  // namespace touchable
