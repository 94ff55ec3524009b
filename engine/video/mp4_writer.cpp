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

/// Content, and where in the file the box begins.
struct MovieBox {
    std::uint64_t at = 0;
    mpeg4::Bytes content;
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
    Result<void> make_scene_stream();
    Result<MovieBox> movie_box() const;
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
    mpeg4::SceneStream scene_stream_;
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
    const TrackCoding coding = is_seen                             ? TrackCoding::h264_visual
                               : storage_.archive == Archive::fast ? TrackCoding::h264_quick
                                                                   : TrackCoding::h264_thrifty;
    auto encoder = TrackEncoder::open(track.role, coding, part_of(first, track), scene_);
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
            const int bits =
                role == PlaneRole::depth ? scene_.depth_bits : std::max(8, height_bits(scene_.height_coding));
            Mp4Track track{role, is_wide ? part : Part::whole, is_wide ? bits - 8 : 0};
            if (auto opened = open_track(std::move(track), plane); !opened) return opened;
        }
    }
    if (auto made = make_scene_stream(); !made) return made;
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
    const int wanted = scene_.rate.own_times ? 4 : 3;
    return av_dict_count(tags) < wanted ? refuse("out of memory") : Result<void>{};
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
Result<void> Mp4Writer::make_scene_stream() {
    const auto has = [&](PlaneRole role) { return check_.bytes_per_sample(role) > 0; };
    const mpeg4::ClipNodes nodes =
        mpeg4::nodes_from(scene_, {has(PlaneRole::colour), has(PlaneRole::haptic), has(PlaneRole::height)});
    mpeg4::SceneStream& stream = scene_stream_;
    for (std::size_t k = 0; k < tracks_.size(); ++k)
        if (tracks_[k].part != Part::low)
            stream.objects[object_of(tracks_[k].role)] = static_cast<std::uint32_t>(k + 1);
    const mpeg4::SceneTree tree = mpeg4::scene_of(nodes, scene_.width, scene_.height);
    stream.config = mpeg4::config_for(tree, scene_.width, scene_.height);
    auto bytes = mpeg4::encode_scene(tree, stream.config);
    if (!bytes) return refuse("MPEG-4 has no such scene: " + bytes.error().message);
    stream.scene = std::move(*bytes);
    return {};
}

/// As FFmpeg has written it, the file's last box.
Result<MovieBox> Mp4Writer::movie_box() const {
    std::ifstream file(output_.path(), std::ios::binary | std::ios::ate);
    const auto read = [&file](std::uint64_t from, std::uint64_t count) {
        mpeg4::Bytes bytes(count);
        file.seekg(static_cast<std::streamoff>(from));
        file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
        return bytes;
    };
    const auto end = static_cast<std::uint64_t>(avio_tell(muxer_->pb));
    constexpr std::uint64_t head_bytes = 16;
    for (std::uint64_t at = 0; at + head_bytes <= end;) {
        const mpeg4::Bytes head = read(at, head_bytes);
        const std::uint64_t stated = mpeg4::number_at(head, 0, 4),
                            size = stated == 1 ? mpeg4::number_at(head, 8, 8) : stated;
        if (!file || size < 8 || size > end - at) break;
        if (std::memcmp(head.data() + 4, "moov", 4) != 0) {
            at += size;
            continue;
        }
        if (at + size != end) break;
        mpeg4::Bytes content = read(at + 8, size - 8);
        if (!file) break;
        return MovieBox{at, std::move(content)};
    }
    return file ? Error{ErrorKind::internal, "the movie box is not the MP4 file's last"}
                : refuse("cannot be written: what is there already cannot be read");
}

/// FFmpeg cannot write tracks of MPEG-4 Systems: they are added to its movie box, which is the last.
Result<void> Mp4Writer::add_scene() {
    avio_flush(muxer_->pb);
    const auto movie = movie_box();
    if (!movie) return movie.error();
    const auto made = mpeg4::with_scene_stream(movie->content, scene_stream_, 1, movie->at);
    if (!made) return made.error();
    if (avio_seek(muxer_->pb, static_cast<std::int64_t>(movie->at), SEEK_SET) < 0)
        return refuse("cannot be written: no way back in it");
    avio_write(muxer_->pb, made->data(), static_cast<int>(made->size()));
    avio_flush(muxer_->pb);
    return check_status(0);
}

Result<void> Mp4Writer::end() {
    if (over_) return Error{ErrorKind::internal, "the clip is finished already, or has failed"};
    if (check_.frames() == 0) return refuse("not written: no frame was given");
    constexpr std::int64_t ns_per_ms = 1'000'000;
    if (auto written = write_sound(scene_.rate.time_ns(check_.frames()) / ns_per_ms); !written)
        return written;
    if (auto written = check_status(av_write_trailer(muxer_.get())); !written) return written;
    if (auto added = add_scene(); !added) return added;
    const int status = room_.close();
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    over_ = complete_ = true;
    return {};
}

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_mp4_clip(const std::filesystem::path& path,
                                                    const SceneDescription& described,
                                                    const ClipStorage& storage, Existing existing,
                                                    const std::optional<SoundPart>& sound) {
    silence_ffmpeg();
    if (auto storable = check_storable(path, described); !storable) return storable.error();
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
