#include "engine/stream/stream_receiver.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/clip/plane_notes.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/stream/stream_audience.hpp"

namespace touchable {
namespace {

/// Why a sender refuses a listener (StreamServer), behind its first byte; empty: it sends something else.
std::string refusal_in(StreamBytes& bytes) {
    constexpr std::size_t longest = 200;
    std::string line;
    bytes.allow(longest);
    for (std::uint8_t letter = 0; line.size() < longest && line.find('\n') == std::string::npos;) {
        const auto got = bytes.read(&letter, 1);
        if (!got || *got == 0) break;
        line += static_cast<char>(letter);
        if (!stream_refusal.starts_with(line.substr(0, stream_refusal.size()))) return "";
    }
    if (line.size() <= stream_refusal.size()) return "";
    return line.substr(stream_refusal.size(), line.find('\n') - stream_refusal.size());
}

}  // namespace

std::size_t bytes_of_planes(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(plane->width) * static_cast<std::size_t>(plane->height) *
                 static_cast<std::size_t>(plane->channels * plane->bytes_per_sample);
    return bytes;
}

Result<std::unique_ptr<StreamReceiver>> StreamReceiver::open(const StreamSource& source) {
    std::unique_ptr<StreamReceiver> receiver(new StreamReceiver(source));
    const bool is_called =
        source.url.transport == StreamTransport::srt && source.url.value("mode") == "listener";
    const auto until_called = is_called ? source.patience.caller : std::chrono::milliseconds(0);
    if (!source.wait->is_together()) source.wait->together_at_most(until_called + source.patience.opening);
    auto begun = receiver->connect(source);
    if (begun) begun = receiver->read_first();
    source.wait->each_alone();
    if (!begun) return begun.error();
    return receiver;
}

Result<void> StreamReceiver::connect(const StreamSource& source) {
    if (source.url.is_playlist()) {
        wait_->at_most(source.patience.opening);
        TRY_ASSIGN(auto pictures, open_hls_stream(source.url, wait_, source.described, source.now_ns));
        pictures_ = std::move(pictures);
        return {};
    }
    std::shared_ptr<StreamBytes> bytes = source.connection;
    if (!bytes) {
        auto connected = StreamBytes::connect(source.url, source.wait, source.patience);
        if (!connected) return error_at(name_, connected.error());
        bytes = std::move(*connected);
    }
    bytes_ = bytes;
    wait_->at_most(source.patience.frameset);
    bytes->allow(1);
    const auto first = bytes->peek();
    if (!first) return error_at(name_, first.error());
    const bool is_transport_stream = *first == 0x47;  // its packets begin so
    constexpr int first_of_matroska = 0x1a;
    if (!is_transport_stream && *first != first_of_matroska) {
        if (const std::string why = refusal_in(*bytes); !why.empty())
            return input_error(name_ + ": the sender refuses: " + printable(why));
        return input_error(name_ +
                           ": sends neither Matroska nor MPEG-TS; right would be a touchable serve there");
    }
    TRY_ASSIGN(auto pictures, (is_transport_stream ? open_transport_stream : open_matroska_pictures)(
                                  std::move(bytes), name_, source.described));
    pictures_ = std::move(pictures);
    return {};
}

Result<void> StreamReceiver::read_first() {
    const SceneDescription& described = pictures_->described();
    if (!described.unstated.rate)
        if (auto note = clip_tags::rate_note(described.scene.rate, pictures_->rate()))
            notes_.push_back(std::move(*note));
    auto scene = settle(described, {.rate = pictures_->rate()});
    if (!scene) return error_at(name_, scene.error());
    scene_ = std::move(*scene);
    scene_text_ = pictures_->scene_text();
    unstated_ = described.unstated;
    assembler_.emplace(pictures_->roles());
    TRY_ASSIGN(auto first, next(std::chrono::milliseconds::max()));
    if (!first) return input_error(name_ + ": " + how_it_ended() + " before it sent a whole frameset");
    tracks_ = pictures_->tracks();
    const auto notes = describe_planes(tracks_, first->frame, scene_);
    notes_.insert(notes_.end(), notes.begin(), notes.end());
    first_ = std::move(first);
    return {};
}

bool StreamReceiver::is_like(const StreamReceiver& other) const {
    const auto is_same = [](const TrackInfo& a, const TrackInfo& b) {
        return a.role == b.role && a.width == b.width && a.height == b.height;
    };
    return scene_text_ == other.scene_text_ &&
           std::equal(tracks_.begin(), tracks_.end(), other.tracks_.begin(), other.tracks_.end(), is_same);
}

Result<void> StreamReceiver::take(StreamPictures::Came came) {
    assembler_->add_torn(came.torn);
    for (StreamPicture& picture : came.pictures) {
        if (picture.role == PlaneRole::colour && !with_colour_) continue;
        TRY_ASSIGN(auto fits, fit_plane(picture.role, std::move(picture.plane), scene_,
                                        name_ + ": " + std::string(role_name(picture.role)) + ", frame " +
                                            std::to_string(picture.number)));
        picture.plane = std::move(fits);
        assembler_->add(std::move(picture));
    }
    return {};
}

Received StreamReceiver::received(WholeFrameset frameset) const {
    Received received{frameset.number, frameset.taken_ns, {}};
    if (received.sent_ns == 0) received.sent_ns = scene_.rate.time_ns(frameset.number) + 1;
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
        TRY_ASSIGN(auto came, pictures_->next());
        if (came) {
            TRY(take(std::move(*came)));
        } else {
            has_ended_ = true;
            assembler_->end();
        }
    }
}

}  // namespace touchable
