#include "engine/stream/stream_track.hpp"

#include <utility>

#include "engine/clip/block_addition.hpp"

namespace touchable {

Result<void> StreamTrack::check_size(const AVStream& stream, const std::string& where) {
    const AVCodecParameters& codec = *stream.codecpar;
    if (std::int64_t{codec.width} * codec.height <= most_stream_pixels) return {};
    return input_error(where + ": has pictures of " + std::to_string(codec.width) + "x" +
                       std::to_string(codec.height) + ": a stream's have at most " +
                       std::to_string(most_stream_pixels) + " pixels");
}

/// Says in `newest_` which frame it is of.
bool StreamTrack::is_sound(const AVPacket& packet) {
    constexpr std::int64_t largest_number = std::int64_t{1} << 60U;
    const auto addition = block_addition_of(packet);
    newest_ = {};
    if ((packet.flags & AV_PKT_FLAG_CORRUPT) != 0 || (addition && !addition->sound)) return false;
    if (!has_additions_) has_additions_ = addition.has_value();
    if (addition.has_value() != *has_additions_) return false;
    if (!addition) return true;
    newest_ = {addition->label, addition->frames};
    return !newest_.label || (newest_.label->frame >= 0 && newest_.label->frame < largest_number);
}

bool StreamTrack::depends_on_missing(const AVPacket& packet) {
    bool follows = true;
    if (newest_.label) {
        follows = next_number_ == newest_.label->frame;
        next_number_ = newest_.label->frame + newest_.frames;
    }
    if ((packet.flags & AV_PKT_FLAG_KEY) != 0) {
        if (waits_for_key_) forget();
        waits_for_key_ = false;
        return false;
    }
    waits_for_key_ = waits_for_key_ || !follows;
    return waits_for_key_;
}

void StreamTrack::forget() {
    decoder_.restart(0);
    sent_.clear();
}

StreamTrack::Outcome StreamTrack::torn() {
    forget();
    waits_for_key_ = true;
    return {{}, true, false};
}

Result<StreamTrack::Outcome> StreamTrack::take(const AVPacket& packet) {
    if (!is_sound(packet)) return torn();
    if (depends_on_missing(packet)) return Outcome{{}, false, true};
    sent_.push_back(newest_);
    return decode(&packet);
}

Result<StreamTrack::Outcome> StreamTrack::finish() {
    return decode(nullptr);
}

Result<StreamTrack::Outcome> StreamTrack::decode(const AVPacket* packet) {
    const auto failed = [this](const Error& error) -> Result<Outcome> {
        if (error.kind != ErrorKind::input) return error;
        return torn();
    };
    Outcome outcome;
    if (auto sent = decoder_.send(packet); !sent) return failed(sent.error());
    while (true) {
        auto picture = decoder_.receive();
        if (!picture) return failed(picture.error());
        if (!*picture || sent_.empty()) return outcome;
        const PlaneView& view = (*picture)->plane.view;
        if (std::int64_t{view.width} * view.height > most_stream_pixels) return torn();
        const Sent of = sent_.front();
        sent_.pop_front();
        outcome.pictures.push_back({role(), of.label ? of.label->frame : number_of_((*picture)->timestamp),
                                    of.frames, of.label ? of.label->taken_ns : 0,
                                    std::move((*picture)->plane)});
    }
}

}  // namespace touchable
