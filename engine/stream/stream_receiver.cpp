#include "engine/stream/stream_receiver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/clip/plane_role.hpp"
#include "engine/video/clip_container.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/plane_notes.hpp"

namespace touchable {
namespace {

constexpr std::uint64_t most_of_a_header = std::uint64_t{16} << 20,
                        most_of_a_packet = std::uint64_t{256} << 20;

}  // namespace

std::size_t bytes_of_planes(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(plane->width) * static_cast<std::size_t>(plane->height) *
                 static_cast<std::size_t>(plane->channels * plane->bytes_per_sample);
    return bytes;
}

Result<std::unique_ptr<StreamReceiver>> StreamReceiver::open(const StreamSource& source) {
    std::unique_ptr<StreamReceiver> receiver(new StreamReceiver(source.url.name()));
    receiver->wait_ = source.wait;
    receiver->bytes_ = source.connection;
    if (!receiver->bytes_) {
        auto bytes = StreamBytes::connect(source.url, source.wait, source.patience);
        if (!bytes) return error_at(receiver->name_, bytes.error());
        receiver->bytes_ = std::move(*bytes);
    }
    source.wait->at_most(source.patience.frameset);
    if (auto opened = receiver->open_matroska(source); !opened) return opened.error();
    if (auto read = receiver->read_first(); !read) return read.error();
    return receiver;
}

Result<void> StreamReceiver::open_matroska(const StreamSource& source) {
    bytes_->allow(most_of_a_header);
    auto demuxer = Demuxer::open_live(bytes_, name_, "matroska");
    if (!demuxer) return demuxer.error();
    demuxer_ = std::move(*demuxer);
    const auto container = matroska_container(SourceFile(std::filesystem::path(name_)));
    auto rate = container->rate(*demuxer_);
    if (!rate) return rate.error();
    recorded_rate_ = std::move(*rate);
    scene_text_ = demuxer_->attachment(clip_tags::scene_file).value_or("");
    const auto described = source.described ? Result<SceneDescription>(*source.described)
                                            : container->scene(*demuxer_, recorded_rate_);
    if (!described) return described.error();
    if (!described->unstated.rate)
        if (auto note = clip_tags::rate_note(described->scene.rate, recorded_rate_))
            notes_.push_back(std::move(*note));
    auto scene = settle(*described, {.rate = recorded_rate_});
    if (!scene) return error_at(name_, scene.error());
    scene_ = std::move(*scene);
    unstated_ = described->unstated;
    const auto found = container->tracks(*demuxer_, scene_);
    if (!found) return found.error();
    std::vector<PlaneRole> roles;
    for (const ClipTrack& track : *found) {
        auto decoder = TrackDecoder::open(*demuxer_->container().streams[track.stream], track.role, name_);
        if (!decoder) return decoder.error();
        tracks_.emplace_back(
            std::move(*decoder), track.stream,
            [this, stream = track.stream](std::int64_t timestamp) { return number_of(stream, timestamp); });
        roles.push_back(track.role);
    }
    assembler_.emplace(roles);
    return {};
}

Result<void> StreamReceiver::read_first() {
    auto first = next(std::chrono::milliseconds::max());
    if (!first) return first.error();
    if (!*first) return input_error(name_ + ": " + how_it_ended() + " before it sent a whole frameset");
    for (const StreamTrack& track : tracks_)
        if (!track.info().pixel_format.empty()) infos_.push_back(track.info());
    const auto notes = describe_planes(infos_, (*first)->frame, scene_);
    notes_.insert(notes_.end(), notes.begin(), notes.end());
    first_ = std::move(*first);
    return {};
}

bool StreamReceiver::is_like(const StreamReceiver& other) const {
    const auto is_same = [](const TrackInfo& a, const TrackInfo& b) {
        return a.role == b.role && a.width == b.width && a.height == b.height;
    };
    return scene_text_ == other.scene_text_ &&
           std::equal(infos_.begin(), infos_.end(), other.infos_.begin(), other.infos_.end(), is_same);
}

/// By the first one's time, to the nearest frame.
std::int64_t StreamReceiver::number_of(int stream, std::int64_t timestamp) {
    constexpr double latest_seconds = 4e9, ns_per_second = 1e9;
    if (timestamp == AV_NOPTS_VALUE) return 0;
    const double seconds =
        static_cast<double>(timestamp) * av_q2d(demuxer_->container().streams[stream]->time_base);
    if (!origin_seconds_) origin_seconds_ = seconds;
    const double since = seconds - *origin_seconds_;
    if (!(since >= 0 && since < latest_seconds)) return 0;
    return recorded_rate_.nearest(std::llround(since * ns_per_second));
}

Result<void> StreamReceiver::take(StreamTrack& track, Result<StreamTrack::Outcome> outcome) {
    if (!outcome) return outcome.error();
    if (outcome->is_torn) assembler_->add_torn(track.role());
    for (StreamPicture& picture : outcome->pictures) {
        auto fits = fit_plane(track.role(), std::move(picture.plane), scene_,
                              track.name() + ", frame " + std::to_string(picture.number));
        if (!fits) return fits.error();
        picture.plane = std::move(*fits);
        assembler_->add(std::move(picture));
    }
    return {};
}

/// False after the last.
Result<bool> StreamReceiver::read_packet() {
    bytes_->allow(most_of_a_packet);
    const auto packet = demuxer_->next_packet();
    if (!packet) return packet.error();
    if (!*packet) {
        for (StreamTrack& track : tracks_)
            if (auto taken = take(track, track.finish()); !taken) return taken.error();
        assembler_->end();
        return false;
    }
    for (StreamTrack& track : tracks_) {
        if (track.stream() != (*packet)->stream_index) continue;
        if (track.role() == PlaneRole::colour && !with_colour_) return true;
        if (auto taken = take(track, track.take(**packet)); !taken) return taken.error();
    }
    return true;
}

Received StreamReceiver::received(Frameset frameset) const {
    Received received{frameset.number, frameset.taken_ns, {}};
    if (received.sent_ns == 0) received.sent_ns = recorded_rate_.time_ns(frameset.number) + 1;
    for (const PlaneRole role : all_roles) {
        Plane& plane = frameset.planes[static_cast<std::size_t>(role)];
        if (!plane.view.empty()) add_plane(received.frame, role, std::move(plane));
    }
    return received;
}

Result<std::optional<Received>> StreamReceiver::next(std::chrono::milliseconds longest) {
    if (first_) return std::exchange(first_, std::nullopt);
    if (longest != std::chrono::milliseconds::max()) wait_->at_most(longest);
    while (true) {
        if (auto whole = assembler_->take()) return std::optional(received(std::move(*whole)));
        if (has_ended_) return std::optional<Received>();
        const auto more = read_packet();
        if (!more) return more.error();
        has_ended_ = !*more;
    }
}

}  // namespace touchable
