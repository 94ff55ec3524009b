#include "engine/media/matroska_reader.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "engine/media/clip_tags.hpp"
#include "engine/media/codecs.hpp"
#include "engine/media/demuxer.hpp"
#include "engine/media/far_plane.hpp"
#include "engine/media/track_decoder.hpp"
#include "engine/printable.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

class MatroskaReader final : public ClipReader {
public:
    explicit MatroskaReader(const std::filesystem::path& path) : path_(path), file_(path.string()) {
        add_input(path);
    }
    Result<void> open(const std::optional<Scene>& replacement);

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return promised_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override;
    void leave_out_colour() override { with_colour_ = false; }

private:
    struct Track {
        int stream = 0;
        TrackDecoder decoder;
    };
    using Picture = TrackDecoder::Picture;

    Error refuse(const std::string& what) const { return input_error(file_ + ": " + what); }
    Result<void> open_file();
    Result<void> start();
    Result<void> read_version_and_rate();
    Result<void> read_scene(const std::optional<Scene>& replacement);
    Result<void> open_tracks();
    Result<void> describe();
    Result<std::optional<Picture>> picture(Track& track);
    bool is_left_out(const Track& track) const;
    Result<bool> skip(Track& track);
    Result<bool> read_plane(Track& track, RawFrame& frame);
    Result<void> check_time(const Track& track, std::int64_t timestamp);
    Result<std::optional<RawFrame>> read();
    Result<void> check_end(const std::vector<std::string>& present,
                           const std::vector<std::string>& ended) const;

    std::filesystem::path path_;
    std::string file_;
    Scene scene_;
    FrameRate recorded_rate_;
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    std::int64_t promised_ = 0;
    bool with_colour_ = true;

    // Where the reading is; `open_file` and `start` make it anew.
    std::unique_ptr<Demuxer> demuxer_;
    std::vector<Track> tracks_;
    std::int64_t number_ = 0;        // of the frame that `read` gives next
    double origin_seconds_ = 0;      // timestamp of frame 0
    std::optional<RawFrame> first_;  // read to learn the tracks' formats, not yet given away
};

Result<void> MatroskaReader::open(const std::optional<Scene>& replacement) {
    if (auto opened = open_file(); !opened) return opened;
    if (auto read = read_version_and_rate(); !read) return read;
    if (auto read = read_scene(replacement); !read) return read;
    if (auto started = start(); !started) return started;
    return describe();
}

/// From the first byte again: a seek would trust the file's index.
Result<void> MatroskaReader::rewind() {
    if (auto opened = open_file(); !opened) return opened;
    return start();
}

Result<void> MatroskaReader::open_file() {
    auto demuxer = Demuxer::open_matroska(path_);
    if (!demuxer) return demuxer.error();
    tracks_.clear();
    demuxer_ = std::move(*demuxer);
    return {};
}

Result<void> MatroskaReader::read_version_and_rate() {
    const auto version = demuxer_->tag(clip_tags::version_tag);
    if (!version) return refuse("is not a touchable clip: it has no tag T3D_VERSION");
    const auto number = clip_tags::parse_version(*version);
    if (!number)
        return refuse("its tag T3D_VERSION is " + in_quotes(*version) + ": must be a whole number from 1");
    if (*number > clip_format_version)
        return refuse("is of clip format " + printable(*version) + "; this program reads up to " +
                      std::to_string(clip_format_version) + ": use a newer one");
    const auto rate = demuxer_->tag(clip_tags::rate_tag);
    const auto parsed = rate ? clip_tags::parse_rate(*rate) : std::nullopt;
    if (!parsed || clip_tags::is_too_fast(*parsed))
        return refuse("its tag T3D_RATE is " + (rate ? in_quotes(*rate) : "missing") +
                      ": must be a frame rate such as 30000/1001, at most " +
                      std::to_string(clip_tags::fastest_rate) + "/1");
    recorded_rate_ = *parsed;
    return {};
}

Result<void> MatroskaReader::read_scene(const std::optional<Scene>& replacement) {
    if (replacement) {
        scene_ = *replacement;
        if (auto note = clip_tags::rate_note(scene_.rate, recorded_rate_)) notes_.push_back(std::move(*note));
        return {};
    }
    const auto json = demuxer_->attachment(clip_tags::scene_file);
    if (!json) return refuse("has no scene.json attached: describe it with --scene FILE");
    auto scene = parse_scene(*json, file_ + ": scene.json");
    if (!scene) return scene.error();
    if (!clip_tags::same_rate(scene->rate, recorded_rate_))
        return refuse("its tag T3D_RATE is " + clip_tags::rate_text(recorded_rate_) +
                      ", but its scene.json says " + clip_tags::rate_text(scene->rate));
    scene_ = std::move(*scene);
    return {};
}

/// Opens the tracks of a file just opened and reads frame 0.
Result<void> MatroskaReader::start() {
    number_ = 0;
    first_.reset();
    if (auto opened = open_tracks(); !opened) return opened;
    auto frame = read();
    if (!frame) return frame.error();
    if (!*frame) return refuse("has no frames");
    first_ = std::move(**frame);
    return {};
}

Result<void> MatroskaReader::open_tracks() {
    const AVFormatContext& container = demuxer_->container();
    for (const PlaneRole role : all_roles) {
        for (unsigned k = 0; k < container.nb_streams; ++k) {
            const AVStream& stream = *container.streams[k];
            const AVDictionaryEntry* tag = av_dict_get(stream.metadata, clip_tags::role_tag, nullptr, 0);
            if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO || !tag) continue;
            const std::string number = "track " + std::to_string(k + 1);
            const auto tagged = role_named(tag->value);
            if (!tagged)
                return refuse(number + " has the role " + in_quotes(tag->value) +
                              ": must be depth, colour, haptic or height");
            if (*tagged != role) continue;
            if (!tracks_.empty() && tracks_.back().decoder.role() == role)
                return refuse(number + " is a second track of role " + tag->value + ": must be one");
            auto decoder = TrackDecoder::open(stream, role, file_);
            if (!decoder) return decoder.error();
            demuxer_->select(static_cast<int>(k));
            tracks_.push_back({static_cast<int>(k), std::move(*decoder)});
        }
        if (tracks_.empty()) return refuse("has no track of role depth (tag T3D_ROLE)");
    }
    return {};
}

/// What can be told of the whole clip once frame 0 is there.
Result<void> MatroskaReader::describe() {
    // Whoever completes a Matroska file writes its duration, so a file that ends sooner is not whole.
    const std::int64_t duration_us = demuxer_->container().duration;
    if (duration_us == AV_NOPTS_VALUE || duration_us <= 0)
        return refuse("was never completed: it has no duration");
    const double seconds = static_cast<double>(duration_us) / AV_TIME_BASE - origin_seconds_;
    promised_ = std::llround(seconds * static_cast<double>(recorded_rate_.num) /
                             static_cast<double>(recorded_rate_.den));
    bool has_haptic = false;
    for (const Track& track : tracks_) {
        const TrackInfo& info = infos_.emplace_back(track.decoder.info());
        const PlaneRole role = track.decoder.role();
        has_haptic = has_haptic || role == PlaneRole::haptic;
        if (info.width != scene_.width || info.height != scene_.height)
            notes_.push_back(resampling_note(role, info.width, info.height, scene_));
        if (auto note = lossy_note(role, info.codec)) notes_.push_back(std::move(*note));
    }
    if (auto note = no_depth_note(*first_, scene_.depth)) notes_.push_back(std::move(*note));
    if (auto note = default_touch_note(has_haptic, scene_)) notes_.push_back(std::move(*note));
    if (!scene_.far_from_frames) return {};

    FarPlaneSearch search(scene_.depth);
    while (true) {
        auto frame = next();
        if (!frame) return frame.error();
        if (!*frame) break;
        if (auto added = search.add((*frame)->depth); !added) return added;
    }
    auto note = search.settle(scene_);
    if (!note) return refuse(note.error().message);
    notes_.push_back(std::move(*note));
    return rewind();
}

Result<std::optional<RawFrame>> MatroskaReader::next() {
    if (first_) return std::exchange(first_, std::nullopt);
    return read();
}

Result<std::optional<RawFrame>> MatroskaReader::read() {
    RawFrame frame;
    frame.number = number_;
    frame.time_ns = scene_.rate.time_ns(number_);
    std::vector<std::string> present, ended;
    for (Track& track : tracks_) {
        const auto there = is_left_out(track) ? skip(track) : read_plane(track, frame);
        if (!there) return there.error();
        (*there ? present : ended).push_back(track.decoder.info().role);
    }
    if (!ended.empty()) {
        if (auto end = check_end(present, ended); !end) return end.error();
        return std::optional<RawFrame>{};
    }
    ++number_;
    return std::optional(std::move(frame));
}

/// The first frame tells what a track holds, so that has all planes.
bool MatroskaReader::is_left_out(const Track& track) const {
    return !with_colour_ && number_ > 0 && track.decoder.role() == PlaneRole::colour &&
           track.decoder.is_one_packet_each();
}

/// False after the last.
Result<bool> MatroskaReader::skip(Track& track) {
    const auto packet = demuxer_->next(track.stream);
    if (!packet) return packet.error();
    if (!packet->get()) return false;
    if (auto skipped = track.decoder.skip(**packet); !skipped) return skipped.error();
    if (auto timely = check_time(track, (*packet)->pts); !timely) return timely.error();
    return true;
}

/// Likewise.
Result<bool> MatroskaReader::read_plane(Track& track, RawFrame& frame) {
    auto decoded = picture(track);
    if (!decoded) return decoded.error();
    if (!*decoded) return false;
    if (auto timely = check_time(track, (*decoded)->timestamp); !timely) return timely.error();
    const PlaneRole role = track.decoder.role();
    const std::string where =
        file_ + ": track " + track.decoder.info().role + ", frame " + std::to_string(number_);
    auto plane = fit_plane(role, std::move((*decoded)->plane), scene_, where);
    if (!plane) return plane.error();
    add_plane(frame, role, std::move(*plane));
    return true;
}

Result<std::optional<TrackDecoder::Picture>> MatroskaReader::picture(Track& track) {
    while (true) {
        auto decoded = track.decoder.receive();
        if (!decoded || *decoded || track.decoder.drained()) return decoded;
        const auto packet = demuxer_->next(track.stream);
        if (!packet) return packet.error();
        if (auto sent = track.decoder.send(packet->get()); !sent) return sent.error();
    }
}

/// A lost or moved frame shows in the timestamps, which are the frame number's up to their rounding.
Result<void> MatroskaReader::check_time(const Track& track, std::int64_t timestamp) {
    const AVRational base = demuxer_->container().streams[track.stream]->time_base;
    const double seconds = static_cast<double>(timestamp) * base.num / base.den;
    if (number_ == 0 && track.decoder.role() == PlaneRole::depth) origin_seconds_ = seconds;
    const double expected = static_cast<double>(number_) * static_cast<double>(recorded_rate_.den) /
                            static_cast<double>(recorded_rate_.num);
    constexpr double rounding = 0.00101;  // of two timestamps, to milliseconds
    if (timestamp != AV_NOPTS_VALUE && std::fabs(seconds - origin_seconds_ - expected) < rounding) return {};
    return input_error(file_ + ": track " + track.decoder.info().role + ", frame " + std::to_string(number_) +
                       ": is missing, or not at its time: the picture found there is stamped " +
                       std::to_string(seconds - origin_seconds_) + " s instead of " +
                       std::to_string(expected) + " s");
}

Result<void> MatroskaReader::check_end(const std::vector<std::string>& present,
                                       const std::vector<std::string>& ended) const {
    const std::string where = "track " + ended.front() + ", frame " + std::to_string(number_);
    if (!present.empty()) return refuse(where + ": is missing, though track " + present.front() + " has it");
    if (number_ == 0 || number_ >= promised_) return {};
    return refuse(where + ": is where the clip ends, but it promises " + std::to_string(promised_) +
                  " frames: it is truncated or damaged");
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_matroska_clip(const std::filesystem::path& file,
                                                       const std::optional<Scene>& scene) {
    auto reader = std::make_unique<MatroskaReader>(file);
    if (auto opened = reader->open(scene); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
