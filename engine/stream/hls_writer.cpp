#include "engine/stream/hls_writer.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/stream/hls_folder.hpp"
#include "engine/stream/hls_text.hpp"
#include "engine/stream/labelled_encoder.hpp"
#include "engine/stream/memory_muxer.hpp"
#include "engine/stream/stream_sound.hpp"
#include "engine/video/matroska_writer.hpp"

namespace touchable {
namespace {

constexpr std::int64_t hls_second = 1'000'000'000, ns_per_hls_ms = 1'000'000;
constexpr AVRational hls_tick{1, 90'000}, hls_ms{1, 1000};
constexpr std::size_t fewest_in_window = 3;  // RFC 8216, 6.2.2
/// Beyond what RFC 8216 asks for: those who fetch slowly have so much longer.
constexpr std::int64_t stays_longer_ns = 10 * hls_second;

std::int64_t tick_at(std::int64_t ns) {
    return av_rescale(ns, hls_tick.den, hls_second);
}

std::string_view text_of_bytes(const std::vector<std::uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// One of both, which players take by itself.
struct Rendition {
    std::string name;
    std::unique_ptr<MemoryMuxer> muxer;
    std::vector<std::size_t> tracks{};  // of the encoder; track k is stream k
    HlsMedia media{};
    std::int64_t most_bits_s = 0;
};

class FolderWriter final : public HlsWriter {
public:
    FolderWriter(const HlsSettings& settings, const SceneDescription& described, HlsFolder folder)
        : settings_(settings), described_(described), folder_(std::move(folder)) {}
    Result<void> take_sound(const std::optional<SoundPart>& sound);
    Result<void> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns) override;
    Result<void> finish() override;
    const std::vector<std::string>& notes() const override { return notes_; }
    const HlsFigures& figures() const override { return figures_; }

private:
    bool is_live() const { return settings_.window_ns > 0; }
    std::int64_t frame_ns() const {
        const FrameRate& rate = described_.scene.rate;
        return std::max<std::int64_t>(1, hls_second * rate.den / rate.num);
    }
    std::int64_t target_s() const;
    Result<void> begin(const RawFrame& first);
    Result<void> add_rendition(const char* name, bool colour);
    Result<void> add_sound_stream();
    Result<void> write_sound(const RawFrame& frame, std::int64_t time_ns);
    Result<void> write_sound_until(std::int64_t until_ms);
    Result<void> end_segment(std::int64_t end_ns);
    Result<void> put_segment(Rendition& rendition, const HlsSegment& like);
    void shorten(HlsMedia& media, std::int64_t now_ns);
    Result<void> publish(std::int64_t now_ns);
    Result<void> put_master();

    const HlsSettings settings_;
    const SceneDescription described_;
    HlsFolder folder_;
    std::vector<std::string> notes_;
    HlsFigures figures_;
    std::optional<LabelledEncoder> encoder_;
    std::vector<Rendition> renditions_;  // that which players show comes first
    std::optional<StreamSound> sound_;
    int sound_stream_ = 0;
    std::uint64_t epoch_ = 0;                          // of the newest frame
    std::int64_t begin_ns_ = 0, newest_ns_ = 0;        // of the segment, and of the newest frame
    std::int64_t begin_taken_ns_ = 0;                  // of the segment
    bool is_after_a_break_ = false, is_empty_ = true;  // the segment
    std::int64_t number_ = 0, stated_bits_s_ = 0;      // of the segment; in the master playlist
};

/// By the frames that a segment has where they come evenly.
std::int64_t FolderWriter::target_s() const {
    const std::int64_t frame = frame_ns();
    const std::int64_t frames = std::max<std::int64_t>(1, (settings_.segment_ns + frame / 2) / frame);
    return std::max<std::int64_t>(1, (frames * frame + hls_second / 2) / hls_second);
}

Result<void> FolderWriter::take_sound(const std::optional<SoundPart>& sound) {
    if (!sound) return {};
    auto opened = StreamSound::open(*sound);
    if (!opened) return opened.error();
    if (opened->codec().codec_id == AV_CODEC_ID_AAC)
        sound_ = std::move(*opened);
    else
        notes_.push_back("the sound is left out: it is " +
                         std::string(avcodec_get_name(opened->codec().codec_id)) +
                         ", and players of HLS have AAC");
    return {};
}

Result<void> FolderWriter::add_sound_stream() {
    MemoryMuxer& muxer = *renditions_.front().muxer;
    sound_stream_ = static_cast<int>(muxer.context().nb_streams);
    AVStream* const stream = avformat_new_stream(&muxer.context(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return Error{ErrorKind::internal, "out of memory"};
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->time_base = {1, std::max(1, stream->codecpar->sample_rate)};
    return {};
}

Result<void> FolderWriter::add_rendition(const char* name, bool colour) {
    auto muxer = MemoryMuxer::open("mp4");
    if (!muxer) return muxer.error();
    Rendition rendition{name, std::move(*muxer)};
    AVFormatContext& context = rendition.muxer->context();
    for (std::size_t k = 0; k < encoder_->tracks(); ++k) {
        if ((encoder_->role(k) == PlaneRole::colour) != colour) continue;
        AVStream* const stream = avformat_new_stream(&context, nullptr);
        if (!stream) return Error{ErrorKind::internal, "out of memory"};
        if (auto described = encoder_->describe(k, *stream->codecpar); !described) return described;
        stream->time_base = hls_tick;
        stream->id = static_cast<int>(rendition.tracks.size()) + 1;
        av_dict_set(&stream->metadata, "handler_name", encoder_->name(k).c_str(), 0);
        rendition.tracks.push_back(k);
    }
    if (rendition.tracks.empty()) return {};
    rendition.media.target_s = target_s();
    rendition.media.first = number_;
    rendition.media.header = folder_.header_name(name);
    rendition.media.is_whole = !is_live();
    renditions_.push_back(std::move(rendition));
    return {};
}

Result<void> FolderWriter::begin(const RawFrame& first) {
    auto encoder = LabelledEncoder::open(first, described_, TrackCoding::h264_thrifty);
    if (!encoder) return encoder.error();
    encoder_.emplace(std::move(*encoder));
    number_ = is_live() ? folder_.first_segment() : 0;
    is_after_a_break_ = number_ > 0;
    for (const bool colour : {true, false})
        if (auto added = add_rendition(colour ? "colour" : "touch", colour); !added) return added;
    if (first.colour.empty()) {
        notes_.push_back("the clip has no colour: ordinary players have its depth alone, as grey");
        folder_.retire(std::string(hls_colour_name), 0);  // of a run before
    }
    if (sound_)
        if (auto added = add_sound_stream(); !added) return added;
    for (Rendition& rendition : renditions_) {
        // A picture of each track by turns: whoever reads on needs no more memory than that.
        constexpr const char* fragments =
            "movflags=+frag_custom+empty_moov+default_base_moof+cmaf:frag_interleave=1";
        if (auto begun = rendition.muxer->begin(fragments); !begun) return begun;
        const auto header = rendition.muxer->take();
        if (auto put = folder_.put(rendition.media.header, text_of_bytes(header)); !put) return put;
    }
    return {};
}

Result<void> FolderWriter::write_sound_until(std::int64_t until_ms) {
    while (sound_) {
        const auto packet = sound_->next(until_ms);
        if (!packet) return packet.error();
        if (!*packet) return {};
        if (auto written = renditions_.front().muxer->write(**packet, sound_stream_, hls_ms); !written)
            return written;
    }
    return {};
}

Result<void> FolderWriter::write_sound(const RawFrame& frame, std::int64_t time_ns) {
    const std::int64_t time_ms = (time_ns + ns_per_hls_ms / 2) / ns_per_hls_ms;
    if (frame.epoch != epoch_ && sound_) {
        if (auto written = write_sound_until(time_ms - 1); !written) return written;
        if (auto begun = sound_->begin_round(time_ms); !begun) return begun;
    }
    epoch_ = frame.epoch;
    return write_sound_until(time_ms);
}

Result<void> FolderWriter::add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns) {
    if (!encoder_) {
        epoch_ = frame.epoch;
        if (auto begun = begin(frame); !begun) return begun;
    } else {
        time_ns = std::max(time_ns, newest_ns_ + shortest_frame_ns);
        if (time_ns + frame_ns() / 2 > begin_ns_ + settings_.segment_ns)
            if (auto ended = end_segment(time_ns); !ended) return ended;
    }
    if (is_empty_) {
        begin_ns_ = time_ns;
        begin_taken_ns_ = label.taken_ns;
    }
    if (auto written = write_sound(frame, time_ns); !written) return written;
    auto packets = encoder_->encode(frame, label, is_empty_);
    if (!packets) return packets.error();
    for (Rendition& rendition : renditions_)
        for (std::size_t k = 0; k < rendition.tracks.size(); ++k) {
            AVPacket& packet = *(*packets)[rendition.tracks[k]];
            packet.pts = packet.dts = tick_at(time_ns);
            packet.duration = tick_at(time_ns + frame_ns()) - tick_at(time_ns);
            if (auto written = rendition.muxer->write(packet, static_cast<int>(k), hls_tick); !written)
                return written;
        }
    is_empty_ = false;
    newest_ns_ = time_ns;
    return {};
}

Result<void> FolderWriter::put_segment(Rendition& rendition, const HlsSegment& like) {
    if (auto flushed = rendition.muxer->flush(); !flushed) return flushed;
    const auto bytes = rendition.muxer->take();
    HlsSegment segment = like;
    segment.name = folder_.segment_name(rendition.name, number_);
    if (auto put = folder_.put(segment.name, text_of_bytes(bytes)); !put) return put;
    (rendition.name == "colour" ? figures_.colour_bytes : figures_.touch_bytes) += std::ssize(bytes);
    const std::int64_t bits = std::ssize(bytes) * 8;
    rendition.most_bits_s = std::max(
        rendition.most_bits_s, av_rescale(bits, hls_second, std::max<std::int64_t>(1, segment.duration_ns)));
    rendition.media.segments.push_back(std::move(segment));
    return {};
}

/// The segment ends where the next one begins.
Result<void> FolderWriter::end_segment(std::int64_t end_ns) {
    const std::int64_t longest = target_s() * hls_second + hls_second / 2 - 1;
    const bool breaks = end_ns - begin_ns_ > longest;  // the source stood still
    const HlsSegment segment{"", breaks ? newest_ns_ + frame_ns() - begin_ns_ : end_ns - begin_ns_,
                             begin_taken_ns_, is_after_a_break_};
    for (Rendition& rendition : renditions_)
        if (auto put = put_segment(rendition, segment); !put) return put;
    ++number_;
    ++figures_.segments;
    figures_.duration_ns += segment.duration_ns;
    is_empty_ = true;
    is_after_a_break_ = breaks;
    return is_live() ? publish(end_ns) : Result<void>{};
}

void FolderWriter::shorten(HlsMedia& media, std::int64_t now_ns) {
    std::int64_t all = 0;
    for (const HlsSegment& segment : media.segments) all += segment.duration_ns;
    while (media.segments.size() > fewest_in_window &&
           all - media.segments.front().duration_ns >= settings_.window_ns) {
        all -= media.segments.front().duration_ns;
        folder_.retire(std::move(media.segments.front().name), now_ns);
        media.segments.pop_front();
        ++media.first;
    }
}

/// Playlists name what is there: they come after it.
Result<void> FolderWriter::publish(std::int64_t now_ns) {
    figures_.playlist_bytes = 0;
    for (Rendition& rendition : renditions_) {
        if (is_live()) shorten(rendition.media, now_ns);
        const std::string text = text_of(rendition.media);
        figures_.playlist_bytes += std::ssize(text);
        if (auto put = folder_.put(rendition.name + ".m3u8", text); !put) return put;
    }
    if (auto put = put_master(); !put) return put;
    folder_.retire_old(now_ns);
    folder_.remove_retired(now_ns - settings_.window_ns - 2 * settings_.segment_ns - stays_longer_ns);
    return {};
}

Result<void> FolderWriter::put_master() {
    const Rendition& shown = renditions_.front();
    if (shown.most_bits_s <= stated_bits_s_) return {};
    // Of what comes nobody knows how much it is.
    stated_bits_s_ = is_live() ? shown.most_bits_s + shown.most_bits_s / 4 : shown.most_bits_s;
    std::string codecs;
    for (unsigned k = 0; k < shown.muxer->context().nb_streams; ++k) {
        const AVCodecParameters& stored = *shown.muxer->context().streams[k]->codecpar;
        const auto name =
            stored.codec_id == AV_CODEC_ID_H264
                ? avc_codec_name({stored.extradata, static_cast<std::size_t>(stored.extradata_size)})
                : std::optional<std::string>("mp4a.40.2");
        if (!name) return Error{ErrorKind::internal, "encoder: H.264 without its parameters"};
        if (codecs.find(*name) == std::string::npos) codecs += (codecs.empty() ? "" : ",") + *name;
    }
    const Scene& scene = described_.scene;
    return folder_.put(std::string(hls_master_name),
                       master_text({shown.name + ".m3u8", stated_bits_s_, codecs, scene.width, scene.height,
                                    scene.rate.per_second()}));
}

Result<void> FolderWriter::finish() {
    if (!encoder_) return input_error(folder_.path().string() + ": not written: no frame was given");
    if (auto ended = end_segment(newest_ns_ + frame_ns()); !ended) return ended;
    for (Rendition& rendition : renditions_) rendition.media.has_ended = true;
    if (auto published = publish(newest_ns_); !published) return published;
    if (!is_live()) folder_.remove_retired(newest_ns_);
    return {};
}

}  // namespace

Result<std::unique_ptr<HlsWriter>> HlsWriter::open(const HlsSettings& settings,
                                                   const SceneDescription& described,
                                                   const std::optional<SoundPart>& sound) {
    if (settings.segment_ns < hls_second / 2 || settings.segment_ns > 10 * hls_second)
        return usage_error("segments of HLS last from 0.5 to 10 seconds");
    if (settings.window_ns < 0) return usage_error("the window of HLS lasts 0 seconds or more");
    if (auto storable = check_storable(settings.folder, described); !storable) return storable.error();
    auto folder = HlsFolder::open(settings.folder, settings.window_ns == 0);
    if (!folder) return folder.error();
    auto writer = std::make_unique<FolderWriter>(settings, described, std::move(*folder));
    if (auto taken = writer->take_sound(sound); !taken) return taken.error();
    return std::unique_ptr<HlsWriter>(std::move(writer));
}

}  // namespace touchable
