#include "engine/formats/azure_kinect_clip.hpp"

#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/video_file.hpp"
#include "engine/formats/azure_kinect_calibration.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/picture/demuxer.hpp"

namespace touchable {
namespace {

constexpr const char* calibration_file = "calibration.json";

/// Of the track of this name.
std::optional<PictureSize> size_of_track(const AVFormatContext& container, const std::string& name) {
    for (unsigned k = 0; k < container.nb_streams; ++k) {
        const AVStream& stream = *container.streams[k];
        const AVDictionaryEntry* const title = av_dict_get(stream.metadata, "title", nullptr, 0);
        if (stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && title != nullptr && name == title->value)
            return PictureSize{stream.codecpar->width, stream.codecpar->height};
    }
    return {};
}

Result<StoredImage> first_depth(VideoFile& video) {
    TRY_ASSIGN(auto frame, video.next());
    if (!frame) return input_error(video.where(0) + ": is missing");
    RgbConverter converter;
    VideoPicture picture(std::move(frame), converter, video.where(0));
    TRY_ASSIGN(const auto plane, picture.depth(VideoValues::grey, {0, 0, picture.width(), picture.height()}));
    const PlaneView& view = plane.view;
    if (view.bytes_per_sample != 2)
        return input_error(video.where(0) + ": is no depth of 16 bits, as this camera records it");
    StoredImage stored;
    stored.bits = 16;
    stored.image = {view.width, view.height, 2, 1, {}};
    for (int y = 0; y < view.height; ++y)
        stored.image.samples.insert(stored.image.samples.end(), view.row(y),
                                    view.row(y) + std::ptrdiff_t{2} * view.width);
    return stored;
}

}  // namespace

bool is_k4a_recording(const SourceFile& file) {
    const auto opened = Demuxer::open_matroska(file);
    return opened && ((*opened)->tag("K4A_DEPTH_MODE") || (*opened)->attachment(calibration_file)) &&
           size_of_track((*opened)->container(), "DEPTH");
}

Result<GuessedScene> guess_k4a(const SourceFile& file, const SourceDescription& known) {
    TRY_ASSIGN(const auto demuxer, Demuxer::open_matroska(file));
    const auto depth_size = size_of_track(demuxer->container(), "DEPTH"),
               colour_size = size_of_track(demuxer->container(), "COLOR");
    if (!depth_size) return input_error(file.string() + ": has no track DEPTH");
    TRY_ASSIGN(auto video, VideoFile::open(file, PlaneRole::depth));
    TRY_ASSIGN(const auto first, first_depth(*video));
    SourceDescription said = known;
    constexpr double millimetre = 0.001;
    if (!said.metres_per_code && said.preset.empty()) said.metres_per_code = millimetre;
    std::optional<K4aCameras> cameras;
    std::vector<Remark> remarks;
    const bool is_told = said.intrinsics || said.fov;
    if (const auto text = demuxer->attachment(calibration_file); text && !is_told) {
        TRY_ASSIGN(auto read, parse_azure_kinect_calibration(*text, *depth_size, colour_size,
                                                             file.string() + ": its " + calibration_file));
        cameras = std::move(read);
        const Camera& camera = cameras->depth;
        if (!(camera.fx > 0) || !(camera.fy > 0))
            return input_error(file.string() + ": its " + calibration_file +
                               ": the depth camera's focal lengths must be above 0");
        said.intrinsics = Intrinsics{camera.fx, camera.fy, camera.cx, camera.cy};
        add_remark(remarks, {"the cameras are those of the recording's calibration.json"});
    }
    auto guessed = guess_scene(file.path().parent_path(), first, said);
    if (!guessed) return error_at(file.string(), guessed.error());
    Scene& scene = guessed->scene;
    scene.name = file.path().stem().string();
    scene.rate = video->rate();
    scene.video.emplace().depth = file.path().filename().string();
    if (colour_size) scene.video->colour = scene.video->depth;
    if (cameras) {
        scene.lens = cameras->depth_lens;
        scene.colour_camera = cameras->colour;
    }
    if (colour_size && !scene.colour_camera)
        add_remark(remarks,
                   {"colour is not brought onto depth's pixels, as nothing says how its camera stands"});
    if (auto valid = validate(scene); !valid)
        return input_error(file.string() + ": its " + calibration_file + ": " + valid.error().message);
    scene.remarks = joined_remarks(std::move(remarks), scene.remarks);
    guessed->video = std::move(video);
    return guessed;
}

}  // namespace touchable
