#include "engine/formats/touch_videos.hpp"

#include <string>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/codecs.hpp"
#include "engine/clip/resized_frame.hpp"
#include "engine/clip/still_planes.hpp"
#include "engine/clip/video_file.hpp"
#include "engine/formats/haptic_layers.hpp"
#include "engine/formats/video_picture.hpp"

namespace touchable {
namespace {

/// The pictures of all properties, joined for one frame after the other.
class TouchPictures {
public:
    explicit TouchPictures(const ClipReader& clip) : scene_(clip.scene()), frames_(clip.frame_count()) {}
    Result<StillPlane> open(const TouchSources& sources);
    Result<Plane> at(std::int64_t frame, std::int64_t time_ns);

private:
    /// A video or a picture, of which several properties may be channels.
    struct Layer {
        TouchSource source;
        std::unique_ptr<VideoFile> video{};  // null: a picture
        RgbConverter converter{};
        std::int64_t number = -1;  // of the picture that `plane` is
        Plane plane{};
    };
    struct Property {
        Layer* layer = nullptr;
        int channel = 0;
    };
    Result<void> open_layer(Layer& layer, std::size_t property, StillPlane& still);
    Result<bool> go_on(Layer& layer, std::int64_t frame, double seconds) const;
    bool is_by_number(const VideoFile& video) const { return frames_ && video.count() == *frames_; }

    Scene scene_;
    std::optional<std::int64_t> frames_;
    std::vector<std::unique_ptr<Layer>> layers_;
    std::array<Property, 3> properties_;
    Plane newest_;
};

Result<void> TouchPictures::open_layer(Layer& layer, std::size_t property, StillPlane& still) {
    if (layer.source.video.empty()) {
        TRY_ASSIGN(auto read, read_layer(layer.source.picture, layer.source.channel, property_names[property],
                                         still.notes));
        layer.plane = plane_from(Image{read.width, read.height, 1, 1, std::move(read.samples)});
        return {};
    }
    TRY_ASSIGN(auto video,
               VideoFile::open(SourceFile(layer.source.video), PlaneRole::haptic, layer.source.track));
    layer.video = std::move(video);
    const VideoFile& opened = *layer.video;
    if (opened.note()) still.notes.push_back(*opened.note());
    if (!is_by_number(opened))
        still.notes.push_back(std::string(property_names[property]) + " has " +
                              std::to_string(opened.count()) +
                              " frames, depth another number: each depth has what is nearest in time");
    return {};
}

/// Whether the layer shows another picture than before.
Result<bool> TouchPictures::go_on(Layer& layer, std::int64_t frame, double seconds) const {
    if (!layer.video) return false;
    VideoFile& video = *layer.video;
    const std::int64_t number = is_by_number(video) ? frame : video.nearest(seconds);
    if (number == layer.number) return false;
    TRY(video.seek(number));
    TRY_ASSIGN(auto picture, video.next());
    if (!picture) return input_error(video.where(number) + ": is missing");
    TRY_ASSIGN(auto rgb, VideoPicture(std::move(picture), layer.converter, video.where(number)).rgb());
    layer.plane = std::move(rgb);
    layer.number = number;
    return true;
}

Result<Plane> TouchPictures::at(std::int64_t frame, std::int64_t time_ns) {
    constexpr double ns_per_second = 1e9;
    bool is_other = newest_.view.empty();
    for (const auto& layer : layers_) {
        TRY_ASSIGN(const auto moved, go_on(*layer, frame, static_cast<double>(time_ns) / ns_per_second));
        is_other = is_other || moved;
    }
    if (!is_other) return newest_;
    Image joined{scene_.width, scene_.height, 1, 3, {}};
    joined.samples.resize(std::size_t{3} * static_cast<std::size_t>(scene_.width) *
                          static_cast<std::size_t>(scene_.height));
    for (std::size_t k = 0; k < properties_.size(); ++k) {
        if (!properties_[k].layer) continue;
        const PlaneView& from = properties_[k].layer->plane.view;
        const int channel = from.channels == 1 ? 0 : properties_[k].channel;
        const auto columns = nearest_samples(from.width, scene_.width),
                   rows = nearest_samples(from.height, scene_.height);
        std::uint8_t* to = joined.samples.data() + k;
        for (const int row : rows) {
            const std::uint8_t* const samples = from.row(row) + channel;
            for (const int column : columns) {
                *to = samples[std::ptrdiff_t{column} * from.channels];
                to += 3;
            }
        }
    }
    newest_ = plane_from(std::move(joined));
    return newest_;
}

/// What the plane is in frame 0, and what a person should know.
Result<StillPlane> TouchPictures::open(const TouchSources& sources) {
    StillPlane still{PlaneRole::haptic, {}, {"haptic", "", "rgb24", scene_.width, scene_.height}};
    const std::array<const PropertyRange*, 3> ranges{&scene_.haptic.stiffness, &scene_.haptic.static_friction,
                                                     &scene_.haptic.dynamic_friction};
    for (std::size_t k = 0; k < sources.size(); ++k) {
        const std::string property(property_names[k]), unit = k == 0 ? " N/mm" : "";
        if (!sources[k]) {
            still.notes.push_back(property + " is " + short_number(ranges[k]->min) + unit + " everywhere");
            continue;
        }
        still.notes.push_back(property + " goes from " + short_number(ranges[k]->min) + " to " +
                              short_number(ranges[k]->max) + unit);
        const TouchSource& wanted = *sources[k];
        const bool is_picture = wanted.video.empty();
        Layer* known = nullptr;
        for (const auto& layer : layers_) {
            const TouchSource& source = layer->source;
            const bool is_same = is_picture ? source.video.empty() && source.picture == wanted.picture &&
                                                  source.channel == wanted.channel
                                            : source.video == wanted.video && source.track == wanted.track;
            if (is_same) known = layer.get();
        }
        if (!known) {
            known = layers_.emplace_back(std::make_unique<Layer>(Layer{.source = wanted})).get();
            TRY(open_layer(*known, k, still));
            const auto& file = is_picture ? wanted.picture.file : wanted.video;
            if (!file.empty()) still.files.push_back(file);
        }
        properties_[k] = {known, wanted.channel};
    }
    TRY_ASSIGN(auto first, at(0, 0));
    still.plane = std::move(first);
    for (const auto& layer : layers_) {
        const PlaneView& view = layer->plane.view;
        if (view.width != scene_.width || view.height != scene_.height)
            still.notes.push_back(resampling_note(PlaneRole::haptic, view.width, view.height, scene_));
        if (!layer->video) continue;
        const TrackInfo stored = layer->video->info();
        still.info.codec = stored.codec;
        auto note = stored.lossless ? std::nullopt : lossy_note(PlaneRole::haptic, stored.codec);
        if (note && (still.notes.empty() || still.notes.back() != *note))
            still.notes.push_back(std::move(*note));
    }
    return still;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_touch_videos(Result<std::unique_ptr<ClipReader>> clip,
                                                      const TouchSources& sources) {
    if (!clip) return clip;
    const auto pictures = std::make_shared<TouchPictures>(**clip);
    TRY_ASSIGN(auto still, pictures->open(sources));
    still.at = [pictures](std::int64_t frame, std::int64_t time_ns) { return pictures->at(frame, time_ns); };
    const Scene scene = (*clip)->scene();
    std::vector<StillPlane> planes;
    planes.push_back(std::move(still));
    return with_still_planes(std::move(*clip), std::move(planes), scene);
}

}  // namespace touchable
