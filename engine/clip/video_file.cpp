// SPDX-License-Identifier: Apache-2.0
// The track of pictures of any video file: how it is chosen, its frames, and their times and rate.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/clip/tracks.hpp"

extern "C" {
#include <libavutil/pixdesc.h>
#include <libavutil/rational.h>
}

namespace touchable {
namespace {

constexpr int largest_term = 1'000'000'000;  // of a scene's rate, numerator or denominator

/// Frames that are not shown: cut off by an edit list, or VP8's reference-only frames.
bool is_hidden(const AVPacket& packet, AVCodecID codec) {
    constexpr int vp8_shown = 0x10;
    return (packet.flags & AV_PKT_FLAG_DISCARD) != 0 || packet.size == 0 ||
           (codec == AV_CODEC_ID_VP8 && (packet.data[0] & vp8_shown) == 0);
}

bool keeps_to(const std::vector<std::int64_t>& times, AVRational tick, AVRational rate) {
    const double ticks = static_cast<double>(rate.den) / rate.num * tick.den / tick.num;
    for (std::size_t n = 0; n < times.size(); ++n) {
        const double late = static_cast<double>(times[n] - times[0]) - static_cast<double>(n) * ticks;
        if (!(std::fabs(late) <= 1.001)) return false;
    }
    return true;
}

/// Whether a track's title fits the role, as cameras ("DEPTH", "COLOR") and people ("Depth map") call it.
bool is_named(const AVStream& stream, PlaneRole role) {
    const AVDictionaryEntry* const title = av_dict_get(stream.metadata, "title", nullptr, 0);
    if (title == nullptr) return false;
    const std::string name = small_letters(title->value);
    const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
    if (role == PlaneRole::depth) return has("depth");
    return role == PlaneRole::colour && !has("depth") && (has("color") || has("colour") || has("rgb"));
}

bool has_pictures(const AVStream& stream) {
    return stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO &&
           (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
}

/// Whether the first picture of a track is grey of more than 8 bits: beside a track in colour that is depth.
/// Decodes it: containers do not state this for all codecs.
bool begins_in_deep_grey(const SourceFile& file, int stream) {
    constexpr int most_packets = 64;
    const auto demuxer = Demuxer::open_video(file);
    if (!demuxer) return false;
    auto decoder =
        TrackDecoder::open(*(*demuxer)->container().streams[stream], PlaneRole::depth, file.string());
    if (!decoder) return false;
    (*demuxer)->select(stream);
    for (int k = 0; k < most_packets && !stop_requested(); ++k) {
        const auto decoded = decoder->receive_frame();
        if (!decoded || (!*decoded && decoder->drained())) return false;
        if (*decoded) {
            const AVPixFmtDescriptor* const pixels =
                av_pix_fmt_desc_get(static_cast<AVPixelFormat>((*decoded)->frame->format));
            return pixels != nullptr && pixels->nb_components == 1 && pixels->comp[0].depth > 8;
        }
        const auto packet = (*demuxer)->next(stream);
        if (!packet || !decoder->send(packet->get())) return false;
    }
    return false;
}

/// Times after the first, ns.
std::vector<std::int64_t> nanoseconds(const std::vector<std::int64_t>& times, AVRational tick) {
    constexpr AVRational nanosecond{1, 1'000'000'000};
    std::vector<std::int64_t> after;
    after.reserve(times.size());
    for (const std::int64_t time : times)
        after.push_back(av_rescale_q(time - times.front(), tick, nanosecond));
    return after;
}

}  // namespace

VideoFile::MeasuredRate VideoFile::measured_rate(const std::vector<std::int64_t>& times, AVRational tick,
                                                 const std::vector<AVRational>& said) {
    std::vector<AVRational> candidates = said;
    for (const int rate : {30, 25, 24, 60, 50, 15, 10, 5, 1, 20, 12, 90, 100, 120}) {
        candidates.push_back({rate, 1});
        candidates.push_back({1000 * rate, 1001});
    }
    const auto is_term = [](int term) { return term > 0 && term <= largest_term; };
    for (const AVRational rate : candidates)
        if (is_term(rate.num) && is_term(rate.den) && keeps_to(times, tick, rate))
            return {{rate.num, rate.den}, true};
    const std::int64_t span = times.size() > 1 ? times.back() - times.front() : 0;
    if (span <= 0) return {{30, 1}, times.size() <= 1};
    const auto frames = static_cast<std::int64_t>(times.size()) - 1;
    AVRational mean{0, 1}, per_second = av_inv_q(tick);
    av_reduce(&mean.num, &mean.den, frames, span, largest_term);
    av_reduce(&mean.num, &mean.den, std::int64_t{mean.num} * per_second.num,
              std::int64_t{mean.den} * per_second.den, largest_term);
    const bool has_mean = mean.num > 0 && mean.den > 0;
    if (has_mean && keeps_to(times, tick, mean)) return {{mean.num, mean.den}, true};
    if (auto own = rate_of_own_times(nanoseconds(times, tick))) return {std::move(*own), true};
    return {has_mean ? FrameRate{mean.num, mean.den} : FrameRate{}, false};
}

Result<std::unique_ptr<VideoFile>> VideoFile::open(const SourceFile& file, PlaneRole role,
                                                   std::optional<std::uint32_t> track) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file.path(), ignored))
        return input_error(file.string() + ": is no file: must be a video");
    std::unique_ptr<VideoFile> video(new VideoFile(file, role, track));
    TRY(video->rewind());
    TRY(video->read_times());
    TRY(video->rewind());
    return video;
}

Result<void> VideoFile::rewind() {
    TRY_ASSIGN(auto demuxer, Demuxer::open_video(file_));
    decoder_.reset();
    demuxer_ = std::move(demuxer);
    const AVFormatContext& container = demuxer_->container();
    const int streams = static_cast<int>(container.nb_streams);
    const auto may_be_it = [&](int k) {
        const AVStream& stream = *container.streams[k];
        return has_pictures(stream) && (!track_ || stream.id == static_cast<int>(*track_));
    };
    const int chosen = stream_;
    bool has_disparity = false;
    for (int k = 0; k < streams; ++k) has_disparity = has_disparity || demuxer_->is_disparity(k);
    const auto is_it = [&](int k) {
        return has_disparity ? demuxer_->is_disparity(k) == (role_ == PlaneRole::depth)
                             : is_named(*container.streams[k], role_);
    };
    const auto is_depths = [&](int k) {
        return role_ == PlaneRole::colour && is_named(*container.streams[k], PlaneRole::depth);
    };
    stream_ = 0;
    while (stream_ < streams && (!may_be_it(stream_) || is_depths(stream_))) ++stream_;
    if (stream_ == streams) stream_ = 0;  // a single track may also be named as depth
    while (stream_ < streams && !may_be_it(stream_)) ++stream_;
    const auto first_of = [&](auto&& fits) {
        for (int k = stream_; k < streams; ++k)
            if (may_be_it(k) && fits(k)) return k;
        return streams;
    };
    int found = first_of(is_it);
    const bool are_several = first_of([&](int k) { return k > stream_; }) < streams;
    if (found == streams && are_several && !has_disparity && !times_.empty()) found = chosen;  // as before
    if (found == streams && are_several && !has_disparity)
        found = first_of([&](int k) { return begins_in_deep_grey(file_, k) == (role_ == PlaneRole::depth); });
    if (found < streams) stream_ = found;
    if (stream_ == streams)
        return input_error(file_.string() + (track_ ? ": has no pictures in track " + std::to_string(*track_)
                                                    : ": has no video track"));
    TRY_ASSIGN(decoder_, TrackDecoder::open(*container.streams[stream_], role_, file_.string()));
    is_lossless_ = is_coded_without_loss(*container.streams[stream_]->codecpar);
    is_disparity_ = demuxer_->is_disparity(stream_);
    demuxer_->select(stream_);
    number_ = 0;
    is_lost_ = false;
    held_.reset();
    return {};
}

bool VideoFile::has_other_pictures() const {
    const AVFormatContext& container = demuxer_->container();
    for (int k = 0; k < static_cast<int>(container.nb_streams); ++k)
        if (container.streams[k]->codecpar->codec_type == AVMEDIA_TYPE_VIDEO && !demuxer_->is_disparity(k))
            return true;
    return false;
}

Result<void> VideoFile::read_times() {
    const AVStream& stream = *demuxer_->container().streams[stream_];
    std::vector<std::pair<std::int64_t, bool>> frames;
    while (true) {
        TRY_ASSIGN(const auto packet, demuxer_->next(stream_));
        if (!packet) break;
        const AVPacket& read = *packet;
        if (is_hidden(read, stream.codecpar->codec_id)) continue;
        const std::int64_t time = read.pts != AV_NOPTS_VALUE ? read.pts : read.dts;
        if (time == AV_NOPTS_VALUE)
            return input_error(where(static_cast<std::int64_t>(frames.size())) +
                               ": has no time: must have one in the container");
        frames.emplace_back(time, (read.flags & AV_PKT_FLAG_KEY) != 0);
    }
    if (frames.empty()) return input_error(file_.string() + ": " + why_without_frames(demuxer_->is_cut()));
    std::ranges::sort(frames);
    for (const auto& [time, is_key] : frames) {
        if (is_key) keys_.push_back(count());
        times_.push_back(time);
    }
    rate_ = measured_rate(times_, stream.time_base, {stream.avg_frame_rate, stream.r_frame_rate});
    if (!rate_.is_kept)
        note_ = file_.string() +
                ": has frames less than 1 ms apart: all are played evenly, at their mean rate, " +
                clip_tags::rate_text(rate_.rate) + " a second";
    const auto& streams = demuxer_->container().streams;
    const bool is_first = std::none_of(streams, streams + stream_,
                                       [](const AVStream* before) { return has_pictures(*before); });
    if (const int others = other_tracks(); others > 0)
        note_ = (note_ ? *note_ + "; it" : file_.string() + ":") + " has " + std::to_string(others + 1) +
                " tracks of pictures, and none is named " + std::string(role_name(role_)) + ": stream " +
                std::to_string(stream_) + " is read" +
                (is_first                    ? ""
                 : role_ == PlaneRole::depth ? ", as it is grey of more than 8 bits"
                                             : ", as the first is grey of more than 8 bits");
    if (demuxer_->is_cut())
        note_ = (note_ ? *note_ + "; it" : file_.string() + ":") + " is cut: its first " +
                counted(count(), "frame is", "frames are") + " whole";
    return {};
}

int VideoFile::other_tracks() const {
    const AVFormatContext& container = demuxer_->container();
    if (track_ || is_disparity_ || is_named(*container.streams[stream_], role_)) return 0;
    int others = 0;
    for (int k = 0; k < static_cast<int>(container.nb_streams); ++k)
        others += k != stream_ && has_pictures(*container.streams[k]) && !demuxer_->is_disparity(k) ? 1 : 0;
    return others;
}

double VideoFile::start() const {
    const AVRational tick = demuxer_->container().streams[stream_]->time_base;
    return static_cast<double>(times_.front()) * av_q2d(tick);
}

double VideoFile::seconds(std::int64_t frame) const {
    const AVRational tick = demuxer_->container().streams[stream_]->time_base;
    return static_cast<double>(times_[static_cast<std::size_t>(frame)] - times_.front()) * av_q2d(tick);
}

std::int64_t VideoFile::nearest(double seconds_after) const {
    const AVRational tick = demuxer_->container().streams[stream_]->time_base;
    const double time = seconds_after / av_q2d(tick) + static_cast<double>(times_.front());
    const auto later = std::ranges::partition_point(
        times_, [&](std::int64_t each) { return static_cast<double>(each) < time; });
    if (later == times_.begin()) return 0;
    if (later == times_.end()) return count() - 1;
    const double after = static_cast<double>(*later) - time, before = time - static_cast<double>(later[-1]);
    return later - times_.begin() - (before <= after ? 1 : 0);
}

Result<std::optional<TrackDecoder::Decoded>> VideoFile::decode() {
    while (true) {
        auto decoded = decoder_->receive_frame();
        if (!decoded || *decoded || decoder_->drained()) return decoded;
        TRY_ASSIGN(const auto packet, demuxer_->next(stream_));
        TRY(decoder_->send(packet.get()));
    }
}

Result<FramePtr> VideoFile::next() {
    if (held_) {
        ++number_;
        return std::move(held_);
    }
    if (number_ >= count()) return FramePtr{};
    auto decoded = decode();
    is_lost_ = !decoded || !*decoded;
    if (!decoded) return decoded.error();
    if (!*decoded)
        return input_error(where(number_) + ": is where the pictures end, but it promises " +
                           std::to_string(count()) + " frames: it is truncated or damaged");
    ++number_;
    return std::move((*decoded)->frame);
}

std::int64_t VideoFile::access_point(std::int64_t frame) const {
    const auto later = std::ranges::upper_bound(keys_, frame);
    return later == keys_.begin() ? 0 : later[-1];
}

/// False if the container's index does not lead there.
Result<bool> VideoFile::begin_at(std::int64_t key) {
    const std::int64_t time = times_[static_cast<std::size_t>(key)];
    if (!demuxer_->seek(stream_, time)) return false;
    decoder_->restart(key);
    // Pictures of the group before may come out first.
    for (int leading = 0; leading < 32; ++leading) {
        auto decoded = decode();
        if (!decoded || !*decoded || (*decoded)->timestamp > time) return false;
        if ((*decoded)->timestamp < time) continue;
        held_ = std::move((*decoded)->frame);
        number_ = key;
        is_lost_ = false;
        return true;
    }
    return false;
}

Result<void> VideoFile::seek(std::int64_t frame) {
    if (frame < 0 || frame > count())
        return usage_error(file_.string() + ": has no frame " + std::to_string(frame) +
                           ": must be from 0 to " + std::to_string(count() - 1));
    const std::int64_t key = access_point(frame);
    if (is_lost_ || number_ > frame || number_ < key) {
        held_.reset();
        TRY_ASSIGN(const auto begun, key > 0 ? begin_at(key) : Result<bool>(false));
        if (!begun) TRY(rewind());
    }
    while (number_ < frame) TRY(next());
    return {};
}

}  // namespace touchable
