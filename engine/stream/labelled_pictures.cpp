// SPDX-License-Identifier: Apache-2.0
// Labelled pictures (LabelledDecoder) from MPEG-TS or HLS.

#include <algorithm>
#include <map>
#include <set>

#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/stream_pictures.hpp"

namespace touchable {
namespace {

/// Packets of a container that keeps neither names nor order of tracks.
class LabelledPackets {
public:
    struct Next {
        int track = 0;
        const AVStream* stream = nullptr;
        PacketPtr packet;
        std::int64_t step = 1;  ///< as in StreamPicture
    };
    virtual ~LabelledPackets() = default;
    /// Nothing after the last.
    virtual Result<std::optional<Next>> next() = 0;
    /// Number of its H.264 tracks, as far as it is known in advance.
    virtual int tracks() const = 0;
    virtual std::string how_it_ended() const = 0;
    virtual bool was_lost() const { return false; }
    virtual std::optional<StreamFigures::Levels> levels() const { return std::nullopt; }
};

class TransportStream final : public LabelledPackets {
public:
    TransportStream(std::shared_ptr<StreamBytes> bytes, std::unique_ptr<Demuxer> demuxer)
        : bytes_(std::move(bytes)), demuxer_(std::move(demuxer)) {}
    Result<std::optional<Next>> next() override {
        bytes_->allow(most_of_a_packet);
        TRY_ASSIGN(auto packet, demuxer_->next_packet());
        if (!packet) return std::optional<Next>();
        const int index = packet->stream_index;
        return std::optional(Next{index, demuxer_->container().streams[index], std::move(packet)});
    }
    int tracks() const override {
        const AVFormatContext& container = demuxer_->container();
        int tracks = 0;
        for (unsigned k = 0; k < container.nb_streams; ++k)
            tracks += container.streams[k]->codecpar->codec_id == AV_CODEC_ID_H264 ? 1 : 0;
        return tracks;
    }
    std::string how_it_ended() const override { return bytes_->how_it_ended(); }
    bool was_lost() const override { return bytes_->was_lost(); }

private:
    const std::shared_ptr<StreamBytes> bytes_;
    const std::unique_ptr<Demuxer> demuxer_;
};

class HlsPackets final : public LabelledPackets {
public:
    HlsPackets(std::shared_ptr<StreamWait> wait, std::unique_ptr<HlsInput> input)
        : wait_(std::move(wait)), input_(std::move(input)) {}
    Result<std::optional<Next>> next() override {
        TRY_ASSIGN(auto packet, wait_->in_time([this] { return input_->next(); }));
        if (!packet) return std::optional<Next>();
        constexpr int of_colour = 1000, of_low = 2000;
        const bool is_touch = packet->is_touch, is_low = packet->is_low;
        const int track = packet->stream->index + (is_touch ? 0 : of_colour);
        if (packet->stream->codecpar->codec_id == AV_CODEC_ID_H264) seen_.insert(track);
        return std::optional(Next{track + (is_low ? of_low : 0), packet->stream, std::move(packet->packet),
                                  is_touch && is_low ? hls_low_step : 1});
    }
    /// Each segment has all tracks.
    int tracks() const override { return static_cast<int>(seen_.size()); }
    std::string how_it_ended() const override {
        if (!was_lost()) return "has come to its end";
        return "left out " + std::to_string(input_->segments_lost()) + " of its segments, or cut them,";
    }
    bool was_lost() const override { return input_->segments_lost() > 0; }
    std::optional<StreamFigures::Levels> levels() const override { return input_->levels(); }

private:
    const std::shared_ptr<StreamWait> wait_;
    const std::unique_ptr<HlsInput> input_;
    std::set<int> seen_;
};

/// Only pictures show which planes a stream has, so those of its first frames are read at opening.
class LabelledPictures final : public StreamPictures {
public:
    LabelledPictures(std::unique_ptr<LabelledPackets> packets, std::string name)
        : packets_(std::move(packets)), name_(std::move(name)) {}

    Result<void> open(const std::optional<SceneDescription>& described) {
        constexpr std::size_t most_pictures = 256, most_kept = 64;
        described_ = described;
        is_described_ = described.has_value();
        std::size_t seen = 0;
        while (infos_.empty() || (!knows_all() && seen < most_pictures)) {
            const std::size_t before = first_.pictures.size();
            TRY_ASSIGN(const auto more, read(first_));
            if (!more) break;
            seen += first_.pictures.size() - before;
            while (first_.pictures.size() > most_kept || bytes_of_first() > most_bytes_waiting)
                first_.pictures.erase(first_.pictures.begin());
        }
        if (described_ && !infos_.empty() && infos_.front().role == "depth") return {};
        return input_error(name_ + ": " +
                           (has_ended_ ? packets_->how_it_ended() + " before it sent a" : "sends no") +
                           " picture of depth that says what it is");
    }

    const SceneDescription& described() const override { return *described_; }
    const std::string& scene_text() const override { return scene_text_; }
    const FrameRate& rate() const override { return described_->scene.rate; }
    std::vector<PlaneRole> roles() const override {
        std::vector<PlaneRole> all;
        for (const TrackInfo& track : infos_) all.push_back(*role_named(track.role));
        return all;
    }
    std::vector<TrackInfo> tracks() const override { return infos_; }
    void leave_out_colour() override { decoder_.leave_out_colour(); }

    Result<std::optional<Came>> next() override {
        Came came = std::exchange(first_, {});
        if (!came.pictures.empty()) return std::optional(std::move(came));
        TRY_ASSIGN(const auto more, read(came));
        if (!more) return std::optional<Came>();
        return std::optional(std::move(came));
    }

    std::string how_it_ended() const override { return packets_->how_it_ended(); }
    bool was_lost() const override { return packets_->was_lost(); }
    std::optional<StreamFigures::Levels> levels() const override { return packets_->levels(); }

private:
    /// False after the last.
    Result<bool> read(Came& came) {
        if (has_ended_) return false;
        TRY_ASSIGN(const auto packet, packets_->next());
        const std::int64_t damaged = decoder_.damaged();
        // Damaged colour does not make a frameset torn.
        const auto take_all = [&](Result<std::vector<LabelledPicture>> pictures) -> Result<void> {
            if (!pictures) return pictures.error();
            if (packet && !pictures->empty() && pictures->front().role == PlaneRole::colour)
                colour_streams_.insert(packet->track);
            if (!packet || !colour_streams_.contains(packet->track))
                came.torn += decoder_.damaged() - damaged;
            return take(std::move(*pictures), packet ? packet->step : 1, came);
        };
        if (!packet) {
            has_ended_ = true;
            TRY(take_all(decoder_.end()));
            return true;
        }
        const AVStream& stream = *packet->stream;
        const int number = packet->track;
        if (!tracks_.contains(number)) {
            // Before MPEG-TS has sent its tables, FFmpeg guesses a track's codec.
            if (stream.codecpar->codec_id != AV_CODEC_ID_H264) return true;
            auto track = decoder_.add_track(stream, name_);
            if (!track && track.error().kind == ErrorKind::internal) return track.error();
            tracks_[number] = track ? std::optional(*track) : std::nullopt;
        }
        if (!tracks_[number]) return true;
        TRY(take_all(decoder_.add(*tracks_[number], *packet->packet)));
        return true;
    }

    Result<void> take(std::vector<LabelledPicture> pictures, std::int64_t step, Came& came) {
        for (LabelledPicture& picture : pictures) {
            if (picture.scene) TRY(take_scene(*picture.scene));
            know(picture);
            if (picture.plane.view.empty()) continue;
            came.pictures.push_back({picture.role, picture.label.frame, 1, picture.label.taken_ns,
                                     std::move(picture.plane), step});
        }
        return {};
    }

    Result<void> take_scene(const std::string& json) {
        if (json == scene_text_) return {};
        if (!scene_text_.empty())
            return input_error(name_ + ": sends another scene than before: begin again to touch it");
        scene_text_ = json;
        if (is_described_) return {};
        TRY_ASSIGN(described_, parse_scene(json, name_ + ": its scene"));
        return {};
    }

    void know(const LabelledPicture& picture) {
        depth_pictures_ += picture.role == PlaneRole::depth ? 1 : 0;
        const std::string role(role_name(picture.role));
        const PlaneView& view = picture.plane.view;
        if (view.empty() || std::ranges::find(infos_, role, &TrackInfo::role) != infos_.end()) return;
        const std::string format = view.channels == 3 ? "rgb24"
                                   : picture.plane.bits > 8
                                       ? std::to_string(picture.plane.bits) + " bits in two tracks"
                                       : "gray";
        infos_.push_back({role, "h264", format, view.width, view.height, picture.role != PlaneRole::colour});
        std::ranges::sort(infos_, {}, [](const TrackInfo& track) { return *role_named(track.role); });
    }

    /// Whether the plane of each track, or one half of it, is known.
    bool knows_all() const {
        int known = 0;
        for (const TrackInfo& track : infos_) known += track.pixel_format.ends_with("in two tracks") ? 2 : 1;
        return described_ && depth_pictures_ >= 3 && known >= packets_->tracks();
    }

    std::size_t bytes_of_first() const {
        std::size_t bytes = 0;
        for (const StreamPicture& picture : first_.pictures) bytes += picture.plane.view.bytes();
        return bytes;
    }

    const std::unique_ptr<LabelledPackets> packets_;
    const std::string name_;
    LabelledDecoder decoder_{most_stream_pixels};
    std::map<int, std::optional<std::size_t>> tracks_;  // by stream; nothing: no plane
    std::set<int> colour_streams_;
    bool is_described_ = false;  // by the caller
    std::optional<SceneDescription> described_;
    std::string scene_text_;
    std::vector<TrackInfo> infos_;
    Came first_;  // pictures that came before all planes were known
    int depth_pictures_ = 0;
    bool has_ended_ = false;
};

Result<std::unique_ptr<StreamPictures>> open_packets(std::unique_ptr<LabelledPackets> packets,
                                                     const std::string& name,
                                                     const std::optional<SceneDescription>& described) {
    return opened_as<StreamPictures>(std::make_unique<LabelledPictures>(std::move(packets), name), described);
}

}  // namespace

Result<std::unique_ptr<StreamPictures>> open_transport_stream(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described) {
    bytes->allow(most_of_a_packet);
    TRY_ASSIGN(auto demuxer, Demuxer::open_live(bytes, name, "mpegts"));
    return open_packets(std::make_unique<TransportStream>(std::move(bytes), std::move(demuxer)), name,
                        described);
}

Result<std::unique_ptr<StreamPictures>> open_hls_stream(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const std::optional<SceneDescription>& described,
                                                        std::function<std::int64_t()> now_ns) {
    TRY_ASSIGN(auto input, wait->in_time([&] { return HlsInput::open(url.text, std::move(now_ns)); }));
    return open_packets(std::make_unique<HlsPackets>(std::move(wait), std::move(input)), url.name(),
                        described);
}

}  // namespace touchable
