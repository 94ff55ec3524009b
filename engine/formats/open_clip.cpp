// Opens clips of every kind. Files come first: what recognises each kind, what opens it, and the table of all
// (Format); then folders, scene files and URLs.

#include "engine/formats/open_clip.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/receiving.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// What the caller of open_clip wants of the clip.
struct OpenSettings {
    Colour colour = Colour::wanted;
    DepthAlignment alignment = DepthAlignment::automatic;
    std::optional<double> least_confidence{};  ///< of a .npz
};

constexpr std::size_t telling_bytes = 16;  // a file's first, which tell of which kind it is
constexpr std::string_view matroska_magic = "\x1a\x45\xdf\xa3";

/// What describes pictures that do not describe themselves.
Hints of_bare_pictures() {
    return {{Setting::intrinsics}, {Setting::field_of_view}, {Setting::depth_unit}, {Setting::preset}};
}

/// Files that were read for the scene are inputs of the clip, too: nothing may write over them.
Opened with_inputs(Opened reader, const std::vector<fs::path>& inputs) {
    if (reader)
        for (const auto& input : inputs) (*reader)->add_input(input);
    return reader;
}

/// As a scene in `folder` describes it, whose depth is in this file.
Opened open_described_video(const fs::path& folder, const SourceFile& depth,
                            const SceneDescription& described, const OpenSettings& wanted) {
    TRY_ASSIGN(auto opened, VideoFile::open(depth, PlaneRole::depth));
    return open_video_clip(folder, described, wanted.colour, std::move(opened), wanted.alignment);
}

/// A file that may be a clip.
struct Candidate {
    const SourceFile& source;
    const std::optional<SceneDescription>& described;  ///< to replace its own
    const SourceDescription& known;
    const OpenSettings wanted;
    const bool is_known = !(known == SourceDescription());  ///< whether that says anything
    const fs::path& file = source.path();
    const std::string begin = first_bytes(source, telling_bytes);
    // Found out when first asked for.
    mutable std::optional<bool> is_foreign{};  ///< Matroska without anything that makes a clip of ours of it
    mutable std::optional<bool> is_mpeg4{};    ///< MP4 with tags of ours or an MPEG-4 scene
};

bool is_jpeg(const Candidate& candidate) {
    return candidate.begin.starts_with("\xff\xd8\xff");
}
bool is_picture(const Candidate& candidate) {
    return !picture_kind(candidate.begin).empty() && !is_jpeg(candidate);
}
bool is_heic(const Candidate& candidate) {
    return is_heif(candidate.begin);
}
bool is_foreign_matroska(const SourceFile& file) {
    const auto opened = Demuxer::open_matroska(file);
    if (!opened || (*opened)->tag(clip_tags::version_tag) || (*opened)->attachment(clip_tags::scene_file))
        return false;
    const AVFormatContext& container = (*opened)->container();
    for (unsigned k = 0; k < container.nb_streams; ++k)
        if (av_dict_get(container.streams[k]->metadata, clip_tags::role_tag, nullptr, 0)) return false;
    return true;
}
/// Also one that is cut, even to nearly nothing, of which its reader tells best what is wrong.
bool is_matroska(const Candidate& candidate) {
    if (candidate.begin.size() < 4) return true;
    if (!candidate.begin.starts_with(matroska_magic)) return false;
    if (!candidate.is_foreign) candidate.is_foreign = is_foreign_matroska(candidate.source);
    return !*candidate.is_foreign;
}
bool is_depthkit(const Candidate& candidate) {
    return depthkit_metadata_of(candidate.file).has_value();
}
bool is_ros_recording(const Candidate& candidate) {
    return is_recording_of_ros(candidate.begin);
}
bool is_mpeg4(const Candidate& candidate) {
    if (candidate.begin.size() < 8 || candidate.begin.substr(4, 4) != "ftyp" || is_heic(candidate))
        return false;
    if (!candidate.is_mpeg4)
        candidate.is_mpeg4 = is_mp4_clip(candidate.source, candidate.described || candidate.is_known);
    return *candidate.is_mpeg4;
}
/// Matroska or WebM, QuickTime or MP4, AVI.
bool begins_like_video(std::string_view begin) {
    if (begin.starts_with(matroska_magic)) return true;
    if (begin.size() < 8) return false;
    if (begin.starts_with("RIFF")) return begin.substr(8).starts_with("AVI");
    constexpr std::string_view boxes[] = {"ftyp", "moov", "mdat", "wide", "free", "skip", "pnot"};
    return std::find(std::begin(boxes), std::end(boxes), begin.substr(4, 4)) != std::end(boxes);
}
bool is_video(const Candidate& candidate) {
    return begins_like_video(candidate.begin) && !is_heic(candidate) && !is_matroska(candidate) &&
           !is_depthkit(candidate) && !is_mpeg4(candidate);
}
bool is_azure_kinect(const Candidate& candidate) {
    return candidate.begin.starts_with(matroska_magic) && is_k4a_recording(candidate.source);
}

/// A scene stands for what is in it, also where it speaks of another file.
Opened open_video(const Candidate& candidate) {
    const auto folder = candidate.file.parent_path();
    if (!candidate.described) {
        TRY_ASSIGN(auto guessed, is_azure_kinect(candidate) ? guess_k4a(candidate.source, candidate.known)
                                                            : guess_video(candidate.source, candidate.known));
        return with_inputs(open_video_clip(folder, guessed, candidate.wanted.colour, guessed.video,
                                           candidate.wanted.alignment),
                           guessed.inputs);
    }
    SceneDescription described = *candidate.described;
    Scene& scene = described.scene;
    scene.folder.reset();
    if (!scene.video) scene.video.emplace().values = usual_values(scene.depth.kind);
    scene.video->depth = candidate.file.filename().string();
    if (is_azure_kinect(candidate) && scene.colour_camera) scene.video->colour = scene.video->depth;
    return open_described_video(folder, candidate.source, described, candidate.wanted);
}

/// What `init-scene` and `convert` write beside a picture.
struct SceneBeside {
    fs::path file;
    SceneDescription described;
};
std::optional<SceneBeside> scene_beside(const fs::path& picture) {
    fs::path file = picture;
    file.replace_extension(".json");
    if (!is_file(file)) return {};
    auto described = read_scene_file(file);
    if (!described) return {};
    const auto& folder = described->scene.folder;
    if (!folder || folder->depth != picture.filename()) return {};
    return SceneBeside{std::move(file), std::move(*described)};
}

/// One picture of depth, as it is described.
Opened open_bare_picture(const Candidate& candidate, SceneDescription described,
                         std::vector<std::string> notes, std::shared_ptr<ReadPictures> pictures) {
    const std::string name = candidate.file.filename().string();
    if (!is_still(name))
        return input_error(candidate.file.string() +
                           ": has a % or * in its name, which stand for numbers: rename it");
    Scene& scene = described.scene;
    if (!scene.folder || scene.folder->depth != name) {
        // Planes in the same files as depth are in this one.
        const FolderSource described_one = scene.folder.value_or(FolderSource());
        const auto here = [&](const std::string& pattern) {
            return !pattern.empty() && pattern == described_one.depth ? name : std::string();
        };
        scene.folder.emplace();
        scene.folder->depth = name;
        scene.folder->colour = here(described_one.colour);
        scene.folder->haptic = here(described_one.haptic);
    }
    return open_image_folder(candidate.file.parent_path(), described, std::move(notes),
                             candidate.wanted.colour, std::move(pictures), candidate.wanted.alignment);
}

Opened open_picture(const Candidate& candidate) {
    const auto opened = std::make_shared<ReadPictures>(candidate.source);
    opened->trust_from(candidate.wanted.least_confidence);
    if (candidate.described) return open_bare_picture(candidate, *candidate.described, {}, opened);
    if (auto own = scene_beside(candidate.file); own && !candidate.is_known)
        return with_inputs(open_bare_picture(candidate, std::move(own->described),
                                             {"described by " + own->file.filename().string()}, opened),
                           {own->file});
    SourceDescription known = candidate.known;
    known.least_confidence = candidate.wanted.least_confidence;
    TRY_ASSIGN(auto guessed, guess_picture(candidate.source, known));
    return with_inputs(open_bare_picture(candidate, guessed, {}, guessed.pictures), guessed.inputs);
}

/// With depth in its metadata, or of depth itself: where a person describes it, or it is grey all over.
Opened open_jpeg(const Candidate& candidate) {
    const auto is_grey_picture = [&] {
        const auto stored = read_stored_image(candidate.source);
        return stored && is_grey(stored->image);
    };
    const bool is_depth = !has_jpeg_depth(candidate.source) && (candidate.is_known || is_grey_picture());
    if (stop_requested()) return interrupted_error();
    return is_depth ? open_picture(candidate)
                    : open_jpeg_depth(candidate.source, candidate.described, candidate.known);
}

Opened open_mpeg4(const Candidate& candidate) {
    const auto open = is_mp4_stills(candidate.source) ? open_mp4_stills : open_mp4_clip;
    return open(candidate.source, candidate.described, candidate.wanted.colour);
}

/// The first that recognises a file opens it.
struct Format {
    bool (*recognises)(const Candidate&);
    Opened (*open)(const Candidate&);
    ClipFormat said;
};
const Format formats[] = {
    {is_matroska,
     [](const Candidate& c) { return open_matroska_clip(c.source, c.described, c.wanted.colour); },
     {"a touchable clip (Matroska with its scene attached)", "touchable play clip.mkv"}},
    {is_mpeg4,
     open_mpeg4,
     {"a touchable clip in MP4, as its MPEG-4 scene describes it", "touchable play clip.mp4"}},
    {[](const Candidate& c) { return is_scene_text(c.source); },
     [](const Candidate& c) { return open_scene_text(c.source, c.described, c.wanted.colour); },
     {"the text of an MPEG-4 scene, beside the pictures that it names", "touchable play scene.bt"}},
    {[](const Candidate& c) { return is_gltf(c.source); },
     [](const Candidate& c) { return open_gltf_clip(c.source, c.described, c.wanted.colour); },
     {"a glTF scene whose depth is a texture, beside its video or pictures", "touchable play clip.gltf"}},
    {is_jpeg,
     open_jpeg,
     {"a phone's JPEG with depth (GDepth, Dynamic Depth)", "touchable play portrait.jpg"}},
    {is_heic,
     [](const Candidate& c) { return open_heic_image(c.source, c.described, c.known); },
     {"a phone's HEIC, HEIF or AVIF with depth (portraits)", "touchable play portrait.heic"}},
    {is_picture,
     open_picture,
     {"a picture of depth: PNG, PGM, TIFF, PFM, OpenEXR (a rendering with its colour, too), NumPy (.npy, "
      ".npz)",
      "touchable play depth.png",
      {{Setting::intrinsics, "525,525"}, {Setting::depth_unit, "0.001"}}}},
    {is_ros_recording,
     [](const Candidate& c) { return open_bag_clip(c.source, c.described, c.known, c.wanted.colour); },
     {"a recording of a RealSense or of ROS 1 (.bag), or of ROS 2 (.mcap, .db3 or their folder)",
      "touchable play recording.bag"}},
    {is_depthkit,
     [](const Candidate& c) {
         return open_depthkit_clip(c.source, *depthkit_metadata_of(c.file), c.described);
     },
     {"a Depthkit video with its metadata beside it", "touchable play Take.mp4"}},
    {is_azure_kinect,
     open_video,
     {"a recording of an Azure Kinect or an Orbbec Femto (Matroska, calibration.json attached)",
      "touchable play recording.mkv"}},
    {is_video,
     open_video,
     {"a video of depth, alone or beside its colour: grey, LeRobot's, or hue as of Record3D (.mp4, .mov, "
      ".webm, .mkv, .avi)",
      "touchable play depth.webm"}},
};

/// Whether it is a clip of ours, which has its scene in it.
bool has_scene(const Candidate& candidate) {
    return is_gltf(candidate.source) || is_mpeg4(candidate) ||
           (is_matroska(candidate) && !is_azure_kinect(candidate));
}

/// The file says itself what a camera, a unit or a preset would say.
Error refused_description(const Candidate& candidate) {
    const std::string name = candidate.file.string();
    if (!has_scene(candidate))
        return usage_error(
            name + ": is no picture, so a camera, a unit or a preset says nothing of it: leave them out",
            of_bare_pictures());
    return usage_error(
        name +
            ": is no picture and has its scene in it, which a camera, a unit or a preset does "
            "not change: leave them out, or write that scene to a file (touchable init-scene " +
            shell_word(name) + "), change it and name it",
        {{Setting::scene_file, "FILE"}});
}

/// Depth of a clip that has its scene is aligned only where that is asked for, and by all its colour.
Opened opened_as(const Format& format, const Candidate& candidate) {
    const bool aligns_itself =
        format.open == open_picture || format.open == open_video || format.open == open_jpeg;
    if (aligns_itself || candidate.wanted.alignment != DepthAlignment::on) return format.open(candidate);
    auto reader = format.open({candidate.source, candidate.described, candidate.known,
                               OpenSettings{Colour::wanted, DepthAlignment::on, {}}});
    if (!reader) return reader;
    reader = with_aligned_depth(std::move(*reader), DepthAlignment::on);
    if (reader && candidate.wanted.colour == Colour::left_out) (*reader)->leave_out_colour();
    return reader;
}

/// The scene of a clip of ours, without the files that it once was of.
Result<GuessedScene> scene_in(const Candidate& candidate) {
    TRY_ASSIGN(const auto reader,
               is_gltf(candidate.source) ? open_gltf_clip(candidate.source, std::nullopt, Colour::left_out)
               : is_mpeg4(candidate)     ? open_mpeg4(candidate)
                                     : open_matroska_clip(candidate.source, std::nullopt, Colour::left_out));
    GuessedScene scene{reader->described(), {}, {}, {}};
    scene.scene.folder.reset();
    scene.scene.video.reset();
    return scene;
}

/// A name of pictures that `convert` can make beside a clip: what is there is not replaced. Without an
/// extension it is a folder's, which ends in / where it has a dot.
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

/// Refuses a file that says itself what a scene file would say; nothing where there is something to guess.
std::optional<Error> nothing_to_guess(const Candidate& candidate) {
    const std::string name = candidate.file.string();
    const auto refused = [&](const char* what, const char* extension) {
        return input_error(
            name + what + ": nothing is to be guessed; as pictures with a scene file: touchable convert " +
            shell_word(name) + ' ' + shell_word(free_name(candidate.file, extension).string()));
    };
    if (is_heic(candidate) || (is_jpeg(candidate) && has_jpeg_depth(candidate.source)))
        return refused(": is a photograph that says itself what its depth is", ".png");
    if (is_depthkit(candidate))
        return refused(": is a Depthkit video, whose metadata beside it say what its depth is", "");
    return {};
}

/// By the first format that recognises the file.
Opened open_file(const SourceFile& source, const std::optional<SceneDescription>& described,
                 const SourceDescription& known, const OpenSettings& wanted) {
    const Candidate candidate{source, described, known, wanted};
    const fs::path& file = candidate.file;
    const bool describes_itself = !is_picture(candidate) && !is_jpeg(candidate) && !is_heic(candidate) &&
                                  !is_video(candidate) && !is_ros_recording(candidate);
    if (describes_itself && candidate.is_known) return refused_description(candidate);
    // A scene's text may name pictures; where it names videos, their reader checks this.
    if (describes_itself && described && !described->scene.stored.is_plain() && !is_scene_text(source))
        return usage_error(file.string() +
                           ": the scene's depth.coding is of pictures in files, not of videos");
    if (file.extension() == ".r3d")
        return input_error(file.string() +
                           ": is a recording of Record3D in its own format: export it there as MP4 (RGBD "
                           "video), then: touchable play EXPORT.mp4");
    for (const Format& format : formats)
        if (format.recognises(candidate)) return opened_as(format, candidate);
    if (const auto video = depthkit_video_of(file))
        return input_error(file.string() + ": says what the depth of a Depthkit video is: touchable play " +
                           shell_word(video->string()));
    return input_error(file.string() +
                       ": is not a Matroska file, nor a video, nor glTF, nor the text of an MPEG-4 scene, "
                       "nor a recording of "
                       "ROS (.bag, .mcap, .db3), nor a picture of depth (PNG, PGM, TIFF, PFM, EXR, NumPy), "
                       "nor a JPEG or HEIC "
                       "with depth, nor a Depthkit video with " +
                       depthkit_metadata_name(file).string() + " beside it");
}

/// The scene of a file that has none, or the one that is in a clip of ours.
Result<GuessedScene> guess_file(const SourceFile& source, const SourceDescription& known) {
    const std::optional<SceneDescription> none;
    const Candidate candidate{source, none, known, {}};
    if (auto refused = nothing_to_guess(candidate)) return std::move(*refused);
    if (has_scene(candidate))
        return candidate.is_known ? Result<GuessedScene>(refused_description(candidate))
                                  : scene_in(candidate);
    return is_ros_recording(candidate)  ? guess_bag(source, known)
           : is_azure_kinect(candidate) ? guess_k4a(source, known)
           : is_video(candidate)        ? guess_video(source, known)
                                        : guess_picture(source, known);
}

constexpr const char* own_scene_file = "scene.json";  // of a folder that describes itself

bool is_scene_file(const fs::path& path) {
    return small_letters(path.extension().string()) == ".json";
}

/// Whether a path is a folder; refused where it is neither that nor a file.
Result<bool> leads_to_folder(const fs::path& path) {
    std::error_code failure;
    const auto status = fs::status(path, failure);
    if (!fs::exists(status)) return input_error(path.string() + ": does not exist");
    if (fs::is_directory(status)) return true;
    if (fs::is_regular_file(status)) return false;
    return input_error(path.string() + ": is neither a file nor a folder");
}

/// A folder, or a file, as a scene file describes it.
Opened open_described(const fs::path& path, const fs::path& scene_file, const OpenSettings& wanted) {
    TRY_ASSIGN(const auto described, read_scene_file(scene_file));
    const auto& video_source = described.scene.video;
    const bool is_file = touchable::is_file(path);
    if ((is_file || video_source) && described.unstated.camera)  // which only a folder's cameras could give
        return error_at(scene_file.string(), settle(described, {}).error());
    if (!is_file && !video_source && !described.scene.folder)
        return input_error(scene_file.string() +
                           ": has no member \"folder\" or \"video\" that says which pictures to read");
    if (!is_file && video_source && wanted.least_confidence)
        return usage_error(scene_file.string() + ": describes a video, which has no least confidence");
    const auto pictures = std::make_shared<ReadPictures>();
    pictures->trust_from(wanted.least_confidence);
    const SourceFile video(path / (video_source ? video_source->depth : ""));
    const std::string begin = first_bytes(video, telling_bytes);
    const bool is_recording = video_source && is_recording_of_ros(begin);
    auto reader = is_file        ? open_file(path, described, {}, wanted)
                  : is_recording ? open_file(video, described, {}, wanted)
                  : video_source
                      ? open_described_video(path, video, described, wanted)
                      : open_image_folder(path, described, {}, wanted.colour, pictures, wanted.alignment);
    if (reader) (*reader)->add_input(scene_file);
    return reader;
}

/// Of a LeRobot data set with one video of depth that video; of any other folder nothing.
Result<std::optional<fs::path>> lerobot_video_in(const fs::path& folder) {
    TRY_ASSIGN(const auto videos, lerobot_depth_videos(folder));
    if (videos.empty()) return std::optional<fs::path>{};
    if (videos.size() == 1) return std::optional(videos.front());
    return input_error(folder.string() + ": is a LeRobot data set with " + std::to_string(videos.size()) +
                       " videos of depth, each a clip of its own: touchable play " +
                       shell_word(videos.front().string()));
}

/// A folder that describes itself, or is guessed.
Opened open_folder(const fs::path& folder, const std::optional<SourceDescription>& known,
                   const OpenSettings& wanted) {
    const auto own = folder / own_scene_file;
    const bool has_own = is_file(own);
    if (has_own && known)
        return usage_error(own.string() + ": describes these pictures: leave camera, unit and preset out",
                           of_bare_pictures());
    if (has_own) return open_described(folder, own, wanted);
    TRY_ASSIGN(const auto lerobot, lerobot_video_in(folder));
    TRY_ASSIGN(const auto recording, ros2_recording_in(folder));
    if (const auto& only = lerobot ? lerobot : recording)
        return open_file(*only, std::nullopt, known.value_or(SourceDescription()), wanted);
    TRY_ASSIGN(auto guessed, guess_folder(folder, known.value_or(SourceDescription())));
    return with_inputs(
        open_image_folder(folder, guessed, {}, wanted.colour, guessed.pictures, wanted.alignment),
        guessed.inputs);
}

/// A file on a server that names other files: they are not fetched.
std::optional<Error> names_others(const SourceFile& file) {
    if (!is_gltf(file) && !is_scene_text(file) && !is_scene_file(file.path())) return std::nullopt;
    return input_error(file.string() +
                       ": names other files, which are not fetched from there; fetch them all, and open "
                       "them here");
}

/// A stream, or a file on a server.
Opened open_url(const fs::path& path, const std::optional<fs::path>& scene_file,
                const std::optional<SourceDescription>& known, const OpenSettings& wanted) {
    TRY_ASSIGN(const auto url, read_stream_url(path.string()));
    StreamSource source{.url = url};
    std::optional<SceneDescription> described;
    if (scene_file) {
        TRY_ASSIGN(described, read_scene_file(*scene_file));
    }
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) {
            if (auto refused = names_others(*found.file)) return std::move(*refused);
            auto reader = open_file(*found.file, described, known.value_or(SourceDescription()), wanted);
            if (const auto failure = found.end_opening()) return error_at(url.name(), *failure);
            if (reader) (*reader)->forget_inputs();
            return scene_file ? with_inputs(std::move(reader), {*scene_file}) : std::move(reader);
        }
        source.connection = std::move(found.stream);
    }
    if (known)
        return usage_error(
            url.name() + ": is a stream, which has its scene in it: leave camera, unit and preset out",
            of_bare_pictures());
    auto reader = open_stream_clip(source, described, wanted.colour);
    return scene_file ? with_inputs(std::move(reader), {*scene_file}) : std::move(reader);
}

/// The clip with pixels of depth and colour as they are stored. `known` says no least confidence.
Opened open_stored(const fs::path& path, const std::optional<fs::path>& scene_file,
                   const std::optional<SourceDescription>& known, const OpenSettings& wanted) {
    if (is_stream_url(path.string())) return open_url(path, scene_file, known, wanted);
    TRY_ASSIGN(const auto is_folder, leads_to_folder(path));
    if (!is_folder && path.extension() == ".m3u8" && !scene_file && !known)
        return open_stream_clip({.url = playlist_in_folder(path.string())}, {}, wanted.colour);
    if (known && scene_file)
        return usage_error(path.string() + ": a scene file describes it: leave camera, unit and preset out",
                           of_bare_pictures());
    std::error_code failure;
    const bool is_described =
        is_folder ? scene_file || fs::exists(path / own_scene_file, failure) : is_scene_file(path);
    if (wanted.least_confidence && !is_described && (is_folder || !is_npy_file(SourceFile(path))))
        return usage_error(path.string() +
                           ": is no .npz with an array conf, of which there could be a least confidence");
    if (!is_folder && is_scene_file(path)) {
        if (scene_file || known)
            return usage_error(path.string() + ": is a scene file itself: leave " +
                                   (scene_file ? "the other one" : "camera, unit and preset") + " out",
                               scene_file ? Hints{{Setting::scene_file}} : of_bare_pictures());
        return open_described(path.parent_path(), path, wanted);
    }
    if (scene_file) return open_described(path, *scene_file, wanted);
    auto reader = is_folder ? open_folder(path, known, wanted)
                            : open_file(path, std::nullopt, known.value_or(SourceDescription()), wanted);
    if (known && !known->file.empty()) return with_inputs(std::move(reader), {known->file});
    return reader;
}

Result<GuessedScene> guess_stored(const fs::path& path, const SourceDescription& known) {
    if (is_stream_url(path.string()))
        return usage_error(in_quotes(path.string()) + " is no file here; save it first: touchable convert " +
                           shell_word(path.string()) + " clip.mkv");
    TRY_ASSIGN(const auto is_folder, leads_to_folder(path));
    if (is_folder) {
        TRY_ASSIGN(const auto lerobot, lerobot_video_in(path));
        if (lerobot)
            return input_error(path.string() +
                               ": is a LeRobot data set, and a scene file is of its video: "
                               "touchable init-scene " +
                               shell_word(lerobot->string()));
        TRY_ASSIGN(const auto recording, ros2_recording_in(path));
        return recording ? guess_stored(*recording, known) : guess_folder(path, known);
    }
    return guess_file(SourceFile(path), known);
}

/// What was made of files that were read no further, because the caller gave up, may be wrong.
template <class Made>
Result<Made> unless_given_up(Result<Made> made) {
    return stop_requested() ? interrupted_error() : std::move(made);
}

}  // namespace

Result<SceneDescription> guess_clip(const fs::path& path, const SourceDescription& known) {
    TRY_ASSIGN(auto guessed, unless_given_up(guess_stored(path, known)));
    return SceneDescription(std::move(guessed));
}

std::vector<ClipFormat> clip_formats() {
    std::vector<ClipFormat> said;
    for (const Format& format : formats) said.push_back(format.said);
    said.push_back({"a folder of pictures, as cameras and data sets have them (TUM, Redwood, 7-Scenes, ...)",
                    "touchable play FOLDER"});
    said.push_back({"a folder, a picture, a video or two with a scene file (docs/scene_file.md)",
                    "touchable play FOLDER",
                    {{Setting::scene_file, "scene.json"}}});
    return said;
}

Result<std::unique_ptr<ClipReader>> open_clip(const fs::path& path, const std::optional<fs::path>& scene_file,
                                              const std::optional<SourceDescription>& known, Colour colour,
                                              DepthAlignment alignment) {
    OpenSettings wanted{colour, alignment, known ? known->least_confidence : std::nullopt};
    // With a least confidence alone the rest comes from a scene file, or from guesses.
    std::optional<SourceDescription> said = known;
    if (said) said->least_confidence.reset();
    if (said == SourceDescription()) said.reset();
    auto reader = open_stored(path, scene_file, said, wanted);
    return unless_given_up(reader ? with_pinhole_frames(std::move(*reader)) : std::move(reader));
}

}  // namespace touchable
