#include "engine/stream/hls_rendition.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/picture/box_tables.hpp"

namespace touchable {
namespace {

constexpr std::size_t largest_hls_segment = std::size_t{128} << 20;
/// A playlist that is older, or cannot be fetched, so often in a row is no matter of a cache any more; FFmpeg
/// asks for it about twice a second.
constexpr int most_held_reloads = 6;
constexpr AVRational rendition_ns{1, 1'000'000'000};

/// Bytes that FFmpeg reads as a file.
struct BytesIo {
    std::string bytes;
    std::size_t at = 0;

    static int read(void* own, std::uint8_t* to, int count) {
        auto& it = *static_cast<BytesIo*>(own);
        const std::size_t some = std::min(static_cast<std::size_t>(count), it.bytes.size() - it.at);
        if (some == 0) return AVERROR_EOF;
        std::memcpy(to, it.bytes.data() + it.at, some);
        it.at += some;
        return static_cast<int>(some);
    }
    static std::int64_t seek(void* own, std::int64_t offset, int whence) {
        auto& it = *static_cast<BytesIo*>(own);
        const auto size = static_cast<std::int64_t>(it.bytes.size());
        if ((whence & AVSEEK_SIZE) != 0) return size;
        whence &= ~AVSEEK_FORCE;
        const std::int64_t from = whence == SEEK_CUR   ? static_cast<std::int64_t>(it.at)
                                  : whence == SEEK_END ? size
                                                       : 0;
        if (offset < -from || offset > size - from) return AVERROR(EINVAL);
        it.at = static_cast<std::size_t>(from + offset);
        return from + offset;
    }
};

AVIOContext* io_of(std::string bytes) {
    auto own = std::make_unique<BytesIo>(BytesIo{std::move(bytes)});
    constexpr int buffer_bytes = 1 << 15;
    auto* const buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    AVIOContext* const io =
        buffer ? avio_alloc_context(buffer, buffer_bytes, 0, own.get(), BytesIo::read, nullptr, BytesIo::seek)
               : nullptr;
    if (io)
        (void)own.release();
    else
        av_free(buffer);
    return io;
}

void close_bytes(AVIOContext* io) {
    if (!io) return;
    delete static_cast<BytesIo*>(io->opaque);
    av_freep(&io->buffer);
    avio_context_free(&io);
}

/// FFmpeg counts up to a thousand million for each run of samples where a track has no number above 0.
bool has_number(mpeg4::BytesView track) {
    const auto parts = mpeg4::boxes_in(track);
    const mpeg4::Box* const head = parts ? mpeg4::box_named(*parts, "tkhd") : nullptr;
    if (!head || head->content.empty()) return false;
    const std::size_t at = head->content[0] == 1 ? 20 : 12;  // behind two times, of 8 bytes or of 4
    if (head->content.size() < at + 4) return false;
    constexpr std::uint64_t largest = std::numeric_limits<std::int32_t>::max();
    const std::uint64_t number = mpeg4::number_at(head->content, at, 4);
    return number > 0 && number <= largest;
}

/// Tracks that FFmpeg could find in a box, wherever it looks.
std::ptrdiff_t tracks_anywhere(mpeg4::BytesView content) {
    const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
    std::ptrdiff_t count = 0;
    for (std::size_t at = 0; (at = text.find("trak", at)) != std::string_view::npos; at += 4) ++count;
    return count;
}

/// Boxes to their last byte, of the kinds that segments have, whose tables hold what they claim, and tracks
/// where they belong.
bool is_whole_mp4(const std::string& bytes) {
    const mpeg4::BytesView view(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const auto boxes = mpeg4::boxes_in(view);
    if (!boxes || boxes->empty()) return false;
    constexpr std::array<std::string_view, 9> kinds{"ftyp", "styp", "moov", "moof", "mdat",
                                                    "sidx", "emsg", "prft", "mfra"};
    for (const mpeg4::Box& box : *boxes) {
        if (std::ranges::find(kinds, box.type) == kinds.end()) return false;
        std::ptrdiff_t tracks = 0;
        const auto parts = box.type == "moov" ? mpeg4::boxes_in(box.content) : std::vector<mpeg4::Box>();
        if (!parts) return false;
        for (const mpeg4::Box& part : *parts) tracks += part.type == "trak" && has_number(part.content);
        if (box.type != "mdat" && tracks_anywhere(box.content) != tracks) return false;
    }
    return check_box_tables(*bytes_in_memory(bytes), bytes.size()).ok();
}

ByteRange range_in(const AVDictionary* options) {
    const auto number = [options](const char* key) -> std::optional<std::int64_t> {
        const AVDictionaryEntry* const entry = av_dict_get(options, key, nullptr, 0);
        return entry ? std::optional<std::int64_t>(std::strtoll(entry->value, nullptr, 10)) : std::nullopt;
    };
    return {number("offset").value_or(0), number("end_offset")};
}

}  // namespace

Result<std::unique_ptr<HlsRendition>> HlsRendition::open(std::string place, WaitIsOver is_over,
                                                         HlsHosts hosts, HlsBeginning beginning) {
    silence_ffmpeg();
    std::unique_ptr<HlsRendition> rendition(
        new HlsRendition(std::move(place), std::move(is_over), hosts, beginning.watch));
    TRY(rendition->begin(std::move(beginning)));
    return rendition;
}

HlsRendition::~HlsRendition() {
    avformat_close_input(&context_);
    close_bytes(first_io_);
}

Result<void> HlsRendition::begin(HlsBeginning beginning) {
    auto& [text, from, watch] = beginning;
    if (auto read = text ? take_playlist(std::move(*text)) : fetch_playlist(); !read) return read;
    auto first = from ? playlist_from(playlist_, *from) : std::optional(playlist_);
    if (!first) return error_at(place_, input_error("has no segment " + std::to_string(*from) + " yet"));
    if (from) newest_segment_ = *from - 1;
    context_ = avformat_alloc_context();
    if (context_) context_->pb = first_io_ = io_of(std::move(*first));
    if (!first_io_) return Error{ErrorKind::internal, "out of memory"};
    context_->opaque = this;
    context_->io_open = open_io;
    context_->io_close2 = close_io;
    context_->interrupt_callback = {is_over, this};
    AVDictionary* options = nullptr;
    av_dict_set(&options, "format_whitelist", "hls,mov,mp4,m4a,3gp,3g2,mj2,mpegts", 0);
    av_dict_set(&options, "http_persistent", "0", 0);  // connections are ours
    av_dict_set(&options, "http_multiple", "0", 0);
    if (from) av_dict_set(&options, "live_start_index", "0", 0);
    const int status = avformat_open_input(&context_, place_.c_str(), av_find_input_format("hls"), &options);
    av_dict_free(&options);
    return status < 0 ? failure(status) : Result<void>{};
}

Error HlsRendition::failure(int status) const {
    if (fault_) return *fault_;
    if (is_over_()) return error_at(place_, Error{ErrorKind::interrupted, "gave no picture in time"});
    return error_at(place_, input_error(ffmpeg_text(status)));
}

int HlsRendition::is_over(void* own) {
    const auto& it = *static_cast<const HlsRendition*>(own);
    return it.fault_ || it.was_ended_ || it.is_over_() ? 1 : 0;
}

int HlsRendition::open_io(AVFormatContext* context, AVIOContext** io, const char* url, int flags,
                          AVDictionary** options) {
    auto& it = *static_cast<HlsRendition*>(context->opaque);
    if ((flags & AVIO_FLAG_WRITE) != 0) return AVERROR(EPERM);
    if (it.was_ended_) return AVERROR_EXIT;
    try {
        if (url != it.place_) return it.open_segment(io, url, range_in(options ? *options : nullptr));
        if (auto read = it.fetch_playlist(); !read) {
            it.fault_ = read.error();
            return AVERROR_EXIT;
        }
        *io = io_of(it.playlist_);
        return *io ? 0 : AVERROR(ENOMEM);
    } catch (const std::exception&) {
        return AVERROR(ENOMEM);
    }
}

int HlsRendition::open_segment(AVIOContext** io, const std::string& named, const ByteRange& range) {
    const auto place = place_named(named);
    const auto listed = watch_ && place && *place != facts_.header
                            ? segment_in(playlist_, place_, *place, newest_segment_ + 1, hosts_)
                            : std::nullopt;
    if (listed && watch_->ends_before(listed->number)) {
        was_ended_ = true;
        return AVERROR_EXIT;
    }
    const std::int64_t begin_ns = listed ? watch_->now_ns() : 0;
    auto segment = place ? read_segment(*place, range) : Result<std::string>(place.error());
    if (!segment && segment.error().kind == ErrorKind::interrupted) {
        fault_ = error_at(named, segment.error());
        return AVERROR_EXIT;
    }
    if (listed) {
        newest_segment_ = listed->number;
        watch_->fetched({.bytes = segment ? std::ssize(*segment) : 0,
                         .fetch_ns = watch_->now_ns() - begin_ns,
                         .duration_ns = listed->duration_ns});
    }
    if (!segment) {
        ++segments_lost_;
        return AVERROR(ENOENT);  // FFmpeg goes on with the next one
    }
    *io = io_of(std::move(*segment));
    return *io ? 0 : AVERROR(ENOMEM);
}

int HlsRendition::close_io(AVFormatContext*, AVIOContext* io) {
    close_bytes(io);
    return 0;
}

Result<void> HlsRendition::fetch_playlist() {
    return take_playlist(fetch_place(place_, largest_hls_playlist, is_over_));
}

/// The newest that there is; where there is none, the one before stays.
Result<void> HlsRendition::take_playlist(Result<std::string> text) {
    const bool is_first = playlist_.empty();
    auto facts = text ? check_hls_media(*text, place_, hosts_) : Result<HlsMediaFacts>(text.error());
    if (text && !facts) return error_at(place_, facts.error());
    const bool is_older = facts && !is_first && facts->next_segment < facts_.next_segment;
    if (!facts || is_older) {
        if (facts)
            facts = input_error("goes back to segments before those that it had: the sender began anew");
        if (is_first || facts.error().kind == ErrorKind::interrupted || ++held_ > most_held_reloads)
            return error_at(place_, facts.error());
        return {};
    }
    if (!is_first && facts->header != facts_.header)
        return error_at(place_, input_error("has another initialisation: the sender began anew"));
    held_ = 0;
    playlist_ = std::move(*text);
    facts_ = std::move(*facts);
    return {};
}

Result<std::string> HlsRendition::place_named(const std::string& named) const {
    const std::string folder = place_.substr(0, place_.rfind('/') + 1);
    const bool is_file = place_.starts_with("file:") && named.starts_with(folder);
    return resolved_place(place_, is_file ? named.substr(folder.size()) : named, hosts_);
}

Result<std::string> HlsRendition::read_segment(const std::string& place, const ByteRange& range) {
    const bool is_part = range.begin > 0 || range.end, is_header = place == facts_.header && !is_part;
    if (is_header && !header_.empty()) return header_;
    auto bytes = fetch_place(place, largest_hls_segment, is_over_, range);
    if (!bytes) return bytes;
    if (is_hls_playlist(*bytes) || (!facts_.header.empty() && !is_part && !is_whole_mp4(*bytes)))
        return input_error("is no whole segment");
    if (is_header) header_ = *bytes;
    return bytes;
}

std::int64_t HlsRendition::time_ns(const AVPacket& packet) const {
    const std::int64_t time = packet.dts != AV_NOPTS_VALUE ? packet.dts : packet.pts;
    if (time == AV_NOPTS_VALUE) return std::numeric_limits<std::int64_t>::min();
    return av_rescale_q(time, stream_of(packet).time_base, rendition_ns);
}

Result<const AVPacket*> HlsRendition::peek() {
    if (ahead_ || at_end_) return static_cast<const AVPacket*>(ahead_.get());
    if (fault_) return *fault_;
    PacketPtr packet(av_packet_alloc());
    if (!packet) return Error{ErrorKind::internal, "out of memory"};
    const int status = av_read_frame(context_, packet.get());
    if (fault_ || is_over_()) return failure(status);
    at_end_ = status == AVERROR_EOF || (status < 0 && was_ended_);
    if (!at_end_ && status < 0) return failure(status);
    if (!at_end_) ahead_ = std::move(packet);
    return static_cast<const AVPacket*>(ahead_.get());
}

}  // namespace touchable
