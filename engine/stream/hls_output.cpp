// SPDX-License-Identifier: Apache-2.0
// HlsWriter: a stream as a folder of segments and playlists. HlsFolder names its files, writes each
// atomically and deletes old ones; an HlsRenditionOutput encodes a rendition; FolderWriter cuts segments, and
// publishes and shortens the playlists.

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <system_error>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/memory_muxer.hpp"
#include "engine/stream/sending.hpp"

namespace touchable {
namespace {

// --- The folder

namespace fs = std::filesystem;

constexpr std::size_t run_digits = 8, largest_playlist = std::size_t{1} << 22;

/// Whether it is a segment or a header, of any run.
bool is_segment_name(std::string_view name) {
    for (const std::string_view rendition : {"colour-low-", "touch-low-", "colour-", "touch-"}) {
        if (!name.starts_with(rendition)) continue;
        name.remove_prefix(rendition.size());
        if (name.size() < run_digits + 2 || name.find_first_not_of("0123456789abcdef") != run_digits ||
            name[run_digits] != '-')
            return false;
        name.remove_prefix(run_digits + 1);
        return name == "init.mp4" || (name.ends_with(".m4s") && is_digits(name.substr(0, name.size() - 4)));
    }
    return false;
}

bool is_playlist_name(std::string_view name) {
    return name == hls_master_name || name == hls_colour_name || name == hls_touch_name ||
           name == hls_low_colour_name || name == hls_low_touch_name;
}

/// The folder from which a web server delivers a stream. It holds only files that this program wrote,
/// recognised by their names, playlists also by a line in them (hls_mark):
///   master.m3u8, colour.m3u8, touch.m3u8, colour-low.m3u8, touch-low.m3u8
///   colour-RUN-init.mp4, colour-RUN-NUMBER.m4s, and the same of the others; RUN: 8 hexadecimal digits.
/// A file of another run, which a cache may have, thus never has the name of a file of this run.
class HlsFolder {
public:
    /// Creates the folder if it is missing. Refused (ErrorKind::input): a folder with other files in it, or
    /// one in which another program writes. `lasts`: files have to be safe on the disk.
    static Result<HlsFolder> open(const fs::path& path, bool lasts) {
        HlsFolder folder;
        folder.path_ = path;
        folder.lasts_ = lasts;
        const std::string random = hidden_name(path).filename().string();
        folder.run_ = random.substr(random.size() - run_digits);
        std::error_code failure;
        fs::create_directories(path, failure);
        folder.opened_ = Descriptor(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (folder.opened_.get() < 0)
            return input_error(path.string() +
                               ": is no folder that can be made or read: " + failure_words(errno));
        if (flock(folder.opened_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
            return input_error(path.string() + ": another program writes a stream there now");
        TRY(folder.look());
        return folder;
    }

    const std::filesystem::path& path() const { return path_; }
    /// "touch-3f2a91bc-init.mp4", "touch-3f2a91bc-12.m4s": `end` is what follows the run.
    std::string file_name(const std::string& rendition, const std::string& end) const {
        return rendition + "-" + run_ + "-" + end;
    }
    /// Number of the first segment: it continues the previous run, for that run's viewers.
    std::int64_t first_segment() const { return first_segment_; }

    /// Writes the whole file atomically, replacing any other of that name.
    Result<void> put(const std::string& name, std::string_view bytes) const {
        NewFile file(path_ / name);
        if (!lasts_) file.need_not_last();
        TRY(file.write(bytes));
        return file.commit();
    }
    /// Call if no playlist names the file from `time_ns` of the stream on.
    void retire(std::string name, std::int64_t time_ns) { retired_.push_back({std::move(name), time_ns}); }
    /// Retires all files of previous runs.
    void retire_old(std::int64_t time_ns) {
        for (std::string& name : old_) retire(std::move(name), time_ns);
        old_.clear();
    }
    /// Deletes the files that no playlist has named since `before_ns`.
    void remove_retired(std::int64_t before_ns) {
        while (!retired_.empty() && retired_.front().time_ns <= before_ns) {
            unlink((path_ / retired_.front().name).c_str());
            retired_.pop_front();
        }
    }

private:
    HlsFolder() = default;
    Result<void> look() {
        std::error_code failure;
        for (fs::directory_iterator at(path_, failure), end; !failure && at != end; at.increment(failure)) {
            const std::string name = at->path().filename().string();
            const bool is_file = at->symlink_status().type() == fs::file_type::regular;
            // Left by a program that was killed before it renamed the file (NewFile).
            if (is_file && name.starts_with(".unfinished-")) continue;
            bool is_ours = is_file && is_segment_name(name);
            if (is_ours) old_.push_back(name);
            if (is_file && is_playlist_name(name)) {
                const std::string text = first_bytes(SourceFile(at->path()), largest_playlist);
                if (stop_requested()) return interrupted_error();
                is_ours = text.find(std::string(hls_mark) + "\n") != std::string::npos;
                first_segment_ = std::max(first_segment_, next_segment_of(text));
            }
            if (!is_ours)
                return input_error(path_.string() + ": has " + in_quotes(name) +
                                   ", which is not of a stream that this program wrote; must be a folder "
                                   "that is new or empty, or has such a stream alone");
        }
        if (failure) return input_error(path_.string() + ": cannot be read: " + failure.message());
        return {};
    }

    struct Retired {
        std::string name;
        std::int64_t time_ns;
    };
    std::filesystem::path path_;
    Descriptor opened_;  // and locked
    bool lasts_ = true;
    std::string run_;
    std::int64_t first_segment_ = 0;
    std::vector<std::string> old_;  // segments and headers of previous runs
    std::deque<Retired> retired_;
};

// --- One rendition

/// A rendition of a stream: colour or the touch planes, of the full or of the low level.
struct HlsRenditionForm {
    bool is_colour = false, is_low = false;

    std::string name() const { return std::string(is_colour ? "colour" : "touch") + (is_low ? "-low" : ""); }
    std::string playlist() const { return name() + ".m3u8"; }
    /// Frames of the stream per frame of the rendition.
    int step() const { return is_low && !is_colour ? hls_low_step : 1; }
};

constexpr AVRational hls_tick{1, 90'000}, hls_ms{1, 1000};

std::int64_t tick_at(std::int64_t ns) {
    return av_rescale(ns, hls_tick.den, 1'000'000'000);
}

RawFrame planes_of(const HlsRenditionForm& form, const RawFrame& frame) {
    RawFrame planes = frame;
    if (form.is_colour)
        planes.depth = planes.haptic = planes.height = {};
    else
        planes.colour = {};
    return planes;
}

/// Encodes a rendition into fragmented MP4.
class HlsRenditionOutput {
public:
    /// `sound`: added to the rendition; null: none.
    static Result<HlsRenditionOutput> open(const HlsRenditionForm& form, const RawFrame& first,
                                           const SceneDescription& described,
                                           const AVCodecParameters* sound) {
        TRY_ASSIGN(auto encoder,
                   LabelledEncoder::open(planes_of(form, first), described, TrackCoding::h264_thrifty,
                                         form.is_low ? TrackCoding::h264_reduced : TrackCoding::h264_visual));
        TRY_ASSIGN(auto muxer, MemoryMuxer::open("mp4"));
        for (std::size_t k = 0; k < encoder.tracks(); ++k) {
            TRY_ASSIGN(AVStream* const stream, muxer->add_stream(hls_tick));
            TRY(encoder.describe(k, *stream->codecpar));
            stream->id = static_cast<int>(k) + 1;
            av_dict_set(&stream->metadata, "handler_name", encoder.name(k).c_str(), 0);
        }
        std::optional<int> sound_stream;
        if (sound) TRY(assign(sound_stream, muxer->add_sound(*sound, {1, std::max(1, sound->sample_rate)})));
        // The tracks' pictures alternate, so that a reader needs little memory.
        TRY(muxer->begin("movflags=+frag_custom+empty_moov+default_base_moof+cmaf:frag_interleave=1"));
        return HlsRenditionOutput(form, std::move(encoder), std::move(muxer), sound_stream);
    }

    const HlsRenditionForm& form() const { return form_; }
    /// `duration_ns`: time until the rendition's next frame. `is_key`: decoding can begin with this frame.
    Result<void> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                     std::int64_t duration_ns, bool is_key) {
        TRY_ASSIGN(auto packets, encoder_.encode(planes_of(form_, frame), label, is_key));
        for (std::size_t k = 0; k < packets.size(); ++k) {
            AVPacket& packet = *packets[k];
            packet.pts = packet.dts = tick_at(time_ns);
            packet.duration = tick_at(time_ns + duration_ns) - tick_at(time_ns);
            TRY(muxer_->write(packet, static_cast<int>(k), hls_tick));
        }
        return {};
    }

    bool has_sound() const { return sound_stream_.has_value(); }
    /// `packet`: times in milliseconds.
    Result<void> add_sound(const AVPacket& packet) {
        const PacketPtr own(av_packet_clone(&packet));
        if (!own) return memory_error();
        return muxer_->write(*own, *sound_stream_, hls_ms);
    }

    /// Returns all bytes since the last call; at the first call, the initialisation.
    Result<std::vector<std::uint8_t>> take() {
        TRY(muxer_->flush());
        return muxer_->take();
    }

    /// "avc1.64001f,mp4a.40.2".
    Result<std::string> codecs() const {
        std::string codecs;
        for (unsigned k = 0; k < muxer_->context().nb_streams; ++k) {
            const AVCodecParameters& stored = *muxer_->context().streams[k]->codecpar;
            const auto name =
                stored.codec_id == AV_CODEC_ID_H264
                    ? avc_codec_name({stored.extradata, static_cast<std::size_t>(stored.extradata_size)})
                    : std::optional<std::string>("mp4a.40.2");
            if (!name) return Error{ErrorKind::internal, "encoder: H.264 without its parameters"};
            if (codecs.find(*name) == std::string::npos) codecs += (codecs.empty() ? "" : ",") + *name;
        }
        return codecs;
    }

private:
    HlsRenditionOutput(const HlsRenditionForm& form, LabelledEncoder encoder,
                       std::unique_ptr<MemoryMuxer> muxer, std::optional<int> sound_stream)
        : form_(form), encoder_(std::move(encoder)), muxer_(std::move(muxer)), sound_stream_(sound_stream) {}

    HlsRenditionForm form_;
    LabelledEncoder encoder_;  // track k is stream k
    std::unique_ptr<MemoryMuxer> muxer_;
    std::optional<int> sound_stream_;
};

// --- The writer

constexpr std::int64_t hls_second = 1'000'000'000;
constexpr std::size_t fewest_in_window = 3;  // RFC 8216, 6.2.2
/// For slow clients: files stay this much longer than RFC 8216 requires.
constexpr std::int64_t stays_longer_ns = 10 * hls_second;

std::string_view text_of_bytes(const std::vector<std::uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Rendition {
    HlsRenditionOutput output;
    HlsMedia media{};
    std::int64_t most_bits_s = 0, stated_bits_s = 0;  // stated: in the master playlist
};

std::int64_t& bytes_of(const HlsRenditionForm& form, HlsWriter::Figures& figures) {
    if (form.is_colour) return form.is_low ? figures.low_colour_bytes : figures.colour_bytes;
    return form.is_low ? figures.low_touch_bytes : figures.touch_bytes;
}

class FolderWriter final : public HlsWriter {
public:
    FolderWriter(const HlsWriter::Settings& settings, const SceneDescription& described, HlsFolder folder)
        : settings_(settings), described_(described), folder_(std::move(folder)) {}
    /// Adds the sound, if there is one that players have.
    Result<void> open(const std::optional<SoundPart>& sound) {
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
    Result<Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                      bool is_key) override {
        if (renditions_.empty()) {
            TRY(begin(frame));
        } else {
            time_ns = std::max(time_ns, newest_ns_ + shortest_frame_ns);
            if (time_ns + frame_ns() / 2 > begin_ns_ + settings_.segment_ns) TRY(end_segment(time_ns));
        }
        if (frames_ == 0) {
            begin_ns_ = time_ns;
            begin_taken_ns_ = label.taken_ns;
        }
        TRY(write_sound(frame, time_ns));
        for (Rendition& rendition : renditions_) {
            const int step = rendition.output.form().step();
            if (frames_ % step != 0) continue;
            TRY(rendition.output.add(frame, label, time_ns, step * frame_ns(), frames_ == 0));
        }
        ++frames_;
        newest_ns_ = time_ns;
        return Block{label.frame, is_key, {}};
    }
    Result<void> finish() override {
        if (renditions_.empty())
            return input_error(folder_.path().string() + ": not written: no frame was given");
        TRY(end_segment(newest_ns_ + frame_ns()));
        for (Rendition& rendition : renditions_) rendition.media.has_ended = true;
        TRY(publish(newest_ns_));
        if (!is_live()) folder_.remove_retired(newest_ns_);
        return {};
    }
    const std::vector<std::string>& notes() const override { return notes_; }
    const HlsWriter::Figures& figures() const override { return figures_; }

private:
    bool is_live() const { return settings_.window_ns > 0; }
    std::int64_t frame_ns() const {
        const FrameRate& rate = described_.scene.rate;
        return std::max<std::int64_t>(1, hls_second * rate.den / rate.num);
    }
    /// Length of a segment with evenly spaced frames.
    std::int64_t target_s() const {
        const std::int64_t frame = frame_ns();
        const std::int64_t frames = std::max<std::int64_t>(1, (settings_.segment_ns + frame / 2) / frame);
        return std::max<std::int64_t>(1, (frames * frame + hls_second / 2) / hls_second);
    }
    Result<void> begin(const RawFrame& first) {
        number_ = is_live() ? folder_.first_segment() : 0;
        is_after_a_break_ = number_ > 0;
        for (const bool low : {false, true})
            for (const bool colour : {true, false}) {
                const HlsRenditionForm form{colour, low};
                const bool is_there = (!low || settings_.has_low) && (!colour || !first.colour.empty());
                if (is_there) {
                    TRY(add_rendition(form, first));
                } else {
                    folder_.retire(form.playlist(), 0);  // of a previous run
                }
            }
        if (first.colour.empty())
            notes_.push_back("the clip has no colour: ordinary players have its depth alone, as grey");
        return {};
    }
    Result<void> add_rendition(const HlsRenditionForm& form, const RawFrame& first) {
        const bool is_shown = form.is_colour == !first.colour.empty();
        TRY_ASSIGN(auto output, HlsRenditionOutput::open(form, first, described_,
                                                         sound_ && is_shown ? &sound_->codec() : nullptr));
        TRY_ASSIGN(const auto header, output.take());
        Rendition rendition{std::move(output)};
        rendition.media.target_s = target_s();
        rendition.media.first = number_;
        rendition.media.header = folder_.file_name(form.name(), "init.mp4");
        rendition.media.is_whole = !is_live();
        TRY(folder_.put(rendition.media.header, text_of_bytes(header)));
        renditions_.push_back(std::move(rendition));
        return {};
    }
    Result<void> write_sound(const RawFrame& frame, std::int64_t time_ns) {
        if (!sound_) return {};
        return sound_->give(frame.epoch, time_ns, [this](AVPacket& packet) -> Result<void> {
            for (Rendition& rendition : renditions_)
                if (rendition.output.has_sound()) TRY(rendition.output.add_sound(packet));
            return {};
        });
    }
    /// Ends the segment at the beginning of the next one.
    Result<void> end_segment(std::int64_t end_ns) {
        const std::int64_t longest = target_s() * hls_second + hls_second / 2 - 1;
        const bool breaks = end_ns - begin_ns_ > longest;  // the source stood still
        const HlsSegment segment{"", breaks ? newest_ns_ + frame_ns() - begin_ns_ : end_ns - begin_ns_,
                                 begin_taken_ns_, is_after_a_break_};
        for (Rendition& rendition : renditions_) TRY(put_segment(rendition, segment));
        ++number_;
        ++figures_.segments;
        figures_.duration_ns += segment.duration_ns;
        frames_ = 0;
        is_after_a_break_ = breaks;
        return is_live() ? publish(end_ns) : Result<void>{};
    }
    Result<void> put_segment(Rendition& rendition, const HlsSegment& like) {
        TRY_ASSIGN(const auto bytes, rendition.output.take());
        const HlsRenditionForm& form = rendition.output.form();
        HlsSegment segment = like;
        segment.name = folder_.file_name(form.name(), std::to_string(number_) + ".m4s");
        TRY(folder_.put(segment.name, text_of_bytes(bytes)));
        bytes_of(form, figures_) += std::ssize(bytes);
        const std::int64_t bits = std::ssize(bytes) * 8;
        rendition.most_bits_s =
            std::max(rendition.most_bits_s,
                     av_rescale(bits, hls_second, std::max<std::int64_t>(1, segment.duration_ns)));
        rendition.media.segments.push_back(std::move(segment));
        return {};
    }
    void shorten(HlsMedia& media, std::int64_t now_ns) {
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
    /// Playlists are written after the files that they name, and those of the low level first: a viewer that
    /// changes to it finds there what the others name.
    Result<void> publish(std::int64_t now_ns) {
        figures_.playlist_bytes = 0;
        for (auto rendition = renditions_.rbegin(); rendition != renditions_.rend(); ++rendition) {
            if (is_live()) shorten(rendition->media, now_ns);
            const std::string text = text_of(rendition->media);
            if (!rendition->output.form().is_low) figures_.playlist_bytes += std::ssize(text);
            TRY(folder_.put(rendition->output.form().playlist(), text));
        }
        TRY(put_master());
        folder_.retire_old(now_ns);
        folder_.remove_retired(now_ns - settings_.window_ns - 2 * settings_.segment_ns - stays_longer_ns);
        return {};
    }
    Result<HlsShown> shown(const Rendition& rendition) const {
        TRY_ASSIGN(auto codecs, rendition.output.codecs());
        const HlsRenditionForm& form = rendition.output.form();
        const Scene& scene = described_.scene;
        return HlsShown{form.playlist(),   rendition.stated_bits_s,
                        std::move(codecs), scene.width,
                        scene.height,      scene.rate.per_second() / form.step()};
    }
    /// Writes the master playlist if a variant needed more than it states.
    Result<void> put_master() {
        bool is_new = false;
        std::vector<HlsShown> variants;
        for (Rendition& rendition : renditions_) {
            if (rendition.output.form().is_colour != renditions_.front().output.form().is_colour) continue;
            const std::int64_t most = rendition.most_bits_s;
            is_new = is_new || most > rendition.stated_bits_s;
            // The coming bit rate is unknown: a live stream states a quarter more than the largest seen.
            if (most > rendition.stated_bits_s) rendition.stated_bits_s = is_live() ? most + most / 4 : most;
            TRY_ASSIGN(auto variant, shown(rendition));
            variants.push_back(std::move(variant));
        }
        if (!is_new) return {};
        const auto low = variants.size() > 1 ? std::optional(variants[1]) : std::nullopt;
        return folder_.put(std::string(hls_master_name), master_text(variants[0], low));
    }

    const HlsWriter::Settings settings_;
    const SceneDescription described_;
    HlsFolder folder_;
    std::vector<std::string> notes_;
    HlsWriter::Figures figures_;
    std::vector<Rendition> renditions_;  // per level, the one that players show comes first
    std::optional<StreamSound> sound_;
    std::int64_t begin_ns_ = 0, newest_ns_ = 0;     // begin of the segment, time of the newest frame
    std::int64_t begin_taken_ns_ = 0, number_ = 0;  // of the segment
    bool is_after_a_break_ = false;                 // of the segment
    std::int64_t frames_ = 0;                       // in the segment
};

}  // namespace

Result<std::unique_ptr<HlsWriter>> HlsWriter::open(const HlsWriter::Settings& settings,
                                                   const SceneDescription& described,
                                                   const std::optional<SoundPart>& sound) {
    if (settings.segment_ns < hls_second / 2 || settings.segment_ns > 10 * hls_second)
        return usage_error("segments of HLS last from 0.5 to 10 seconds");
    if (settings.window_ns < 0) return usage_error("the window of HLS lasts 0 seconds or more");
    TRY(check_storable(settings.folder, described));
    TRY_ASSIGN(auto folder, HlsFolder::open(settings.folder, settings.window_ns == 0));
    return opened_as<HlsWriter>(std::make_unique<FolderWriter>(settings, described, std::move(folder)),
                                sound);
}

}  // namespace touchable
