#include <cmath>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_container.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/stream/matroska_gate.hpp"
#include "engine/stream/stream_pictures.hpp"
#include "engine/stream/stream_track.hpp"

namespace touchable {
namespace {

class MatroskaPictures final : public StreamPictures {
public:
    MatroskaPictures(std::shared_ptr<StreamBytes> bytes, std::string name)
        : bytes_(std::move(bytes)), name_(std::move(name)) {}
    Result<void> open(const std::optional<SceneDescription>& described);

    const SceneDescription& described() const override { return described_; }
    const std::string& scene_text() const override { return scene_text_; }
    const FrameRate& rate() const override { return rate_; }
    std::vector<PlaneRole> roles() const override {
        std::vector<PlaneRole> all;
        for (const StreamTrack& track : tracks_) all.push_back(track.role());
        return all;
    }
    std::vector<TrackInfo> tracks() const override {
        std::vector<TrackInfo> all;
        for (const StreamTrack& track : tracks_)
            if (!track.info().pixel_format.empty()) all.push_back(track.info());
        return all;
    }
    void leave_out_colour() override { with_colour_ = false; }
    Result<std::optional<Came>> next() override;
    std::string how_it_ended() const override { return bytes_->how_it_ended(); }
    bool was_lost() const override { return bytes_->was_lost() || gate_->is_cut(); }

private:
    static Result<void> add(PlaneRole role, Result<StreamTrack::Outcome> outcome, Came& came);
    std::int64_t number_of(int stream, std::int64_t timestamp);

    const std::shared_ptr<StreamBytes> bytes_;
    const std::shared_ptr<MatroskaGate> gate_ = std::make_shared<MatroskaGate>(bytes_);
    const std::string name_;
    std::unique_ptr<Demuxer> demuxer_;
    SceneDescription described_;
    std::string scene_text_;
    FrameRate rate_;
    std::optional<double> origin_seconds_;
    std::vector<StreamTrack> tracks_;
    bool with_colour_ = true, has_ended_ = false;
};

Result<void> MatroskaPictures::open(const std::optional<SceneDescription>& described) {
    bytes_->allow(most_of_a_header);
    TRY_ASSIGN(auto demuxer, Demuxer::open_live(gate_, name_, "matroska"));
    demuxer_ = std::move(demuxer);
    const auto container = matroska_container(SourceFile(std::filesystem::path(name_)));
    TRY_ASSIGN(auto rate, container->rate(*demuxer_));
    rate_ = std::move(rate);
    scene_text_ = demuxer_->attachment(clip_tags::scene_file).value_or("");
    TRY_ASSIGN(auto said,
               described ? Result<SceneDescription>(*described) : container->scene(*demuxer_, rate_));
    described_ = std::move(said);
    TRY_ASSIGN(const auto found, container->tracks(*demuxer_, described_.scene));
    for (const ClipTrack& track : found) {
        const std::string where = name_ + ": track " + std::string(role_name(track.role));
        TRY(StreamTrack::check_size(*demuxer_->container().streams[track.stream], where));
        TRY_ASSIGN(auto decoder,
                   TrackDecoder::open(*demuxer_->container().streams[track.stream], track.role, name_));
        tracks_.emplace_back(
            std::move(decoder), track.stream,
            [this, stream = track.stream](std::int64_t timestamp) { return number_of(stream, timestamp); });
    }
    return {};
}

/// By the first one's time, to the nearest frame.
std::int64_t MatroskaPictures::number_of(int stream, std::int64_t timestamp) {
    constexpr double latest_seconds = 4e9, ns_per_second = 1e9;
    if (timestamp == AV_NOPTS_VALUE) return 0;
    const double seconds =
        static_cast<double>(timestamp) * av_q2d(demuxer_->container().streams[stream]->time_base);
    if (!origin_seconds_) origin_seconds_ = seconds;
    const double since = seconds - *origin_seconds_;
    if (!(since >= 0 && since < latest_seconds)) return 0;
    return rate_.nearest(std::llround(since * ns_per_second));
}

/// No frameset is missed because its colour is damaged.
Result<void> MatroskaPictures::add(PlaneRole role, Result<StreamTrack::Outcome> outcome, Came& came) {
    if (!outcome) return outcome.error();
    came.torn += outcome->is_torn && role != PlaneRole::colour ? 1 : 0;
    for (StreamPicture& picture : outcome->pictures) came.pictures.push_back(std::move(picture));
    return {};
}

Result<std::optional<StreamPictures::Came>> MatroskaPictures::next() {
    Came came;
    if (has_ended_) return std::optional<Came>();
    bytes_->allow(most_of_a_packet);
    TRY_ASSIGN(const auto packet, demuxer_->next_packet());
    has_ended_ = !packet;
    for (StreamTrack& track : tracks_) {
        if (packet && track.stream() != packet->stream_index) continue;
        if (track.role() == PlaneRole::colour && !with_colour_) continue;
        auto outcome = packet ? track.take(*packet) : track.finish();
        TRY(add(track.role(), std::move(outcome), came));
    }
    return std::optional(std::move(came));
}

}  // namespace

Result<std::unique_ptr<StreamPictures>> open_matroska_pictures(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described) {
    auto pictures = std::make_unique<MatroskaPictures>(std::move(bytes), name);
    TRY(pictures->open(described));
    return std::unique_ptr<StreamPictures>(std::move(pictures));
}

}  // namespace touchable
