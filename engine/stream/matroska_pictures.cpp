// SPDX-License-Identifier: Apache-2.0
// Pictures from a stream in our clips' own form, Matroska: MatroskaGate limits what FFmpeg's demuxer reads,
// StreamTrack decodes the packets of one plane.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <span>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/stream_pictures.hpp"

namespace touchable {

/// The head of an element.
struct MatroskaHead {
    std::uint64_t id = 0, size = 0;
    std::size_t length = 0;  ///< of the head itself
    bool is_open = false;    ///< its size is not stated
};

namespace {

/// Identifiers of EBML and Matroska, with their length markers.
constexpr std::uint64_t ebml_id = 0x1A45DFA3, segment_id = 0x18538067, cluster_id = 0x1F43B675,
                        timecode_id = 0xE7, simple_block_id = 0xA3, block_group_id = 0xA0, block_id = 0xA1,
                        track_id = 0xAE;
/// A part that a header may have, its largest size, and the most elements directly in it.
struct HeaderPart {
    std::uint64_t id, most_bytes;
    int most_elements;
};
constexpr std::array<HeaderPart, 4> header_parts{HeaderPart{0x1549A966, 4096, 64},       // of the segment
                                                 HeaderPart{0x1654AE6B, 1 << 20, 20},    // tracks
                                                 HeaderPart{0x1254C367, 1 << 18, 1024},  // tags
                                                 HeaderPart{0x1941A469, 16 << 20, 16}};  // attachments
constexpr std::uint64_t most_of_all = 16 << 20, most_of_ebml = 4096, most_of_a_block = 64 << 20,
                        most_beside_a_block = 4096;
constexpr std::array<std::uint8_t, 12> open_segment{0x18, 0x53, 0x80, 0x67, 0x01, 0xFF,
                                                    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::array<std::uint8_t, 12> open_cluster{0x1F, 0x43, 0xB6, 0x75, 0x01, 0xFF,
                                                    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::size_t longest_head = 12, longest_cluster_head = longest_head + 1;

/// A cluster begins with its time, or with a checksum before it.
constexpr bool may_begin_a_cluster(std::uint8_t id) {
    return id == timecode_id || id == 0xBF;
}

/// Parses the head of an element; nothing: it is missing or incomplete.
std::optional<MatroskaHead> read_head(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return std::nullopt;
    const auto id_bytes = static_cast<std::size_t>(std::countl_zero(bytes[0])) + 1;
    if (id_bytes > 4 || bytes.size() <= id_bytes) return std::nullopt;
    const auto size_bytes = static_cast<std::size_t>(std::countl_zero(bytes[id_bytes])) + 1;
    if (size_bytes > 8 || bytes.size() < id_bytes + size_bytes) return std::nullopt;
    MatroskaHead head;
    for (std::size_t k = 0; k < id_bytes; ++k) head.id = head.id << 8U | bytes[k];
    head.size = bytes[id_bytes] & (0xFFU >> size_bytes);
    for (std::size_t k = 1; k < size_bytes; ++k) head.size = head.size << 8U | bytes[id_bytes + k];
    head.is_open = head.size == (std::uint64_t{1} << (7 * size_bytes)) - 1;
    head.length = id_bytes + size_bytes;
    return head;
}

/// Visits the elements in an element; false if it does not consist of elements to its end, or `take` does.
template <class Take>
bool walk(std::span<const std::uint8_t> content, const Take& take) {
    while (!content.empty()) {
        const auto head = read_head(content);
        if (!head || head->is_open || head->size > content.size() - head->length) return false;
        if (!take(*head)) return false;
        content = content.subspan(head->length + static_cast<std::size_t>(head->size));
    }
    return true;
}

/// Whether it has one block, and little beside it.
bool is_block_group(std::span<const std::uint8_t> content) {
    std::uint64_t blocks = 0, beside = 0;
    const bool is_whole = walk(content, [&](const MatroskaHead& head) {
        if (head.id == block_id)
            ++blocks;
        else
            beside += head.length + head.size;
        return true;
    });
    return is_whole && blocks == 1 && beside <= most_beside_a_block;
}

// --- StreamTrack

/// Decodes the packets of one plane, some of which may be damaged or missing. A packet that depends on one of
/// these is not decoded; pictures of more than 2^24 pixels count as damaged.
class StreamTrack {
public:
    /// Frame number of a picture without a label, by its time in the stream.
    using NumberOf = std::function<std::int64_t(std::int64_t timestamp)>;
    StreamTrack(TrackDecoder decoder, int stream, NumberOf number_of)
        : decoder_(std::move(decoder)), stream_(stream), number_of_(std::move(number_of)) {}

    int stream() const { return stream_; }
    PlaneRole role() const { return decoder_.role(); }
    /// Complete after the first picture.
    const TrackInfo& info() const { return decoder_.info(); }

    /// A picture is torn by a wrong checksum, if it cannot be decoded, and if it is too large.
    using Outcome = StreamPictures::Came;

    Result<Outcome> take(const AVPacket& packet) {
        if (!is_sound(packet)) return torn();
        if (depends_on_missing(packet)) return Outcome{};
        sent_.push_back(newest_);
        return decode(&packet);
    }

    /// After the last packet.
    Result<Outcome> finish() { return decode(nullptr); }

private:
    struct Sent {
        std::optional<PictureLabel> label;
        std::int64_t frames = 1;
    };

    /// Whether the packet is undamaged; sets `newest_` to its frame.
    bool is_sound(const AVPacket& packet) {
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

    bool depends_on_missing(const AVPacket& packet) {
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

    void forget() {
        decoder_.restart(0);
        sent_.clear();
    }

    Outcome torn() {
        forget();
        waits_for_key_ = true;
        return {{}, 1};
    }

    Result<Outcome> decode(const AVPacket* packet) {
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
            outcome.pictures.push_back(
                {role(), of.label ? of.label->frame : number_of_((*picture)->timestamp), of.frames,
                 of.label ? of.label->taken_ns : 0, std::move((*picture)->plane)});
        }
    }

    TrackDecoder decoder_;
    int stream_;
    NumberOf number_of_;
    Sent newest_;            // of the current packet
    std::deque<Sent> sent_;  // in the decoder, not returned yet
    std::optional<bool> has_additions_;
    std::optional<std::int64_t> next_number_;  // expected next label
    bool waits_for_key_ = true;
};

// --- MatroskaPictures

/// Refuses (ErrorKind::input) a track whose header has pictures of more than 2^24 pixels.
Result<void> check_track_size(const AVStream& stream, const std::string& where) {
    const AVCodecParameters& codec = *stream.codecpar;
    if (std::int64_t{codec.width} * codec.height <= most_stream_pixels) return {};
    return input_error(where + ": has pictures of " + size_text(codec.width, codec.height) +
                       ": a stream's have at most " + std::to_string(most_stream_pixels) + " pixels");
}

class MatroskaPictures final : public StreamPictures {
public:
    MatroskaPictures(std::shared_ptr<StreamBytes> bytes, std::string name)
        : bytes_(std::move(bytes)), name_(std::move(name)) {}

    Result<void> open(const std::optional<SceneDescription>& described) {
        bytes_->allow(most_of_a_header);
        TRY_ASSIGN(demuxer_, Demuxer::open_live(gate_, name_, "matroska"));
        const auto container = matroska_container(SourceFile(std::filesystem::path(name_)));
        TRY_ASSIGN(rate_, container->rate(*demuxer_));
        scene_text_ = demuxer_->attachment(clip_tags::scene_file).value_or("");
        TRY_ASSIGN(described_,
                   described ? Result<SceneDescription>(*described) : container->scene(*demuxer_, rate_));
        TRY_ASSIGN(const auto found, container->tracks(*demuxer_, described_.scene));
        for (const ClipContainer::Track& track : found) {
            const std::string where = name_ + ": track " + std::string(role_name(track.role));
            TRY(check_track_size(*demuxer_->container().streams[track.stream], where));
            TRY_ASSIGN(auto decoder,
                       TrackDecoder::open(*demuxer_->container().streams[track.stream], track.role, name_));
            tracks_.emplace_back(std::move(decoder), track.stream,
                                 [this, stream = track.stream](std::int64_t timestamp) {
                                     return number_of(stream, timestamp);
                                 });
        }
        return {};
    }

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

    Result<std::optional<Came>> next() override {
        Came came;
        if (has_ended_) return std::optional<Came>();
        bytes_->allow(most_of_a_packet);
        TRY_ASSIGN(const auto packet, demuxer_->next_packet());
        has_ended_ = !packet;
        for (StreamTrack& track : tracks_) {
            if (packet && track.stream() != packet->stream_index) continue;
            if (track.role() == PlaneRole::colour && !with_colour_) continue;
            TRY_ASSIGN(auto outcome, packet ? track.take(*packet) : track.finish());
            // Damaged colour does not make a frameset torn.
            came.torn += track.role() == PlaneRole::colour ? 0 : outcome.torn;
            std::ranges::move(outcome.pictures, std::back_inserter(came.pictures));
        }
        return std::optional(std::move(came));
    }

    std::string how_it_ended() const override { return bytes_->how_it_ended(); }
    bool was_lost() const override { return bytes_->was_lost() || gate_->is_cut(); }

private:
    /// By the time since the first picture, to the nearest frame.
    std::int64_t number_of(int stream, std::int64_t timestamp) {
        constexpr double latest_seconds = 4e9, ns_per_second = 1e9;
        if (timestamp == AV_NOPTS_VALUE) return 0;
        const double seconds =
            static_cast<double>(timestamp) * av_q2d(demuxer_->container().streams[stream]->time_base);
        if (!origin_seconds_) origin_seconds_ = seconds;
        const double since = seconds - *origin_seconds_;
        if (!(since >= 0 && since < latest_seconds)) return 0;
        return rate_.nearest(std::llround(since * ns_per_second));
    }

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

}  // namespace

// --- MatroskaGate

Result<std::size_t> MatroskaGate::read(std::uint8_t* to, std::size_t count) {
    while (given_ == out_.size()) {
        out_.clear();
        given_ = 0;
        TRY_ASSIGN(const auto more, step());
        if (!more) return std::size_t{0};
    }
    const std::size_t some = std::min(count, out_.size() - given_);
    std::memcpy(to, out_.data() + given_, some);
    given_ += some;
    return some;
}

/// Reads until `bytes` are there from `at_` on; false at the end.
Result<bool> MatroskaGate::fill(std::size_t bytes) {
    constexpr std::size_t at_once = 1 << 16;
    while (there() < bytes && !has_ended_) {
        if (at_ > longest_cluster_head && at_ >= in_.size() / 2) {
            const std::size_t past = at_ - longest_cluster_head;
            in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(past));
            at_ -= past;
            cluster_at_ -= std::min(cluster_at_, past);
        }
        const std::size_t before = in_.size();
        in_.resize(before + at_once);
        const auto got = source_->read(in_.data() + before, at_once);
        in_.resize(before + (got ? *got : 0));
        if (!got) return got.error();
        has_ended_ = *got == 0;
    }
    return there() >= bytes;
}

/// Head of the next element; without an identifier if it is invalid; nothing at the end.
Result<std::optional<MatroskaHead>> MatroskaGate::head() {
    for (std::size_t wanted = 2;; ++wanted) {
        TRY_ASSIGN(const auto filled, fill(wanted));
        if (!filled) return std::optional<MatroskaHead>();
        const auto read = read_head(std::span(in_).subspan(at_, std::min(there(), longest_head)));
        if (read) return read;
        if (wanted >= longest_head) return std::optional(MatroskaHead{});
    }
}

/// Passes on or skips the next element. False at the end.
Result<bool> MatroskaGate::step() {
    TRY_ASSIGN(const auto read, head());
    if (!read) return false;
    const MatroskaHead& found = *read;
    if (place_ == Place::before) return pass_beginning(found);
    if (found.id == cluster_id) return begin_cluster(found);
    if (place_ == Place::segment) return pass_header(found);
    return pass_block(found);
}

Result<bool> MatroskaGate::pass_beginning(const MatroskaHead& head) {
    const bool is_ebml = head.id == ebml_id && head.size <= most_of_ebml;
    const bool is_segment = head.id == segment_id && header_bytes_ > 0;
    if (!is_ebml && !is_segment)
        return input_error("sends no stream that is known: neither Matroska nor MPEG-TS");
    if (is_segment) {
        out_.insert(out_.end(), open_segment.begin(), open_segment.end());
        at_ += head.length;
        place_ = Place::segment;
        return true;
    }
    const std::size_t whole = head.length + static_cast<std::size_t>(head.size);
    const auto filled = fill(whole);
    if (!filled || !*filled) return filled;
    header_bytes_ += whole;
    give(whole);
    return true;
}

/// Passes on each part of the header once.
Result<bool> MatroskaGate::pass_header(const MatroskaHead& head) {
    header_bytes_ += head.length + head.size;
    if (head.id == 0 || head.is_open || header_bytes_ > most_of_all)
        return input_error("sends a header that is damaged, or larger than 16 MiB");
    const auto part = std::ranges::find(header_parts, head.id, &HeaderPart::id);
    if (part == header_parts.end()) return leave_out(head);
    auto& seen = seen_[static_cast<std::size_t>(part - header_parts.begin())];
    if (seen) return leave_out(head);
    seen = true;
    if (head.size > part->most_bytes) return input_error("sends a header with a part that is too large");
    const std::size_t size = static_cast<std::size_t>(head.size);
    const auto filled = fill(head.length + size);
    if (!filled || !*filled) return filled;
    int elements = 0, tracks = 0;
    const bool is_right =
        walk(std::span(in_).subspan(at_ + head.length, size), [&](const MatroskaHead& inner) {
            tracks += inner.id == track_id ? 1 : 0;
            return ++elements <= part->most_elements;
        });
    constexpr int most_tracks_there = 16;
    if (tracks > most_tracks_there) return input_error("sends more than 16 tracks");
    if (!is_right) return input_error("sends a header that is damaged, or has too many parts");
    give(head.length + size);
    return true;
}

Result<bool> MatroskaGate::begin_cluster(const MatroskaHead& head) {
    place_ = Place::clusters;
    out_.insert(out_.end(), open_cluster.begin(), open_cluster.end());
    at_ += head.length;
    cluster_at_ = at_;
    return true;
}

/// Skips an element without keeping it.
Result<bool> MatroskaGate::leave_out(const MatroskaHead& head) {
    std::uint64_t left = head.length + head.size;
    while (left > 0) {
        const auto filled = fill(1);
        if (!filled || !*filled) return filled;
        const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(left, there()));
        at_ += some;
        left -= some;
    }
    return true;
}

/// Finds a cluster's head with a valid beginning behind it: by chance once in 10^11 bytes.
std::optional<std::size_t> MatroskaGate::cluster_in(std::size_t from, std::size_t end) const {
    const std::uint8_t* const base = in_.data() + at_;
    for (std::size_t at = from; at + 5 < end; ++at) {
        const void* const found = std::memchr(base + at, open_cluster[0], end - at - 5);
        if (!found) return std::nullopt;
        at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - base);
        if (std::memcmp(base + at, open_cluster.data(), 4) != 0) continue;
        const auto head = read_head(std::span(in_).subspan(at_ + at, end - at));
        if (head && at + head->length < end && may_begin_a_cluster(base[at + head->length])) return at;
    }
    return std::nullopt;
}

/// Skips to the next cluster, after damage or loss.
Result<bool> MatroskaGate::find_cluster(std::size_t from) {
    while (true) {
        if (const auto found = cluster_in(from, there())) {
            at_ += *found;
            return true;
        }
        const std::size_t done = there() - std::min(there(), longest_cluster_head);
        at_ += std::max(done, std::min(from, there()));
        from = 0;
        const auto filled = fill(there() + 1);
        if (!filled || !*filled) return filled;
    }
}

/// Also finds a cluster of whose head the block before, with a damaged length, has taken a part.
Result<bool> MatroskaGate::look_back() {
    const std::size_t here = at_;
    at_ = std::max(cluster_at_, at_ - std::min(at_, longest_cluster_head));
    return find_cluster(here == at_ ? 1 : 0);
}

Result<bool> MatroskaGate::pass_block(const MatroskaHead& head) {
    const bool is_block = head.id == simple_block_id || head.id == block_group_id || head.id == timecode_id;
    const bool is_known = is_block || head.id == 0xA7 || head.id == 0xAB || head.id == 0xBF ||
                          head.id == 0xEC || head.id == 0x5854 || head.id > 0xFFFFFF;
    if (!is_known || head.is_open || head.size > most_of_a_block) return look_back();
    const std::size_t size = static_cast<std::size_t>(head.size), whole = head.length + size;
    for (std::size_t looked = head.length; looked < whole;) {
        const auto filled = fill(std::min(whole, there() + 1));
        if (!filled) return filled;
        const std::size_t end = std::min(whole, there());
        if (cluster_in(looked, end)) return find_cluster(looked);
        looked = std::max(looked, end - std::min(end, longest_cluster_head));
        if (end == whole) break;
        if (!*filled) return false;
    }
    const auto filled = fill(whole);
    if (!filled || !*filled) return filled;
    const auto content = std::span<const std::uint8_t>(in_).subspan(at_ + head.length, size);
    const bool is_right = is_block && (head.id != block_group_id || is_block_group(content)) &&
                          (head.id != timecode_id || size <= 8);
    if (is_right)
        give(whole);
    else
        at_ += whole;
    return true;
}

// --- The pictures

Result<std::unique_ptr<StreamPictures>> open_matroska_pictures(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described) {
    return opened_as<StreamPictures>(std::make_unique<MatroskaPictures>(std::move(bytes), name), described);
}

}  // namespace touchable
