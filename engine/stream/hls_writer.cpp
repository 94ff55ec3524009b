#include "engine/stream/hls_writer.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/hls_folder.hpp"
#include "engine/stream/hls_rendition_output.hpp"
#include "engine/stream/hls_text.hpp"
#include "engine/stream/stream_sound.hpp"

namespace touchable {
namespace {

constexpr std::int64_t hls_second = 1'000'000'000, ns_per_hls_ms = 1'000'000;
constexpr std::size_t fewest_in_window = 3;  // RFC 8216, 6.2.2
/// Beyond what RFC 8216 asks for: those who fetch slowly have so much longer.
constexpr std::int64_t stays_longer_ns = 10 * hls_second;

std::string_view text_of_bytes(const std::vector<std::uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Rendition {
    HlsRenditionOutput output;
    HlsMedia media{};
    std::int64_t most_bits_s = 0, stated_bits_s = 0;  // the latter in the master playlist
};

std::int64_t& bytes_of(const HlsRenditionForm& form, HlsFigures& figures) {
    if (form.is_colour) return form.is_low ? figures.low_colour_bytes : figures.colour_bytes;
    return form.is_low ? figures.low_touch_bytes : figures.touch_bytes;
}

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
    Result<void> add_rendition(const HlsRenditionForm& form, const RawFrame& first);
    Result<void> write_sound(const RawFrame& frame, std::int64_t time_ns);
    Result<void> write_sound_until(std::int64_t until_ms);
    Result<void> end_segment(std::int64_t end_ns);
    Result<void> put_segment(Rendition& rendition, const HlsSegment& like);
    void shorten(HlsMedia& media, std::int64_t now_ns);
    Result<void> publish(std::int64_t now_ns);
    Result<HlsShown> shown(const Rendition& rendition) const;
    Result<void> put_master();

    const HlsSettings settings_;
    const SceneDescription described_;
    HlsFolder folder_;
    std::vector<std::string> notes_;
    HlsFigures figures_;
    std::vector<Rendition> renditions_;  // of each level that which players show comes first
    std::optional<StreamSound> sound_;
    std::uint64_t epoch_ = 0;                       // of the newest frame
    std::int64_t begin_ns_ = 0, newest_ns_ = 0;     // of the segment, and of the newest frame
    std::int64_t begin_taken_ns_ = 0, number_ = 0;  // of the segment
    bool is_after_a_break_ = false;                 // the segment
    std::int64_t frames_ = 0;                       // that it has
};

/// By the frames that a segment has where they come evenly.
std::int64_t FolderWriter::target_s() const {
    const std::int64_t frame = frame_ns();
    const std::int64_t frames = std::max<std::int64_t>(1, (settings_.segment_ns + frame / 2) / frame);
    return std::max<std::int64_t>(1, (frames * frame + hls_second / 2) / hls_second);
}

Result<void> FolderWriter::take_sound(const std::optional<SoundPart>& sound) {
    if (!sound) return {};
    TRY_ASSIGN(auto opened, StreamSound::open(*sound));
    if (opened.codec().codec_id == AV_CODEC_ID_AAC)
        sound_ = std::move(opened);
    else
        notes_.push_back("the sound is left out: it is " +
                         std::string(avcodec_get_name(opened.codec().codec_id)) +
                         ", and players of HLS have AAC");
    return {};
}

Result<void> FolderWriter::add_rendition(const HlsRenditionForm& form, const RawFrame& first) {
    const bool is_shown = form.is_colour == !first.colour.empty();
    TRY_ASSIGN(auto output, HlsRenditionOutput::open(form, first, described_,
                                                     sound_ && is_shown ? &sound_->codec() : nullptr));
    TRY_ASSIGN(const auto header, output.take());
    Rendition rendition{std::move(output)};
    rendition.media.target_s = target_s();
    rendition.media.first = number_;
    rendition.media.header = folder_.header_name(form.name());
    rendition.media.is_whole = !is_live();
    if (auto put = folder_.put(rendition.media.header, text_of_bytes(header)); !put) return put;
    renditions_.push_back(std::move(rendition));
    return {};
}

Result<void> FolderWriter::begin(const RawFrame& first) {
    number_ = is_live() ? folder_.first_segment() : 0;
    is_after_a_break_ = number_ > 0;
    for (const bool low : {false, true})
        for (const bool colour : {true, false}) {
            const HlsRenditionForm form{colour, low};
            const bool is_there = (!low || settings_.has_low) && (!colour || !first.colour.empty());
            if (!is_there) folder_.retire(form.playlist(), 0);  // of a run before
            if (!is_there) continue;
            if (auto added = add_rendition(form, first); !added) return added;
        }
    if (first.colour.empty())
        notes_.push_back("the clip has no colour: ordinary players have its depth alone, as grey");
    return {};
}

Result<void> FolderWriter::write_sound_until(std::int64_t until_ms) {
    while (sound_) {
        TRY_ASSIGN(const auto packet, sound_->next(until_ms));
        if (!packet) return {};
        for (Rendition& rendition : renditions_)
            if (rendition.output.has_sound())
                if (auto added = rendition.output.add_sound(*packet); !added) return added;
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
    if (renditions_.empty()) {
        epoch_ = frame.epoch;
        if (auto begun = begin(frame); !begun) return begun;
    } else {
        time_ns = std::max(time_ns, newest_ns_ + shortest_frame_ns);
        if (time_ns + frame_ns() / 2 > begin_ns_ + settings_.segment_ns)
            if (auto ended = end_segment(time_ns); !ended) return ended;
    }
    if (frames_ == 0) {
        begin_ns_ = time_ns;
        begin_taken_ns_ = label.taken_ns;
    }
    if (auto written = write_sound(frame, time_ns); !written) return written;
    for (Rendition& rendition : renditions_) {
        const int step = rendition.output.form().step();
        if (frames_ % step != 0) continue;
        if (auto added = rendition.output.add(frame, label, time_ns, step * frame_ns(), frames_ == 0); !added)
            return added;
    }
    ++frames_;
    newest_ns_ = time_ns;
    return {};
}

Result<void> FolderWriter::put_segment(Rendition& rendition, const HlsSegment& like) {
    TRY_ASSIGN(const auto bytes, rendition.output.take());
    const HlsRenditionForm& form = rendition.output.form();
    HlsSegment segment = like;
    segment.name = folder_.segment_name(form.name(), number_);
    if (auto put = folder_.put(segment.name, text_of_bytes(bytes)); !put) return put;
    bytes_of(form, figures_) += std::ssize(bytes);
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
    frames_ = 0;
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

/// Playlists name what is there: they come after it. Those of the low level first: a viewer that goes over to
/// it finds there what the others name.
Result<void> FolderWriter::publish(std::int64_t now_ns) {
    figures_.playlist_bytes = 0;
    for (auto rendition = renditions_.rbegin(); rendition != renditions_.rend(); ++rendition) {
        if (is_live()) shorten(rendition->media, now_ns);
        const std::string text = text_of(rendition->media);
        if (!rendition->output.form().is_low) figures_.playlist_bytes += std::ssize(text);
        if (auto put = folder_.put(rendition->output.form().playlist(), text); !put) return put;
    }
    if (auto put = put_master(); !put) return put;
    folder_.retire_old(now_ns);
    folder_.remove_retired(now_ns - settings_.window_ns - 2 * settings_.segment_ns - stays_longer_ns);
    return {};
}

Result<HlsShown> FolderWriter::shown(const Rendition& rendition) const {
    TRY_ASSIGN(auto codecs, rendition.output.codecs());
    const HlsRenditionForm& form = rendition.output.form();
    const Scene& scene = described_.scene;
    return HlsShown{form.playlist(),   rendition.stated_bits_s,
                    std::move(codecs), scene.width,
                    scene.height,      scene.rate.per_second() / form.step()};
}

/// Once a variant has needed more than it says.
Result<void> FolderWriter::put_master() {
    bool is_new = false;
    std::vector<HlsShown> variants;
    for (Rendition& rendition : renditions_) {
        if (rendition.output.form().is_colour != renditions_.front().output.form().is_colour) continue;
        const std::int64_t most = rendition.most_bits_s;
        is_new = is_new || most > rendition.stated_bits_s;
        // The bit rate of what comes is not known: a live stream states a quarter more than the largest seen.
        if (most > rendition.stated_bits_s) rendition.stated_bits_s = is_live() ? most + most / 4 : most;
        TRY_ASSIGN(auto variant, shown(rendition));
        variants.push_back(std::move(variant));
    }
    if (!is_new) return {};
    const auto low = variants.size() > 1 ? std::optional(variants[1]) : std::nullopt;
    return folder_.put(std::string(hls_master_name), master_text(variants[0], low));
}

Result<void> FolderWriter::finish() {
    if (renditions_.empty())
        return input_error(folder_.path().string() + ": not written: no frame was given");
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
    TRY(check_storable(settings.folder, described));
    TRY_ASSIGN(auto folder, HlsFolder::open(settings.folder, settings.window_ns == 0));
    auto writer = std::make_unique<FolderWriter>(settings, described, std::move(folder));
    TRY(writer->take_sound(sound));
    return std::unique_ptr<HlsWriter>(std::move(writer));
}

}  // namespace touchable
