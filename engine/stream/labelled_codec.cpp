// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/labelled_codec.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// --- Helpers of messages

/// No byte is zero, so that no message needs escaping.
constexpr std::array<std::uint8_t, 16> message_uuid{0x9b, 0x3e, 0x57, 0xc1, 0x6d, 0x2a, 0x4f, 0x88,
                                                    0xa5, 0x74, 0x1c, 0xe9, 0x33, 0xd6, 0xb2, 0x4d};
constexpr std::array<std::string_view, 3> part_names{"whole", "high", "low"};
constexpr std::string_view hash_key = " xxh64=", scene_key = "touchable_scene=1 xxh64=";
constexpr std::size_t hash_digits = 16, longest_message = std::size_t{1} << 20;

/// Has `hash_digits`.
std::string hash_of(std::string_view text, const PlaneView& samples) {
    ByteHash hash;
    hash.add(text.data(), text.size());
    for (int y = 0; y < samples.height; ++y) hash.add(samples.row(y), samples.row_bytes());
    return hash.hex();
}

std::string with_uuid(const std::string& text) {
    return std::string(message_uuid.begin(), message_uuid.end()) + text;
}

std::optional<PlanePart> part_named(std::string_view name) {
    const auto* const found = std::ranges::find(part_names, name);
    if (found == part_names.end()) return std::nullopt;
    return static_cast<PlanePart>(found - part_names.begin());
}

std::string text_of(const PictureMessage& message) {
    return "touchable=1 role=" + std::string(role_name(message.role)) +
           " part=" + std::string(part_names[static_cast<std::size_t>(message.part)]) +
           " bits=" + std::to_string(message.bits) + " frame=" + std::to_string(message.label.frame) +
           " taken_ns=" + std::to_string(message.label.taken_ns);
}

std::optional<PictureMessage> read_message(std::string_view text) {
    // The value of this key, which has to come next; empty if it does not.
    const auto value = [&text](std::string_view key) {
        if (!text.starts_with(key) || !text.substr(key.size()).starts_with('=')) return std::string_view();
        text.remove_prefix(key.size() + 1);
        return cut_part(text, ' ');
    };
    if (value("touchable") != "1") return std::nullopt;
    const auto role = role_named(value("role"));
    const auto part = part_named(value("part"));
    const auto bits = parsed_as<int>(value("bits"));
    const auto frame = parsed_as<std::int64_t>(value("frame"));
    const auto taken_ns = parsed_as<std::int64_t>(value("taken_ns"));
    if (!role || !part || !bits || !frame || !taken_ns || !text.empty()) return std::nullopt;
    const bool can_be =
        *part == PlanePart::whole
            ? *bits == 8
            : *bits >= 8 && *bits <= 16 && (*role == PlaneRole::depth || *role == PlaneRole::height);
    if (!can_be || *frame < 0 || *taken_ns < 0) return std::nullopt;
    return PictureMessage{*role, *part, *bits, {*frame, *taken_ns}};
}

// --- Helpers of the encoder

/// Frames with individual times are sent with their mean rate: each picture states when it was taken.
std::string sent_scene(const SceneDescription& described) {
    SceneDescription said = said_of_clip(described);
    said.scene.rate.own_times = nullptr;
    return scene_to_json(said);
}

// --- Helpers of the decoder

constexpr std::size_t most_tracks = 16;
/// Limit of plane halves that wait for the others: tracks of one frame come close to each other.
constexpr std::size_t most_halves = 8;

/// The messages of a picture.
struct SaidOf {
    std::optional<ReadSei> picture;
    std::shared_ptr<const std::string> scene;
    bool is_one = true;  // false: two messages for one picture, so they are mixed up
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
    return plane_from(std::move(*rgb));
}

/// A plane of exact samples, with three channels or one; nothing: neither.
std::optional<Plane> exact_plane(RgbConverter& converter, FramePtr frame, const PictureMessage& message) {
    const bool may_be_rgb = message.part == PlanePart::whole && message.role != PlaneRole::height;
    if (is_rgb8(*frame)) return may_be_rgb ? rgb_plane(converter, *frame) : std::nullopt;
    if (message.role == PlaneRole::haptic) return std::nullopt;
    const auto samples = luma_samples(*frame);
    if (!samples || samples->bytes_per_sample != 1) return std::nullopt;
    return Plane{*samples, std::shared_ptr<const AVFrame>(std::move(frame)), 8};
}

/// Joins the high and the low part; nothing if they do not belong together, or memory runs out.
std::optional<Plane> joined_plane(const PlaneView& high, const PlaneView& low, int bits) {
    if (high.width != low.width || high.height != low.height) return std::nullopt;
    FramePtr joined = joined_bytes(high, low, bits - 8);
    if (!joined) return std::nullopt;
    return plane_from(std::move(joined), bits);
}

}  // namespace

// --- Messages

std::string sei_of(const PictureMessage& message, const PlaneView& samples) {
    const std::string text = text_of(message);
    const bool is_exact = message.role != PlaneRole::colour;
    return with_uuid(text + std::string(hash_key) + hash_of(text, is_exact ? samples : PlaneView{}));
}

std::string sei_of_scene(std::string_view json) {
    return with_uuid(std::string(scene_key) + hash_of(json, {}) + " " + std::string(json));
}

std::optional<ReadSei> read_sei(std::span<const std::uint8_t> content) {
    if (content.size() > longest_message || content.size() < message_uuid.size() ||
        !std::equal(message_uuid.begin(), message_uuid.end(), content.begin()))
        return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(content.data()) + message_uuid.size(),
                                content.size() - message_uuid.size());
    ReadSei read;
    if (text.starts_with(scene_key)) {
        const std::size_t json_at = scene_key.size() + hash_digits + 1;
        if (text.size() < json_at || text[json_at - 1] != ' ') return std::nullopt;
        read.hash = text.substr(scene_key.size(), hash_digits);
        read.scene = text.substr(json_at);
        return hash_of(*read.scene, {}) == read.hash ? std::optional(std::move(read)) : std::nullopt;
    }
    const std::size_t hash_at = text.rfind(hash_key);
    if (hash_at == std::string_view::npos) return std::nullopt;
    read.hashed = text.substr(0, hash_at);
    read.picture = read_message(read.hashed);
    read.hash = text.substr(hash_at + hash_key.size());
    return read.picture ? std::optional(std::move(read)) : std::nullopt;
}

bool is_sound(const ReadSei& sei, const PlaneView& samples) {
    const bool is_exact = sei.picture->role != PlaneRole::colour;
    return hash_of(sei.hashed, is_exact ? samples : PlaneView{}) == sei.hash;
}

// --- LabelledEncoder

Result<LabelledEncoder> LabelledEncoder::open(const RawFrame& first, const SceneDescription& described,
                                              TrackCoding touch, TrackCoding colour) {
    silence_ffmpeg();
    TRY(check_x264("MPEG-TS and HLS"));
    LabelledEncoder made;
    made.scene_sei_ = sei_of_scene(sent_scene(described));
    made.form_ = first;
    made.form_.storage = made.form_.filled = nullptr;
    made.tracks_ = part_tracks(first, described.scene);
    for (PartTrack& track : made.tracks_) {
        const TrackCoding coding = track.role == PlaneRole::colour ? colour : touch;
        TRY_ASSIGN(track.encoder, TrackEncoder::open(track.role, coding, track.of(first), described.scene));
    }
    return made;
}

Result<std::vector<PacketPtr>> LabelledEncoder::encode(const RawFrame& frame, const PictureLabel& label,
                                                       bool is_key) {
    std::vector<PacketPtr> packets;
    for (PartTrack& track : tracks_) {
        if (!same_form(plane_of(frame, track.role), plane_of(form_, track.role)))
            return input_error("frame " + std::to_string(frame.number) + ": its plane " +
                               std::string(role_name(track.role)) + " is not like that of the first frame");
        const PlaneView part = track.of(frame);
        std::vector<std::string> messages{sei_of({track.role, track.part, track.bits, label}, part)};
        if (is_key && track.role == PlaneRole::depth && track.part != PlanePart::low)
            messages.push_back(scene_sei_);
        TRY_ASSIGN(auto packet, track.encoder->encode(part, is_key, messages));
        packets.push_back(std::move(packet));
    }
    return packets;
}

// --- LabelledDecoder

Result<std::size_t> LabelledDecoder::add_track(const AVStream& stream, const std::string& where) {
    if (stream.codecpar->codec_id != AV_CODEC_ID_H264)
        return input_error(where + ": has codec " + codec_name(*stream.codecpar) + ": must be h264");
    if (tracks_.size() == most_tracks) return input_error(where + ": is one track more than 16");
    silence_ffmpeg();
    TRY_ASSIGN(auto decoder, PacketDecoder::open(stream, where, most_pixels_));
    tracks_.push_back({std::move(decoder)});
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
    for (auto& halves : halves_) halves.clear();
    for (Track& track : tracks_) {
        track.decoder->flush();
        track.has_begun = track.is_broken = false;
        track.newest.reset();
    }
}

Result<void> LabelledDecoder::send(Track& track, const AVPacket* packet, Pictures& pictures) {
    const auto failed = [&](int status) -> Result<void> {
        if (status == AVERROR(ENOMEM)) return memory_error();
        track.is_broken = true;
        return {};
    };
    if (const int status = track.decoder->send(packet); status < 0) return failed(status);
    while (true) {
        FramePtr frame(av_frame_alloc());
        if (!frame) return memory_error();
        const int status = track.decoder->receive(*frame);
        if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return {};
        if (status < 0) return failed(status);
        TRY(take(track, std::move(frame), pictures));
    }
}

Result<void> LabelledDecoder::take(Track& track, FramePtr frame, Pictures& pictures) {
    SaidOf said = messages_in(*frame);
    const bool is_corrupt = frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0;
    if (is_corrupt || !said.picture || !said.is_one) {
        track.is_broken = true;
        return {};
    }
    const PictureMessage message = said.picture->picture.value();
    LabelledPicture picture{message.role, message.label, is_key_frame(*frame), {}, std::move(said.scene)};
    if (!follows(track, message, picture.is_key)) return {};
    auto plane = plane_in(track, std::move(frame), *said.picture);
    if (!plane) {
        ++damaged_;
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
        if (halves.size() > most_halves) halves.pop_front();
        return;
    }
    Half half = std::move(*found);
    halves.erase(found);
    LabelledPicture& high = message.part == PlanePart::high ? picture : half.picture;
    const LabelledPicture& low = message.part == PlanePart::high ? half.picture : picture;
    auto plane = joined_plane(high.plane.view, low.plane.view, message.bits);
    if (!plane) {
        ++damaged_;
        return;
    }
    high.plane = std::move(*plane);
    high.is_key = high.is_key && low.is_key;
    pictures.push_back(std::move(high));
}

}  // namespace touchable
