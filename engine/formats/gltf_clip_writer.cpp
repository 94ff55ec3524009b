#include "engine/formats/gltf_clip_writer.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/hidden_folder.hpp"
#include "engine/clip/mp4_writer.hpp"
#include "engine/formats/gltf_scene.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {
namespace fs = std::filesystem;
namespace {

/// RFC 6381: what a player must know to decode it, of its parameters.
std::string codecs_of(const AVCodecParameters& stored) {
    if (stored.codec_id != AV_CODEC_ID_H264 || stored.extradata_size < 4) return "";
    return formatted("avc1.%02X%02X%02X", stored.extradata[1], stored.extradata[2], stored.extradata[3]);
}

/// Grey of 8 bits, near and far as they are stored.
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
        auto video =
            create_mp4_clip(hidden_.path() / name(".mp4"), described_, storage, Existing::keep, sound);
        if (!video) return as_named(video.error());
        video_ = std::move(*video);
        return {};
    }

    Result<void> write(const RawFrame& frame) override {
        if (frames_ == 0) first_ = frame;
        if (++frames_ > 1 && is_still_)
            return Error{ErrorKind::internal, place_.string() + ": is of one frame"};
        if (!video_) return {};
        auto written = video_->write(frame);
        return written.ok() ? written : as_named(written.error());
    }
    PlaneView stored_colour() const override { return video_ ? video_->stored_colour() : PlaneView{}; }
    bool is_full() const override { return video_ && video_->is_full(); }

    Result<fs::path> complete() override {
        if (frames_ == 0) return input_error(place_.string() + ": not written: no frame was given");
        GltfClipFiles files;
        if (auto stored = video_ ? end_video(files) : write_planes(files); !stored)
            return as_named(stored.error());
        if (auto shown = write_poster(files); !shown) return as_named(shown.error());
        const FallbackMesh mesh = fallback_mesh(first_, described_.scene);
        files.mesh = name(".bin");
        TRY(write_file(files.mesh, bytes_of_mesh(mesh)));
        const std::string text = gltf_scene(described_, files, mesh);
        TRY(write_file(place_.filename().string(), text));
        hidden_.sync();
        is_complete_ = true;
        return hidden_.path() / place_.filename();
    }

    Result<void> finish() override {
        if (!is_complete_) TRY(complete());
        return hidden_.move_to(place_.parent_path(), names_, existing_);
    }

private:
    std::string name(const std::string& end) const { return place_.stem().string() + end; }
    /// Messages speak of the place that the files are to have.
    Error as_named(Error error) const {
        const std::string hidden = hidden_.path().string(), home = place_.parent_path().string();
        for (auto at = error.message.find(hidden); at != std::string::npos;
             at = error.message.find(hidden, at + home.size()))
            error.message.replace(at, hidden.size(), home.empty() ? "." : home);
        return error;
    }

    Result<void> write_file(const std::string& name, const std::string& bytes) {
        names_.push_back(name);
        std::ofstream out(hidden_.path() / name, std::ios::binary);
        out << bytes;
        out.close();
        return out ? Result<void>{}
                   : input_error((place_.parent_path() / name).string() + ": cannot be written");
    }
    Result<void> write_picture(const std::string& name, const PlaneView& plane) {
        names_.push_back(name);
        return write_png_to(hidden_.path() / name, plane, place_.parent_path() / name, PngEffort::quick);
    }

    /// Which of its tracks is which plane, as their handlers' names say.
    Result<void> end_video(GltfClipFiles& files) {
        if (auto named = video_->finish(); !named) return named;
        files.video = name(".mp4");
        names_.push_back(files.video);
        TRY_ASSIGN(const auto opened, Demuxer::open_quicktime(SourceFile(hidden_.path() / files.video)));
        const AVFormatContext& container = opened->container();
        for (unsigned k = 0; k < container.nb_streams; ++k) {
            const AVStream& stream = *container.streams[k];
            const AVDictionaryEntry* handler = av_dict_get(stream.metadata, "handler_name", nullptr, 0);
            if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO || !handler) continue;
            std::string plane = handler->value;
            if (plane.ends_with(low_track_suffix))
                plane.resize(plane.size() - std::string_view(low_track_suffix).size());
            const auto role = role_named(plane);
            if (!role) continue;
            auto& stored = files.planes[static_cast<std::size_t>(*role)];
            if (!stored) stored.emplace();
            stored->tracks.push_back(files.tracks.size());
            files.tracks.push_back({static_cast<std::uint32_t>(stream.id), codecs_of(*stream.codecpar)});
        }
        return {};
    }

    Result<void> write_planes(GltfClipFiles& files) {
        for (const PlaneRole role : all_roles) {
            const PlaneView& plane = plane_of(first_, role);
            if (plane.empty()) continue;
            const std::string picture = name('_' + std::string(role_name(role)) + ".png");
            if (auto written = write_picture(picture, plane); !written) return written;
            files.planes[static_cast<std::size_t>(role)] = GltfPlane{{}, picture};
        }
        return {};
    }

    /// Of a still its colour serves.
    Result<void> write_poster(GltfClipFiles& files) {
        const auto& colour = files.planes[static_cast<std::size_t>(PlaneRole::colour)];
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
    std::unique_ptr<ClipWriter> video_;  // null: of a still
    RawFrame first_;
    std::int64_t frames_ = 0;
    std::vector<std::string> names_;  // in the order in which the files appear
    bool is_complete_ = false;
};

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_gltf_clip(const fs::path& path, const SceneDescription& described,
                                                     bool is_still, const ClipStorage& storage,
                                                     Existing existing,
                                                     const std::optional<SoundPart>& sound) {
    if (is_still && !touchable::is_still(path.stem().string()))
        return usage_error(path.string() + ": has a % or * in its name, which stand for numbers");
    auto writer = std::make_unique<GltfClipWriter>(path, described, is_still, existing);
    TRY(writer->open(storage, sound));
    return std::unique_ptr<ClipWriter>(std::move(writer));
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
