#include "engine/video/mp4_writer.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/frame_check.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/ffmpeg/reserved_output.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/mpeg4/scene_stream.hpp"
#include "engine/new_file.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/sound/stored_sound.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/frame_times_text.hpp"
#include "engine/video/track_decoder.hpp"
#include "engine/video/track_encoder.hpp"

namespace touchable {
namespace {

/// Ordinary players show the first track.
constexpr PlaneRole track_order[] = {PlaneRole::colour, PlaneRole::depth, PlaneRole::haptic,
                                     PlaneRole::height};

std::uint16_t object_of(PlaneRole role) {
    switch (role) {
        case PlaneRole::colour:
            return mpeg4::colour_object;
        case PlaneRole::haptic:
            return mpeg4::haptic_object;
        case PlaneRole::height:
            return mpeg4::height_object;
        case PlaneRole::depth:
            break;
    }
    return mpeg4::depth_object;
}

/// Eight bits of each sample of a plane.
enum class Part { whole, high, low };

struct Mp4Track {
    PlaneRole role;
    Part part = Part::whole;
    int low_bits = 0;  // of a sample that is in two parts
    std::unique_ptr<TrackEncoder> encoder{};
    TrackCoding coding = TrackCoding::h264_quick;
    std::vector<std::uint8_t> bytes{};  // of the newest picture of a part
    std::string name() const {
        return std::string(role_name(role)) + (part == Part::low ? low_track_suffix : "");
    }
};

PlaneView part_of(const PlaneView& plane, Mp4Track& track) {
    if (track.part == Part::whole) return plane;
    const auto width = static_cast<std::size_t>(plane.width);
    track.bytes.resize(width * static_cast<std::size_t>(plane.height));
    const unsigned low = (1U << track.low_bits) - 1;
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* to = track.bytes.data() + width * static_cast<std::size_t>(y);
        for (std::size_t x = 0; x < width; ++x) {
            std::uint16_t sample;
            std::memcpy(&sample, from + 2 * x, 2);
            to[x] =
                static_cast<std::uint8_t>(track.part == Part::high ? sample >> track.low_bits : sample & low);
        }
    }
    return {track.bytes.data(), plane.width, plane.width, plane.height, 1, 1};
}

struct ContainerCloser {
    void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
};

class Mp4Writer final : public ClipWriter {
public:
    Mp4Writer(const std::filesystem::path& path, const SceneDescription& described,
              const ClipStorage& storage, Existing existing, std::unique_ptr<StoredSound> sound)
        : scene_(described.scene),
          unstated_(described.unstated),
          storage_(storage),
          output_(path, existing),
          sound_(std::move(sound)) {}
    Result<void> open();
    Result<void> write(const RawFrame& frame) override { return keep(write_frame(frame)); }
    PlaneView stored_colour() const override { return as_read_.view; }
    bool is_full() const override { return room_.is_full(); }
    Result<std::filesystem::path> complete() override {
        if (auto ended = keep(end()); !ended) return ended.error();
        return output_.path();
    }
    Result<void> finish() override {
        if (!complete_)
            if (auto ended = keep(end()); !ended) return ended;
        return output_.commit();
    }

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    Result<void> keep(Result<void> result) {  // what went wrong once is not written over
        over_ = over_ || !result.ok();
        return result;
    }
    Result<void> check_status(int status) const;
    Result<void> write_frame(const RawFrame& frame);
    Result<void> open_tracks(const RawFrame& first);
    Result<void> open_track(Mp4Track track, const PlaneView& first);
    Result<void> begin_file();
    Result<void> add_tags();
    Result<void> write_picture(std::size_t track, const PlaneView& plane);
    Result<void> read_along(const AVPacket& packet);
    Result<void> write_sound(std::int64_t until_ms);
    Result<void> add_scene();
    Result<mpeg4::SceneStream> scene_stream() const;
    Result<void> end();
    /// Exact where frames come evenly: a rate of 30000/1001 has ticks of 1/30000 s.
    AVRational time_base() const {
        if (scene_.rate.own_times) return {1, 1'000'000};
        return {static_cast<int>(scene_.rate.den), static_cast<int>(scene_.rate.num)};
    }
    std::int64_t tick_of(std::int64_t frame) const {
        return scene_.rate.own_times ? scene_.rate.time_ns(frame) / 1000 : frame;
    }

    Scene scene_;
    Unstated unstated_;
    ClipStorage storage_;
    NewFile output_;
    std::unique_ptr<StoredSound> sound_;  // null: none
    ReservedOutput room_;
    std::unique_ptr<AVFormatContext, ContainerCloser> muxer_;
    std::vector<Mp4Track> tracks_;  // track k is stream k, and has number k + 1
    FrameCheck check_;
    std::unique_ptr<TrackDecoder> reader_;  // of colour as stored; null: nobody asked
    Plane as_read_;
    bool over_ = false;  // complete, or failed
    bool complete_ = false;
};

Result<void> Mp4Writer::check_status(int status) const {
    if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
    if (status >= 0) return {};
    return refuse("cannot be written: " + ffmpeg_text(status));
}

Result<void> Mp4Writer::open() {
    if (auto usable = output_.check(); !usable) return usable;
    AVFormatContext* muxer = nullptr;
    int status = avformat_alloc_output_context2(&muxer, nullptr, "mp4", nullptr);
    if (status < 0) return Error{ErrorKind::internal, "MP4 muxer: " + ffmpeg_text(status)};
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;
    if (sound_ && avformat_query_codec(muxer_->oformat, sound_->codec().codec_id, FF_COMPLIANCE_NORMAL) != 1)
        return refuse(std::string("cannot hold sound of codec ") +
                      avcodec_get_name(sound_->codec().codec_id));
    status = room_.open(output_.path(), *muxer_);
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

Result<void> Mp4Writer::open_track(Mp4Track track, const PlaneView& first) {
    const bool is_seen = track.role == PlaneRole::colour && !storage_.exact_colour;
    track.coding = is_seen                             ? TrackCoding::h264_visual
                   : storage_.archive == Archive::fast ? TrackCoding::h264_quick
                                                       : TrackCoding::h264_thrifty;
    auto encoder = TrackEncoder::open(track.role, track.coding, part_of(first, track), scene_);
    if (!encoder) return encoder.error();
    track.encoder = std::move(*encoder);
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream) return refuse("out of memory");
    if (auto described = track.encoder->describe(*stream->codecpar); !described) return described;
    stream->id = static_cast<int>(tracks_.size()) + 1;
    stream->time_base = time_base();
    stream->avg_frame_rate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
    av_dict_set(&stream->metadata, "handler_name", track.name().c_str(), 0);
    stream->disposition = tracks_.empty() ? AV_DISPOSITION_DEFAULT : 0;
    if (is_seen && storage_.gives_colour) {
        auto reader = TrackDecoder::open(*stream, track.role, "what is written");
        if (!reader) return reader.error();
        reader_ = std::make_unique<TrackDecoder>(std::move(*reader));
    }
    tracks_.push_back(std::move(track));
    return {};
}

/// Those with the low bits come last: the scene does not know them.
Result<void> Mp4Writer::open_tracks(const RawFrame& first) {
    for (const Part part : {Part::high, Part::low}) {
        for (const PlaneRole role : track_order) {
            const PlaneView& plane = plane_of(first, role);
            const bool is_wide = plane.bytes_per_sample == 2;
            if (plane.empty() || (part == Part::low && !is_wide)) continue;
            const int bits = role == PlaneRole::depth ? scene_.depth_bits : 16;
            Mp4Track track{role, is_wide ? part : Part::whole, is_wide ? bits - 8 : 0};
            if (auto opened = open_track(std::move(track), plane); !opened) return opened;
        }
    }
    return begin_file();
}

Result<void> Mp4Writer::begin_file() {
    if (sound_) {
        AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
            return refuse("out of memory");
        stream->codecpar->codec_tag = 0;  // the other container's
        stream->id = static_cast<int>(tracks_.size()) + 1;
        stream->time_base = {1, 1000};
    }
    if (auto tagged = add_tags(); !tagged) return tagged;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", "use_metadata_tags", 0);
    const int status = avformat_write_header(muxer_.get(), &options);
    av_dict_free(&options);
    return check_status(status);
}

Result<void> Mp4Writer::add_tags() {
    SceneDescription described(scene_);
    described.unstated = unstated_;
    described.scene.folder.reset();  // the frames are here now
    described.scene.video.reset();
    described.scene.stored = {};  // as codes
    AVDictionary*& tags = muxer_->metadata;
    av_dict_set_int(&tags, clip_tags::version_tag, clip_format_version, 0);
    av_dict_set(&tags, clip_tags::rate_tag, clip_tags::rate_text(scene_.rate).c_str(), 0);
    av_dict_set(&tags, mp4_scene_tag, scene_to_json(described).c_str(), 0);
    if (scene_.rate.own_times) av_dict_set(&tags, mp4_times_tag, frame_times_text(scene_.rate).c_str(), 0);
    std::string lossless;
    for (const Mp4Track& track : tracks_)
        if (track.part != Part::low && track.coding != TrackCoding::h264_visual)
            lossless += (lossless.empty() ? "" : " ") + track.name();
    return av_dict_set(&tags, mp4_lossless_tag, lossless.c_str(), 0) < 0 ? refuse("out of memory")
                                                                         : Result<void>{};
}

Result<void> Mp4Writer::write_picture(std::size_t track, const PlaneView& plane) {
    const std::int64_t frame = check_.frames() - 1;
    auto packet = tracks_[track].encoder->encode(plane, frame % clip_tags::access_interval == 0);
    if (!packet) return packet.error();
    if (reader_ && tracks_[track].role == PlaneRole::colour)
        if (auto read = read_along(**packet); !read) return read;
    (*packet)->stream_index = static_cast<int>(track);
    (*packet)->pts = (*packet)->dts = tick_of(frame);
    (*packet)->duration = tick_of(frame + 1) - tick_of(frame);
    av_packet_rescale_ts(packet->get(), time_base(), muxer_->streams[track]->time_base);
    auto written = check_status(av_write_frame(muxer_.get(), packet->get()));
    room_.end_picture();
    return written;
}

/// The encoder holds no picture back, so none waits for a later one.
Result<void> Mp4Writer::read_along(const AVPacket& packet) {
    if (auto sent = reader_->send(&packet); !sent) return sent;
    auto picture = reader_->receive();
    if (!picture) return picture.error();
    if (!*picture)
        return Error{ErrorKind::internal, reader_->where() + ": is not decoded before the next one"};
    as_read_ = std::move((*picture)->plane);
    return {};
}

/// What is heard up to then.
Result<void> Mp4Writer::write_sound(std::int64_t until_ms) {
    if (!sound_) return {};
    const auto stream = static_cast<int>(tracks_.size());
    while (true) {
        const auto packet = sound_->next(until_ms);
        if (!packet) return packet.error();
        if (!*packet) return {};
        (*packet)->stream_index = stream;
        av_packet_rescale_ts(packet->get(), {1, 1000}, muxer_->streams[stream]->time_base);
        if (auto written = check_status(av_write_frame(muxer_.get(), packet->get())); !written)
            return written;
    }
}

Result<void> Mp4Writer::write_frame(const RawFrame& frame) {
    if (over_)
        return Error{ErrorKind::internal, "a frame is given to a clip that is finished, or has failed"};
    if (auto fits = check_.check(frame, scene_); !fits) return fits;
    if (tracks_.empty())
        if (auto opened = open_tracks(frame); !opened) return opened;
    constexpr std::int64_t ns_per_ms = 1'000'000;
    if (auto written = write_sound(scene_.rate.time_ns(frame.number) / ns_per_ms); !written) return written;
    for (std::size_t k = 0; k < tracks_.size(); ++k)
        if (auto written = write_picture(k, part_of(plane_of(frame, tracks_[k].role), tracks_[k])); !written)
            return written;
    return {};
}

/// Each plane's texture is a track.
Result<mpeg4::SceneStream> Mp4Writer::scene_stream() const {
    const auto has = [&](PlaneRole role) { return check_.bytes_per_sample(role) > 0; };
    const mpeg4::ClipNodes nodes =
        mpeg4::nodes_from(scene_, {has(PlaneRole::colour), has(PlaneRole::haptic), has(PlaneRole::height)});
    mpeg4::SceneStream stream;
    for (std::size_t k = 0; k < tracks_.size(); ++k)
        if (tracks_[k].part != Part::low)
            stream.objects[object_of(tracks_[k].role)] = static_cast<std::uint32_t>(k + 1);
    const mpeg4::SceneTree tree = mpeg4::scene_of(nodes, scene_.width, scene_.height);
    stream.config = mpeg4::config_for(tree, scene_.width, scene_.height);
    auto bytes = mpeg4::encode_scene(tree, stream.config);
    if (!bytes) return bytes.error();
    stream.scene = std::move(*bytes);
    return stream;
}

/// FFmpeg cannot write tracks of MPEG-4 Systems: they are added to its movie box, which is the last.
Result<void> Mp4Writer::add_scene() {
    std::fstream file(output_.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(0, std::ios::end);
    const auto size = static_cast<std::uint64_t>(file.tellg());
    std::uint64_t at = 0;
    mpeg4::Bytes head(16);
    std::uint64_t length = 0;
    for (; at + 8 <= size; at += length) {
        file.seekg(static_cast<std::streamoff>(at));
        file.read(reinterpret_cast<char*>(head.data()),
                  static_cast<std::streamsize>(std::min<std::uint64_t>(16, size - at)));
        length = mpeg4::number_at(head, 0, 4);
        if (length == 1) length = mpeg4::number_at(head, 8, 8);
        const bool is_movie = std::memcmp(head.data() + 4, "moov", 4) == 0;
        if (!file || length < 8 || is_movie) break;
    }
    if (!file || at + length != size)
        return Error{ErrorKind::internal, "the movie box is not the MP4 file's last"};
    mpeg4::Bytes movie(length - 8);
    file.seekg(static_cast<std::streamoff>(at + 8));
    file.read(reinterpret_cast<char*>(movie.data()), static_cast<std::streamsize>(movie.size()));
    const auto stream = scene_stream();
    if (!stream) return stream.error();
    const auto made = mpeg4::with_scene_stream(movie, *stream, 1, at);
    if (!made) return made.error();
    file.seekp(static_cast<std::streamoff>(at));
    file.write(reinterpret_cast<const char*>(made->data()), static_cast<std::streamsize>(made->size()));
    file.close();
    return file ? Result<void>{} : refuse("cannot be written: no space is left, or the disk fails");
}

Result<void> Mp4Writer::end() {
    if (over_) return Error{ErrorKind::internal, "the clip is finished already, or has failed"};
    if (check_.frames() == 0) return refuse("not written: no frame was given");
    constexpr std::int64_t ns_per_ms = 1'000'000;
    if (auto written = write_sound(scene_.rate.time_ns(check_.frames()) / ns_per_ms); !written)
        return written;
    if (auto written = check_status(av_write_trailer(muxer_.get())); !written) return written;
    const int status = room_.close();
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    if (auto added = add_scene(); !added) return added;
    over_ = complete_ = true;
    return {};
}

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_mp4_clip(const std::filesystem::path& path,
                                                    const SceneDescription& described,
                                                    const ClipStorage& storage, Existing existing,
                                                    const std::optional<SoundPart>& sound) {
    silence_ffmpeg();
    if (auto valid = validate(described); !valid)
        return input_error(path.string() + ": " + valid.error().message);
    if (described.unstated.far)
        return input_error(path.string() + ": not written: the scene's depth.far is not known yet");
    std::unique_ptr<StoredSound> heard;
    if (sound) {
        auto opened = StoredSound::open(*sound);
        if (!opened) return opened.error();
        heard = std::move(*opened);
    }
    auto writer = std::make_unique<Mp4Writer>(path, described, storage, existing, std::move(heard));
    if (auto opened = writer->open(); !opened) return opened.error();
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

bool is_mp4_name(const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return ending == ".mp4";
}

Result<std::unique_ptr<ClipWriter>> create_named_clip(const std::filesystem::path& path,
                                                      const SceneDescription& described,
                                                      const ClipStorage& storage, Existing existing,
                                                      const std::optional<SoundPart>& sound) {
    return (is_mp4_name(path) ? create_mp4_clip : create_clip)(path, described, storage, existing, sound);
}

}  // namespace touchable
