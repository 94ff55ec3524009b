#include "engine/stream/labelled_decoder.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/codecs.hpp"
#include "engine/picture/decoded_picture.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_tracks = 16;
/// So many halves of a plane wait for the others: tracks of one frame come close to each other.
constexpr std::size_t most_halves = 8;
constexpr AVRational nanosecond{1, 1'000'000'000};

Error no_memory() {
    return {ErrorKind::internal, "a stream's pictures: out of memory"};
}

/// What the picture says of itself and of the scene.
struct SaidOf {
    std::optional<ReadSei> picture;
    std::shared_ptr<const std::string> scene;
    bool is_one = true;  // picture: not of two, which are then mixed up
};

SaidOf messages_in(const AVFrame& frame) {
    SaidOf said;
    for (int k = 0; k < frame.nb_side_data; ++k) {
        const AVFrameSideData& side = *frame.side_data[k];
        if (side.type != AV_FRAME_DATA_SEI_UNREGISTERED) continue;
        auto sei = read_sei({side.data, side.size});
        if (!sei) continue;
        if (sei->scene) {
            said.scene = std::make_shared<const std::string>(std::move(*sei->scene));
        } else {
            said.is_one = !said.picture;
            said.picture = std::move(sei);
        }
    }
    return said;
}

std::optional<Plane> rgb_plane(RgbConverter& converter, const AVFrame& frame) {
    auto rgb = converter.converted(frame);
    if (!rgb) return std::nullopt;
    const AVFrame& made = **rgb;
    const PlaneView view{made.data[0], made.linesize[0], made.width, made.height, 1, 3};
    return Plane{view, std::shared_ptr<const AVFrame>(std::move(*rgb))};
}

/// Exact samples of three channels, of one, or none.
std::optional<Plane> exact_plane(RgbConverter& converter, FramePtr frame, const PictureMessage& message) {
    const bool may_be_rgb = message.part == PlanePart::whole && message.role != PlaneRole::height;
    if (is_rgb8(*frame)) return may_be_rgb ? rgb_plane(converter, *frame) : std::nullopt;
    if (message.role == PlaneRole::haptic) return std::nullopt;
    const auto samples = luma_samples(*frame);
    if (!samples || samples->bytes_per_sample != 1) return std::nullopt;
    return Plane{*samples, std::shared_ptr<const AVFrame>(std::move(frame)), 8};
}

/// Of the high part and the low one; nothing where they cannot belong together.
std::optional<Plane> joined_plane(const PlaneView& high, const PlaneView& low, int bits) {
    if (high.width != low.width || high.height != low.height) return std::nullopt;
    return plane_from(joined_bytes(high, low, bits - 8), bits);
}

}  // namespace

Result<std::size_t> LabelledDecoder::add_track(const AVStream& stream, const std::string& where) {
    if (stream.codecpar->codec_id != AV_CODEC_ID_H264)
        return input_error(where + ": has codec " + codec_name(*stream.codecpar) + ": must be h264");
    if (tracks_.size() == most_tracks) return input_error(where + ": is one track more than 16");
    silence_ffmpeg();
    TRY_ASSIGN(auto decoder, PacketDecoder::open(stream, where, most_pixels_));
    tracks_.push_back({std::move(decoder), stream.time_base});
    return tracks_.size() - 1;
}

Result<std::vector<LabelledPicture>> LabelledDecoder::add(std::size_t track, const AVPacket& packet) {
    Pictures pictures;
    Track& of = tracks_[track];
    of.has_begun = of.has_begun || (packet.flags & AV_PKT_FLAG_KEY) != 0;
    if (!of.has_begun) return pictures;
    TRY(send(of, &packet, pictures));
    return pictures;
}

Result<std::vector<LabelledPicture>> LabelledDecoder::end() {
    Pictures pictures;
    for (Track& track : tracks_) TRY(send(track, nullptr, pictures));
    restart();
    return pictures;
}

void LabelledDecoder::restart() {
    for (auto& halves : halves_) {
        faults_.halved += static_cast<std::int64_t>(halves.size());
        halves.clear();
    }
    for (Track& track : tracks_) {
        track.decoder->flush();
        track.has_begun = track.is_broken = false;
        track.newest.reset();
    }
}

Result<void> LabelledDecoder::send(Track& track, const AVPacket* packet, Pictures& pictures) {
    const auto failed = [&](int status) -> Result<void> {
        if (status == AVERROR(ENOMEM)) return no_memory();
        ++faults_.undecodable;
        track.is_broken = true;
        return {};
    };
    if (const int status = track.decoder->send(packet); status < 0) return failed(status);
    while (true) {
        FramePtr frame(av_frame_alloc());
        if (!frame) return no_memory();
        const int status = track.decoder->receive(*frame);
        if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return {};
        if (status < 0) return failed(status);
        if (auto taken = take(track, std::move(frame), pictures); !taken) return taken;
    }
}

/// Of colour nobody could tell that it depends on what was lost; what is felt tells by its hash.
bool LabelledDecoder::follows(Track& track, const PictureMessage& message, bool is_key) {
    const std::int64_t frame = message.label.frame;
    const bool is_next = track.newest && *track.newest < frame && frame - *track.newest == 1;
    track.newest = frame;
    track.is_broken = !is_key && (track.is_broken || !is_next);
    return !track.is_broken || message.role != PlaneRole::colour;
}

Result<void> LabelledDecoder::take(Track& track, FramePtr frame, Pictures& pictures) {
    SaidOf said = messages_in(*frame);
    if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
        ++faults_.undecodable;
        track.is_broken = true;
        return {};
    }
    if (!said.picture || !said.is_one) {
        ++faults_.unlabelled;
        track.is_broken = true;
        return {};
    }
    const PictureMessage message = said.picture->picture.value();
    LabelledPicture picture{message.role, message.label, is_key_frame(*frame), 0, {}, std::move(said.scene)};
    if (frame->best_effort_timestamp != AV_NOPTS_VALUE)
        picture.time_ns = av_rescale_q(frame->best_effort_timestamp, track.time_base, nanosecond);
    if (!follows(track, message, picture.is_key)) {
        ++faults_.undecodable;
        return {};
    }
    auto plane = plane_in(track, std::move(frame), *said.picture);
    if (!plane) {
        ++faults_.damaged;
        track.is_broken = true;
        return {};
    }
    picture.plane = std::move(*plane);
    if (message.part == PlanePart::whole)
        pictures.push_back(std::move(picture));
    else
        join(message, std::move(picture), pictures);
    return {};
}

std::optional<Plane> LabelledDecoder::plane_in(Track& track, FramePtr frame, const ReadSei& sei) {
    const PictureMessage& message = *sei.picture;
    if (message.role != PlaneRole::colour) {
        auto plane = exact_plane(track.converter, std::move(frame), message);
        return plane && is_sound(sei, plane->view) ? std::move(plane) : std::nullopt;
    }
    if (!is_sound(sei, {})) return std::nullopt;
    if (leaves_out_colour_) return Plane{};
    return rgb_plane(track.converter, *frame);
}

void LabelledDecoder::join(const PictureMessage& message, LabelledPicture picture, Pictures& pictures) {
    auto& halves = halves_[static_cast<std::size_t>(message.role)];
    PictureMessage other = message;
    other.part = message.part == PlanePart::high ? PlanePart::low : PlanePart::high;
    const auto found = std::ranges::find(halves, other, &Half::message);
    if (found == halves.end()) {
        halves.push_back({message, std::move(picture)});
        if (halves.size() > most_halves) {
            halves.pop_front();
            ++faults_.halved;
        }
        return;
    }
    Half half = std::move(*found);
    halves.erase(found);
    LabelledPicture& high = message.part == PlanePart::high ? picture : half.picture;
    const LabelledPicture& low = message.part == PlanePart::high ? half.picture : picture;
    auto plane = joined_plane(high.plane.view, low.plane.view, message.bits);
    if (!plane) {
        ++faults_.damaged;
        return;
    }
    high.plane = std::move(*plane);
    high.is_key = high.is_key && low.is_key;
    pictures.push_back(std::move(high));
}

}  // namespace touchable
