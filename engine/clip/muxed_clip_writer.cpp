#include "engine/clip/muxed_clip_writer.hpp"

#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_muxing.hpp"

namespace touchable {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr AVRational millisecond{1, 1000};

}  // namespace

MuxedClipWriter::MuxedClipWriter(const std::filesystem::path& path, const SceneDescription& described,
                                 const ClipStorage& storage, Existing existing, const char* format)
    : scene_(described.scene),
      unstated_(described.unstated),
      storage_(storage),
      output_(path, existing),
      format_(format) {}

Error MuxedClipWriter::refuse(const std::string& what) const {
    return input_error(output_.target().string() + ": " + what);
}

Result<void> MuxedClipWriter::keep(Result<void> result) {
    over_ = over_ || !result.ok();
    return result;
}

Result<void> MuxedClipWriter::check_status(int status) const {
    if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
    if (status >= 0) return {};
    return refuse("cannot be written: " + ffmpeg_text(status));
}

Result<void> MuxedClipWriter::open(const std::optional<SoundPart>& sound) {
    silence_ffmpeg();
    if (sound) {
        TRY_ASSIGN(auto opened, StoredSound::open(*sound));
        sound_ = std::move(opened);
    }
    if (auto usable = output_.check(); !usable) return usable;
    AVFormatContext* muxer = nullptr;
    int status = avformat_alloc_output_context2(&muxer, nullptr, format_, nullptr);
    if (status < 0)
        return Error{ErrorKind::internal, "muxer " + std::string(format_) + ": " + ffmpeg_text(status)};
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    if (sound_ && avformat_query_codec(muxer_->oformat, sound_->codec().codec_id, FF_COMPLIANCE_NORMAL) != 1)
        return refuse(std::string("cannot hold sound of codec ") +
                      avcodec_get_name(sound_->codec().codec_id));
    status = room_.open(output_.path(), *muxer_);
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

SceneDescription MuxedClipWriter::to_be_said() const {
    SceneDescription described(scene_);
    described.unstated = unstated_;
    return said_of_clip(described);
}

void MuxedClipWriter::add_tags(int version) {
    add_clip_tags(*muxer_, scene_.rate, version);
}

Result<void> MuxedClipWriter::add_sound_stream() {
    if (!sound_) return {};
    sound_stream_ = static_cast<int>(muxer_->nb_streams);
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return refuse("out of memory");
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->id = sound_stream_ + 1;
    stream->time_base = millisecond;
    return {};
}

Result<void> MuxedClipWriter::write_header(AVDictionary* options) {
    const int status = avformat_write_header(muxer_.get(), &options);
    av_dict_free(&options);
    return check_status(status);
}

Result<void> MuxedClipWriter::write_packet(AVPacket& packet, int stream, AVRational tick) {
    packet.stream_index = stream;
    av_packet_rescale_ts(&packet, tick, muxer_->streams[stream]->time_base);
    return check_status(av_write_frame(muxer_.get(), &packet));
}

Result<void> MuxedClipWriter::write_sound(std::int64_t until_ms) {
    while (sound_) {
        TRY_ASSIGN(const auto packet, sound_->next(until_ms));
        if (!packet) return {};
        if (auto written = write_packet(*packet, sound_stream_, millisecond); !written) return written;
    }
    return {};
}

Result<void> MuxedClipWriter::write_picture(AVPacket& packet, std::size_t stream, AVRational tick) {
    auto written = write_packet(packet, static_cast<int>(stream), tick);
    room_.end_picture();
    return written;
}

std::int64_t MuxedClipWriter::time_ms(std::int64_t frame) const {
    return (scene_.rate.time_ns(frame) + ns_per_ms / 2) / ns_per_ms;
}

Result<void> MuxedClipWriter::write_frame(const RawFrame& frame) {
    if (over_)
        return Error{ErrorKind::internal, "a frame is given to a clip that is finished, or has failed"};
    if (auto fits = check_.check(frame, scene_); !fits) return fits;
    return add(frame);
}

Result<void> MuxedClipWriter::end() {
    if (over_) return Error{ErrorKind::internal, "the clip is finished already, or has failed"};
    if (check_.frames() == 0) return refuse("not written: no frame was given");
    if (auto written = add_rest(); !written) return written;
    if (auto written = write_sound(time_ms(check_.frames())); !written) return written;
    if (auto written = check_status(av_write_trailer(muxer_.get())); !written) return written;
    if (auto amended = amend(); !amended) return amended;
    const int status = room_.close();
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    over_ = complete_ = true;
    return {};
}

Result<std::filesystem::path> MuxedClipWriter::complete() {
    TRY(keep(end()));
    return output_.path();
}

Result<void> MuxedClipWriter::finish() {
    if (!complete_)
        if (auto ended = keep(end()); !ended) return ended;
    return output_.commit();
}

}  // namespace touchable
