// SPDX-License-Identifier: Apache-2.0
// Reading HTTP Live Streaming. HlsInput merges two renditions, touch and colour, by time. Each is read by an
// HlsLevels, which changes between the full and the low level as LevelChoice says; an HlsRendition reads one
// media playlist of a level and its segments. FFmpeg parses these, but fetches nothing itself: its requests
// are answered with bytes that were fetched and checked here.

#include <array>
#include <limits>

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {
namespace {

// --- Fetching

/// Bytes of a file, from the first on and before the last.
struct ByteRange {
    std::int64_t begin = 0;
    std::optional<std::int64_t> end;
};

constexpr std::chrono::seconds longest_fetch{10};

Error fetch_failure(const std::string& why) {
    return input_error("cannot be fetched: " + why);
}

Result<std::string> fetch_from_web(const std::string& place, std::size_t most, const ByteRange& range) {
    AVDictionary* options = http_options(place.starts_with("https:"));
    if (range.begin > 0) av_dict_set_int(&options, "offset", range.begin, 0);
    if (range.end) av_dict_set_int(&options, "end_offset", *range.end, 0);
    AVIOContext* opened = nullptr;
    int status = avio_open2(&opened, place.c_str(), AVIO_FLAG_READ, &stops_with_thread, &options);
    av_dict_free(&options);
    if (status < 0) return fetch_failure(ffmpeg_text(status));
    const IoPtr io(opened);
    std::string bytes;
    std::array<unsigned char, 1 << 16> some;
    while (true) {
        status = avio_read_partial(io.get(), some.data(), static_cast<int>(some.size()));
        if (status == AVERROR_EOF || status == 0) return bytes;
        if (status < 0) return fetch_failure(ffmpeg_text(status));
        bytes.append(reinterpret_cast<const char*>(some.data()), static_cast<std::size_t>(status));
        if (bytes.size() > most)
            return input_error("is larger than " + in_bytes(most) + ", which nothing of a stream is");
    }
}

/// Fetches everything at a place of a web server, or a file. Takes 10 s at most. Refused (ErrorKind::input;
/// the message follows the place and a colon): more than `most` bytes, fewer than the server promised, a
/// redirection. ErrorKind::interrupted after a request to stop the thread: "did not come in time".
Result<std::string> fetch_place(const std::string& place, std::size_t most, const ByteRange& range = {}) {
    constexpr std::string_view file = "file:";
    if (place.starts_with(file))
        return read_given_file(place.substr(file.size()), "", "a file of a stream", most);
    silence_ffmpeg();
    auto fetched = work_until(std::chrono::steady_clock::now() + longest_fetch, [&] {
        return unless_stopped([place, most, range] { return fetch_from_web(place, most, range); });
    });
    if (stop_requested()) return Error{ErrorKind::interrupted, "did not come in time"};
    return fetched ? std::move(*fetched) : fetch_failure("it took longer than 10 s");
}

constexpr double quick_share = 0.5, slow_share = 0.2;  // weight of the newest segment in the means
constexpr double rate_to_spare = 2;
constexpr int segments_before_up = 4;

double in_seconds(std::int64_t ns) {
    return static_cast<double>(ns) * 1e-9;
}

// --- Renditions and levels

constexpr std::size_t largest_hls_segment = std::size_t{128} << 20;
/// Consecutive reloads that may give an older playlist or none, as caches do. FFmpeg reloads about twice a
/// second.
constexpr int most_held_reloads = 6;
constexpr AVRational rendition_ns{1, 1'000'000'000};

/// FFmpeg counts up to a thousand million per run of samples if a track's number is not above 0.
bool has_number(mpeg4::BytesView track) {
    constexpr std::size_t least_bytes = 24;  // of a track's header, up to its number
    constexpr std::uint32_t largest = std::numeric_limits<std::int32_t>::max();
    const auto head = mpeg4::content_at(track, {"tkhd"});
    const std::uint32_t number = head.size() < least_bytes ? 0 : mpeg4::number_behind_times(head);
    return number > 0 && number <= largest;
}

/// Number of tracks that FFmpeg could find anywhere in a box.
std::ptrdiff_t tracks_anywhere(mpeg4::BytesView content) {
    const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
    std::ptrdiff_t count = 0;
    for (std::size_t at = 0; (at = text.find("trak", at)) != std::string_view::npos; at += 4) ++count;
    return count;
}

/// Whether the bytes are complete boxes of the kinds that segments have, with tables that hold what they
/// claim, and with tracks only where they belong.
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
    return bool(check_box_tables(*bytes_in_memory(bytes), bytes.size()));
}

ByteRange range_in(const AVDictionary* options) {
    const auto number = [options](const char* key) -> std::optional<std::int64_t> {
        const AVDictionaryEntry* const entry = av_dict_get(options, key, nullptr, 0);
        return entry ? std::optional<std::int64_t>(std::strtoll(entry->value, nullptr, 10)) : std::nullopt;
    };
    return {number("offset").value_or(0), number("end_offset")};
}

class HlsLevels;

/// How a rendition is opened.
struct HlsBeginning {
    std::optional<std::string> text{};   ///< of the playlist, if already fetched
    std::optional<std::int64_t> from{};  ///< number of the first segment; nothing: FFmpeg chooses
    HlsLevels* levels = nullptr;         ///< null: there is no other level; outlives the rendition
    bool is_low = false;                 ///< its level
};

/// A media playlist and its segments, read by FFmpeg's HLS demuxer.
class HlsRendition : NonCopyable {
public:
    /// `place`: of the media playlist. Errors name a place.
    static Result<std::unique_ptr<HlsRendition>> open(std::string place, HlsBeginning beginning = {}) {
        silence_ffmpeg();
        std::unique_ptr<HlsRendition> rendition(new HlsRendition(std::move(place), beginning));
        TRY(rendition->begin(std::move(beginning)));
        return rendition;
    }
    ~HlsRendition() {
        avformat_close_input(&context_);
        close_memory(first_io_);
    }

    /// The packet that `take` returns; null at the end, or at a change to the other level.
    Result<const AVPacket*> peek() {
        if (ahead_ || at_end_) return static_cast<const AVPacket*>(ahead_.get());
        if (fault_) return *fault_;
        PacketPtr packet(av_packet_alloc());
        if (!packet) return memory_error();
        const int status =
            work_until(ended_.get_token(), [&] { return av_read_frame(context_, packet.get()); });
        if (fault_ || stop_requested()) return failure(status);
        at_end_ = status == AVERROR_EOF || (status < 0 && ended_.stop_requested());
        if (!at_end_ && status < 0) return failure(status);
        if (!at_end_) ahead_ = std::move(packet);
        return static_cast<const AVPacket*>(ahead_.get());
    }
    PacketPtr take() { return std::move(ahead_); }
    const AVStream& stream_of(const AVPacket& packet) const {
        return *context_->streams[packet.stream_index];
    }
    /// Decoding time; the least number if it is unknown.
    std::int64_t time_ns(const AVPacket& packet) const {
        const std::int64_t time = packet.dts != AV_NOPTS_VALUE ? packet.dts : packet.pts;
        if (time == AV_NOPTS_VALUE) return std::numeric_limits<std::int64_t>::min();
        return av_rescale_q(time, stream_of(packet).time_base, rendition_ns);
    }

    bool has_ended() const { return facts_.has_ended; }
    std::int64_t segments_lost() const { return segments_lost_; }

private:
    HlsRendition(std::string place, const HlsBeginning& beginning)
        : place_(std::move(place)), levels_(beginning.levels), is_low_(beginning.is_low) {}
    Result<void> begin(HlsBeginning beginning) {
        const auto& from = beginning.from;
        TRY(beginning.text ? take_playlist(std::move(*beginning.text)) : fetch_playlist());
        auto first = from ? playlist_from(playlist_, *from) : std::optional(playlist_);
        if (!first) return error_at(place_, input_error("has no segment " + std::to_string(*from) + " yet"));
        if (from) newest_segment_ = *from - 1;
        context_ = avformat_alloc_context();
        if (context_) context_->pb = first_io_ = open_memory(std::move(*first));
        if (!first_io_) return memory_error();
        context_->opaque = this;
        context_->io_open = open_io;
        context_->io_close2 = close_io;
        context_->interrupt_callback = stops_with_thread;
        AVDictionary* options = nullptr;
        av_dict_set(&options, "format_whitelist", "hls,mov,mp4,m4a,3gp,3g2,mj2,mpegts", 0);
        av_dict_set(&options, "http_persistent", "0", 0);  // connections are made here
        av_dict_set(&options, "http_multiple", "0", 0);
        if (from) av_dict_set(&options, "live_start_index", "0", 0);
        const int status = work_until(ended_.get_token(), [&] {
            return avformat_open_input(&context_, place_.c_str(), av_find_input_format("hls"), &options);
        });
        av_dict_free(&options);
        return status < 0 ? failure(status) : Result<void>{};
    }
    static int open_io(AVFormatContext* context, AVIOContext** io, const char* url, int flags,
                       AVDictionary** options) {
        auto& it = *static_cast<HlsRendition*>(context->opaque);
        if ((flags & AVIO_FLAG_WRITE) != 0) return AVERROR(EPERM);
        if (it.ended_.stop_requested()) return AVERROR_EXIT;
        try {
            if (url != it.place_) return it.open_segment(io, url, range_in(options ? *options : nullptr));
            if (auto read = it.fetch_playlist(); !read) return it.end(read.error());
            *io = open_memory(it.playlist_);
            return *io ? 0 : AVERROR(ENOMEM);
        } catch (const std::exception&) {
            return AVERROR(ENOMEM);
        }
    }
    static int close_io(AVFormatContext*, AVIOContext* io) {
        close_memory(io);
        return 0;
    }
    int end(std::optional<Error> fault) {
        fault_ = std::move(fault);
        ended_.request_stop();
        return AVERROR_EXIT;
    }
    Result<void> fetch_playlist() { return take_playlist(fetch_place(place_, largest_hls_playlist)); }
    /// Takes the newest playlist; if none comes, the previous one stays.
    Result<void> take_playlist(Result<std::string> text) {
        const bool is_first = playlist_.empty();
        auto facts = text ? check_hls_media(*text, place_) : Result<HlsMediaFacts>(text.error());
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
    Result<std::string> place_named(const std::string& named) const {
        const std::string folder = place_.substr(0, place_.rfind('/') + 1);
        const bool is_file = place_.starts_with("file:") && named.starts_with(folder);
        return resolved_place(place_, is_file ? named.substr(folder.size()) : named);
    }
    int open_segment(AVIOContext** io, const std::string& named, const ByteRange& range);
    Result<std::string> read_segment(const std::string& place, const ByteRange& range) {
        const bool is_part = range.begin > 0 || range.end, is_header = place == facts_.header && !is_part;
        if (is_header && !header_.empty()) return header_;
        auto bytes = fetch_place(place, largest_hls_segment, range);
        if (!bytes) return bytes;
        if (is_hls_playlist(*bytes) || (!facts_.header.empty() && !is_part && !is_whole_mp4(*bytes)))
            return input_error("is no whole segment");
        if (is_header) header_ = *bytes;
        return bytes;
    }
    Error failure(int status) const {
        if (fault_) return *fault_;
        if (stop_requested())
            return error_at(place_, Error{ErrorKind::interrupted, "gave no picture in time"});
        return error_at(place_, input_error(ffmpeg_text(status)));
    }

    const std::string place_;
    HlsLevels* const levels_;
    const bool is_low_;
    AVFormatContext* context_ = nullptr;
    AVIOContext* first_io_ = nullptr;  // of the playlist at opening
    std::string playlist_;             // newest that was checked
    HlsMediaFacts facts_;              // of playlist_
    std::string header_;               // the initialisation, which FFmpeg requests with every playlist
    int held_ = 0;                     // consecutive reloads without a newer one
    std::int64_t segments_lost_ = 0;
    std::int64_t newest_segment_ = -1;  // its number, if there are levels
    std::optional<Error> fault_;        // nothing more is read after it
    std::stop_source ended_;            // ends FFmpeg's reading: after a fault, or if the other level goes on
    PacketPtr ahead_;
    bool at_end_ = false;
};

/// Shared by both renditions of a stream: the level, and the clock by which it is chosen.
struct HlsLevelReading {
    LevelChoice choice;
    std::function<std::int64_t()> now_ns;
};

/// The places of a rendition's media playlists.
struct HlsLevelPlaces {
    std::string full, low;  ///< low: empty if there is none
};

/// One rendition, full or low as `reading` chooses. It changes at a segment's beginning, once the other level
/// is open there; if that fails, it stays, and tries again before the next segment.
class HlsLevels : NonCopyable {
public:
    /// `reading`: null: the full level only. `text`: the full level's playlist, if already fetched.
    static Result<std::unique_ptr<HlsLevels>> open(HlsLevelPlaces places, bool is_touch,
                                                   std::shared_ptr<HlsLevelReading> reading,
                                                   std::optional<std::string> text = {}) {
        std::unique_ptr<HlsLevels> levels(new HlsLevels(std::move(places), is_touch, std::move(reading)));
        HlsLevels* const chooses = levels->reading_ ? levels.get() : nullptr;
        TRY_ASSIGN(levels->read_,
                   HlsRendition::open(levels->places_.full, {.text = std::move(text), .levels = chooses}));
        return levels;
    }

    /// As in HlsRendition.
    Result<const AVPacket*> peek() {
        auto packet = read_->peek();
        if (!packet || *packet || !next_) return packet;
        lost_before_ += read_->segments_lost();
        read_ = std::move(next_);
        is_low_ = !is_low_;
        ++changes_;
        return read_->peek();
    }
    PacketPtr take() { return read_->take(); }
    const AVStream& stream_of(const AVPacket& packet) const { return read_->stream_of(packet); }
    std::int64_t time_ns(const AVPacket& packet) const { return read_->time_ns(packet); }
    bool has_ended() const { return read_->has_ended(); }
    std::int64_t segments_lost() const { return lost_before_ + read_->segments_lost(); }

    /// Level of the packet that `peek` returned.
    bool is_low() const { return is_low_; }
    /// How long each level is in what was fetched.
    StreamFigures::Levels levels() const {
        return {in_seconds(fetched_ns_[0]), in_seconds(fetched_ns_[1]), changes_, is_low_};
    }

    // Called by the rendition that is being read:
    /// Called before a segment is fetched, while the rendition is being read: true ends the rendition there,
    /// and `peek` goes on with the other level.
    bool goes_over_before(std::int64_t number, bool from_low) {
        const bool to_low = reading_->choice.is_low();
        if (is_opening_ || next_ || to_low == from_low) return false;
        is_opening_ = true;
        auto other = HlsRendition::open(to_low ? places_.low : places_.full,
                                        {.from = number, .levels = this, .is_low = to_low});
        is_opening_ = false;
        if (other) next_ = std::move(*other);
        return next_ != nullptr;
    }
    /// `segment`: only its bytes and times are set.
    void note(FetchedSegment segment, bool is_low) {
        segment.is_touch = is_touch_;
        segment.is_low = is_low;
        if (segment.bytes > 0) fetched_ns_[is_low ? 1 : 0] += segment.duration_ns;
        reading_->choice.add(segment);
    }
    std::int64_t now_ns() const { return reading_->now_ns(); }

private:
    HlsLevels(HlsLevelPlaces places, bool is_touch, std::shared_ptr<HlsLevelReading> reading)
        : places_(std::move(places)),
          is_touch_(is_touch),
          reading_(places_.low.empty() ? nullptr : std::move(reading)) {}

    const HlsLevelPlaces places_;
    const bool is_touch_;
    const std::shared_ptr<HlsLevelReading> reading_;
    std::unique_ptr<HlsRendition> read_, next_;  // next_: the other level's, which follows
    bool is_low_ = false, is_opening_ = false;
    std::int64_t changes_ = 0, lost_before_ = 0, fetched_ns_[2]{};
};

int HlsRendition::open_segment(AVIOContext** io, const std::string& named, const ByteRange& range) {
    const auto place = place_named(named);
    std::optional<HlsListedSegment> listed;
    if (levels_ && place && *place != facts_.header)
        listed = segment_in(playlist_, place_, *place, newest_segment_ + 1);
    if (listed && levels_->goes_over_before(listed->number, is_low_)) return end(std::nullopt);
    const std::int64_t begin_ns = listed ? levels_->now_ns() : 0;
    auto segment = place ? read_segment(*place, range) : Result<std::string>(place.error());
    if (!segment && segment.error().kind == ErrorKind::interrupted)
        return end(error_at(named, segment.error()));
    if (listed) {
        newest_segment_ = listed->number;
        levels_->note({.bytes = segment ? std::ssize(*segment) : 0,
                       .fetch_ns = levels_->now_ns() - begin_ns,
                       .duration_ns = listed->duration_ns},
                      is_low_);
    }
    if (!segment) {
        ++segments_lost_;
        return AVERROR(ENOENT);  // FFmpeg goes on with the next one
    }
    *io = open_memory(std::move(*segment));
    return *io ? 0 : AVERROR(ENOMEM);
}

// --- BothRenditions

/// At opening; touch needs the rest of the time.
constexpr std::chrono::seconds longest_wait_for_colour{4};

class BothRenditions final : public HlsInput {
public:
    BothRenditions(std::unique_ptr<HlsLevels> touch, std::shared_ptr<HlsLevelReading> reading)
        : touch_(std::move(touch)), reading_(std::move(reading)), is_live_(!touch_->has_ended()) {}

    void add_colour(Result<std::unique_ptr<HlsLevels>> colour) {
        if (colour)
            colour_ = std::move(*colour);
        else
            leave_out_colour(colour.error());
    }

    Result<std::optional<Packet>> next() override {
        TRY_ASSIGN(const auto touch, touch_->peek());
        TRY_ASSIGN(const auto colour, next_of_colour());
        if (!touch && !colour) return std::optional<Packet>();
        const bool is_touch = touch && (!colour || touch_->time_ns(*touch) <= colour_->time_ns(*colour));
        HlsLevels& of = is_touch ? *touch_ : *colour_;
        const AVStream* const stream = &of.stream_of(is_touch ? *touch : *colour);
        return std::optional(Packet{is_touch, of.is_low(), stream, of.take()});
    }

    bool is_live() const override { return is_live_; }
    std::int64_t segments_lost() const override {
        return touch_->segments_lost() + (colour_ ? colour_->segments_lost() : 0);
    }

    std::optional<StreamFigures::Levels> levels() const override {
        return reading_ ? std::optional(touch_->levels()) : std::nullopt;
    }

    const std::vector<std::string>& remarks() const override { return remarks_; }

private:
    /// If colour fails, the stream goes on without it: colour is not felt.
    Result<const AVPacket*> next_of_colour() {
        if (!colour_) return static_cast<const AVPacket*>(nullptr);
        auto packet = colour_->peek();
        if (packet || stop_requested()) return packet;
        leave_out_colour(packet.error());
        return static_cast<const AVPacket*>(nullptr);
    }

    void leave_out_colour(const Error& why) {
        remarks_.push_back("its colour cannot be had: " + why.message);
        colour_.reset();
        if (reading_) reading_->choice.leave_out_colour();
    }

    const std::unique_ptr<HlsLevels> touch_;
    const std::shared_ptr<HlsLevelReading> reading_;  // null: there is one level
    const bool is_live_;
    std::unique_ptr<HlsLevels> colour_;  // null: none, or lost
    std::vector<std::string> remarks_;
};

/// The place of a URL or a file.
std::string place_of(const std::string& named) {
    if (named.starts_with("http://") || named.starts_with("https://")) {
        const auto plain = resolved_place(named, named);
        return plain ? *plain : named;
    }
    std::error_code ignored;
    return "file:" + std::filesystem::absolute(named, ignored).lexically_normal().string();
}

}  // namespace

// --- LevelChoice

void LevelChoice::add(const FetchedSegment& fetched) {
    if (fetched.duration_ns <= 0) return;
    const bool failed = fetched.bytes <= 0;
    if (failed && fetched.fetch_ns <= fetched.duration_ns)
        return;  // a missing file says nothing about the link
    const std::size_t k = fetched.is_touch ? 0 : 1;
    bytes_[k] = static_cast<double>(fetched.bytes);
    seconds_[k] = std::max(in_seconds(fetched.fetch_ns), 1e-9);
    if (!failed) needs_[fetched.is_low ? 1 : 0][k] = bytes_[k] / in_seconds(fetched.duration_ns);
    if (!fetched.is_touch) return;  // colour is judged together with touch
    const double seconds = seconds_[0] + seconds_[1], newest = (bytes_[0] + bytes_[1]) / seconds;
    quick_ += (has_rate_ ? quick_share : 1) * (newest - quick_);
    slow_ += (has_rate_ ? slow_share : 1) * (newest - slow_);
    has_rate_ = true;
    if (!is_low_) {
        is_low_ = seconds > in_seconds(fetched.duration_ns) || rate() < need(false);
        good_ = 0;
        return;
    }
    good_ = rate() >= rate_to_spare * need(false) ? good_ + 1 : 0;
    is_low_ = good_ < segments_before_up;
}

// --- HlsInput

Result<std::unique_ptr<HlsInput>> HlsInput::open(const std::string& named,
                                                 std::function<std::int64_t()> now_ns) {
    const std::string place = place_of(named);
    TRY_ASSIGN(auto text, error_at(named, fetch_place(place, largest_hls_playlist)));
    TRY_ASSIGN(const auto places, error_at(named, places_in_playlist(text, place)));
    // Colour is opened first, so that it begins no later in a live stream.
    std::shared_ptr<HlsLevelReading> reading;
    if (now_ns && !places.low_touch.empty()) {
        reading = std::make_shared<HlsLevelReading>();
        reading->now_ns = std::move(now_ns);
    }
    auto colour = work_until(std::chrono::steady_clock::now() + longest_wait_for_colour, [&] {
        return places.colour.empty() ? Result<std::unique_ptr<HlsLevels>>(nullptr)
                                     : HlsLevels::open({places.colour, places.low_colour}, false, reading);
    });
    const bool is_media = places.touch == place;
    TRY_ASSIGN(auto touch, HlsLevels::open({places.touch, places.low_touch}, true, reading,
                                           is_media ? std::optional(std::move(text)) : std::nullopt));
    auto input = std::make_unique<BothRenditions>(std::move(touch), std::move(reading));
    input->add_colour(std::move(colour));
    return std::unique_ptr<HlsInput>(std::move(input));
}

}  // namespace touchable
