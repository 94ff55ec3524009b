#include "engine/formats/open_file.hpp"

#include <string>
#include <system_error>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip_file_reader.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/formats/azure_kinect_clip.hpp"
#include "engine/formats/bag_clip.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/bare_picture.hpp"
#include "engine/formats/depthkit_clip.hpp"
#include "engine/formats/gltf_clip.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/guessed_video.hpp"
#include "engine/formats/heic_image.hpp"
#include "engine/formats/jpeg_depth.hpp"
#include "engine/formats/mp4_stills.hpp"
#include "engine/formats/scene_text_clip.hpp"
#include "engine/formats/video_clip.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

/// A file that may be a clip.
struct Candidate {
    const SourceFile& source;
    const std::optional<SceneDescription>& described;  ///< to replace its own
    const SourceDescription& known;
    const OpenSettings wanted;
    const Colour colour = wanted.colour;
    const std::filesystem::path& file = source.path();
    const std::string begin = first_bytes(source, telling_bytes);
    /// Whether it is Matroska without anything that makes a clip of ours of it; nothing: nobody asked yet.
    mutable std::optional<bool> is_foreign{};
    /// Whether it is MP4 with tags of ours or an MPEG-4 scene; likewise.
    mutable std::optional<bool> is_mpeg4{};
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
/// Without anything that makes a clip of ours of it.
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
    if (!candidate.begin.starts_with("\x1a\x45\xdf\xa3")) return false;
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
    if (!candidate.is_mpeg4) {
        const bool is_described = candidate.described || !(candidate.known == SourceDescription());
        candidate.is_mpeg4 = is_mp4_clip(candidate.source, is_described);
    }
    return *candidate.is_mpeg4;
}

bool is_video(const Candidate& candidate) {
    return begins_like_video(candidate.begin) && !is_heic(candidate) && !is_matroska(candidate) &&
           !is_depthkit(candidate) && !is_mpeg4(candidate);
}

bool is_azure_kinect(const Candidate& candidate) {
    return candidate.begin.starts_with("\x1a\x45\xdf\xa3") && is_k4a_recording(candidate.source);
}

/// A scene stands for what is in it, also where it speaks of another file.
Opened open_video(const Candidate& candidate) {
    const auto folder = candidate.file.parent_path();
    if (!candidate.described) {
        TRY_ASSIGN(auto guessed, is_azure_kinect(candidate) ? guess_k4a(candidate.source, candidate.known)
                                                            : guess_video(candidate.source, candidate.known));
        return with_inputs(
            open_video_clip(folder, guessed, candidate.colour, guessed.video, candidate.wanted.alignment),
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
    std::filesystem::path file;
    SceneDescription described;
};
std::optional<SceneBeside> scene_beside(const std::filesystem::path& picture) {
    std::filesystem::path file = picture;
    file.replace_extension(".json");
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) return {};
    auto described = read_scene_file(file);
    if (!described) return {};
    const auto& folder = described->scene.folder;
    if (!folder || folder->depth != picture.filename()) return {};
    return SceneBeside{std::move(file), std::move(*described)};
}

Opened open_picture(const Candidate& candidate) {
    const auto opened = std::make_shared<ReadPictures>(candidate.source);
    opened->trust_from(candidate.wanted.least_confidence);
    if (candidate.described)
        return open_bare_picture(candidate.file, *candidate.described, {}, candidate.colour, opened,
                                 candidate.wanted.alignment);
    if (auto own = scene_beside(candidate.file); own && candidate.known == SourceDescription())
        return with_inputs(open_bare_picture(candidate.file, std::move(own->described),
                                             {"described by " + own->file.filename().string()},
                                             candidate.colour, opened, candidate.wanted.alignment),
                           {own->file});
    SourceDescription known = candidate.known;
    known.least_confidence = candidate.wanted.least_confidence;
    TRY_ASSIGN(auto guessed, guess_picture(candidate.source, known));
    return with_inputs(open_bare_picture(candidate.file, guessed, {}, candidate.colour, guessed.pictures,
                                         candidate.wanted.alignment),
                       guessed.inputs);
}

/// With depth in its metadata, or of depth itself: where somebody says what it is, or it is grey all over.
Opened open_jpeg(const Candidate& candidate) {
    const auto is_grey_picture = [&] {
        const auto stored = read_stored_image(candidate.source);
        return stored && is_grey(stored->image);
    };
    const bool is_described = !(candidate.known == SourceDescription());
    const bool is_depth = !has_jpeg_depth(candidate.source) && (is_described || is_grey_picture());
    if (stop_requested()) return interrupted_error();
    return is_depth ? open_picture(candidate)
                    : open_jpeg_depth(candidate.source, candidate.described, candidate.known);
}

Opened open_mpeg4(const Candidate& candidate) {
    const auto open = is_mp4_stills(candidate.source) ? open_mp4_stills : open_mp4_clip;
    return open(candidate.source, candidate.described, candidate.colour);
}

/// The first that recognises a file opens it.
struct Format {
    bool (*recognises)(const Candidate&);
    Opened (*open)(const Candidate&);
    ClipFormat said;
};
const Format formats[] = {
    {is_matroska,
     [](const Candidate& c) { return open_matroska_clip(c.source, c.described, c.colour); },
     {"a touchable clip (Matroska with its scene attached)", "touchable play clip.mkv"}},
    {is_mpeg4,
     open_mpeg4,
     {"a touchable clip in MP4, as its MPEG-4 scene describes it", "touchable play clip.mp4"}},
    {[](const Candidate& c) { return is_scene_text(c.source); },
     [](const Candidate& c) { return open_scene_text(c.source, c.described, c.colour); },
     {"the text of an MPEG-4 scene, beside the pictures that it names", "touchable play scene.bt"}},
    {[](const Candidate& c) { return is_gltf(c.source); },
     [](const Candidate& c) { return open_gltf_clip(c.source, c.described, c.colour); },
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
     [](const Candidate& c) { return open_bag_clip(c.source, c.described, c.known, c.colour); },
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

/// As it says itself what a camera, a unit or a preset would.
Error refused_description(const Candidate& candidate) {
    const std::string name = candidate.file.string();
    if (!has_scene(candidate))
        return usage_error(
            name + ": is no picture, so a camera, a unit or a preset says nothing of it: leave them out",
            of_bare_pictures());
    return usage_error(name +
                           ": is no picture and has its scene in it, which a camera, a unit or a preset does "
                           "not change: leave "
                           "them out, or write that scene to a file (touchable init-scene " +
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
    if (reader && candidate.colour == Colour::left_out) (*reader)->leave_out_colour();
    return reader;
}

/// That of a clip of ours, without the files that it once was of.
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
std::filesystem::path free_name(const std::filesystem::path& clip, const char* extension) {
    const std::filesystem::path stem = clip.parent_path() / clip.stem();
    std::filesystem::path name = stem;
    name += extension;
    std::error_code ignored;
    for (int n = 2; std::filesystem::exists(name, ignored); ++n) {
        name = stem;
        name += '-' + std::to_string(n) + extension;
    }
    if (*extension == '\0' && !name.extension().empty()) name /= "";
    return name;
}

/// What a scene file would say of it, it says itself; nothing where there is something to guess.
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

}  // namespace

Opened with_inputs(Opened reader, const std::vector<std::filesystem::path>& inputs) {
    if (reader)
        for (const auto& input : inputs) (*reader)->add_input(input);
    return reader;
}

Opened open_described_video(const std::filesystem::path& folder, const SourceFile& depth,
                            const SceneDescription& described, const OpenSettings& wanted) {
    TRY_ASSIGN(auto opened, VideoFile::open(depth, PlaneRole::depth));
    return open_video_clip(folder, described, wanted.colour, std::move(opened), wanted.alignment);
}

Hints of_bare_pictures() {
    return {{Setting::intrinsics}, {Setting::field_of_view}, {Setting::depth_unit}, {Setting::preset}};
}

Opened open_file(const SourceFile& source, const std::optional<SceneDescription>& described,
                 const SourceDescription& known, const OpenSettings& wanted) {
    const Candidate candidate{source, described, known, wanted};
    const std::filesystem::path& file = candidate.file;
    const bool describes_itself = !is_picture(candidate) && !is_jpeg(candidate) && !is_heic(candidate) &&
                                  !is_video(candidate) && !is_ros_recording(candidate);
    if (describes_itself && !(known == SourceDescription())) return refused_description(candidate);
    // A scene's text may name pictures; the reader of the videos that it names instead knows what they cannot
    // be.
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
    return input_error(
        file.string() +
        ": is not a Matroska file, nor a video, nor glTF, nor the text of an MPEG-4 scene, nor a "
        "recording of ROS (.bag, .mcap, .db3), nor a "
        "picture of depth (PNG, PGM, TIFF, PFM, "
        "EXR, NumPy), nor a "
        "JPEG or HEIC with depth, nor a Depthkit video with " +
        depthkit_metadata_name(file).string() + " beside it");
}

Result<GuessedScene> guess_file(const SourceFile& source, const SourceDescription& known) {
    const std::optional<SceneDescription> none;
    const Candidate candidate{source, none, known, {}};
    if (auto refused = nothing_to_guess(candidate)) return std::move(*refused);
    if (has_scene(candidate))
        return known == SourceDescription() ? scene_in(candidate)
                                            : Result<GuessedScene>(refused_description(candidate));
    return is_ros_recording(candidate)  ? guess_bag(source, known)
           : is_azure_kinect(candidate) ? guess_k4a(source, known)
           : is_video(candidate)        ? guess_video(source, known)
                                        : guess_picture(source, known);
}

std::vector<ClipFormat> file_formats() {
    std::vector<ClipFormat> said;
    for (const Format& format : formats) said.push_back(format.said);
    return said;
}

}  // namespace touchable
