// SPDX-License-Identifier: Apache-2.0
// The common part of our clips' writers, for any container; and files that appear together.
#include <fcntl.h>
#include <unistd.h>

#include <fstream>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"

namespace touchable {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr AVRational millisecond{1, 1000};

}  // namespace

Result<void> MuxedClipWriter::keep(Result<void> result) {
    over_ = over_ || !result;
    return result;
}

Result<void> MuxedClipWriter::check_status(int status) const {
    if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
    if (status >= 0) return {};
    return refuse("cannot be written: " + ffmpeg_text(status));
}

Result<void> MuxedClipWriter::open(const std::optional<SoundPart>& sound) {
    TRY(check_storable(output_.target(), described_));
    silence_ffmpeg();
    if (sound) TRY(assign(sound_, StoredSound::open(*sound)));
    TRY(output_.hold());
    AVFormatContext* muxer = nullptr;
    int status = avformat_alloc_output_context2(&muxer, nullptr, format_, nullptr);
    if (status < 0) return internal_error("muxer " + std::string(format_) + ": " + ffmpeg_text(status));
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    if (sound_ && avformat_query_codec(muxer_->oformat, sound_->codec().codec_id, FF_COMPLIANCE_NORMAL) != 1)
        return refuse(std::string("cannot hold sound of codec ") +
                      avcodec_get_name(sound_->codec().codec_id));
    status = room_.open(output_.path(), *muxer_);
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

Result<void> MuxedClipWriter::add_sound_stream() {
    if (!sound_) return {};
    sound_stream_ = static_cast<int>(muxer_->nb_streams);
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return refuse("out of memory");
    stream->codecpar->codec_tag = 0;  // it is the source container's
    stream->id = sound_stream_ + 1;
    stream->time_base = millisecond;
    return {};
}

Result<void> MuxedClipWriter::write_header(AVDictionary* options) {
    const int status = avformat_write_header(muxer_.get(), &options);
    av_dict_free(&options);
    return check_status(status);
}

Result<void> MuxedClipWriter::set_scene(const mpeg4::ClipNodes& nodes,
                                        std::map<std::uint16_t, std::uint32_t> objects) {
    const mpeg4::SceneTree tree = mpeg4::scene_of(nodes, scene_.width, scene_.height);
    mpeg4_scene_ = {mpeg4::config_for(tree, scene_.width, scene_.height), {}, std::move(objects)};
    return assign(mpeg4_scene_->scene, error_at(output_.target().string() + ": MPEG-4 has no such scene",
                                                mpeg4::encode_scene(tree, mpeg4_scene_->config)));
}

/// FFmpeg cannot write tracks of MPEG-4 Systems: they are added to its movie box, the file's last box.
Result<void> MuxedClipWriter::add_scene() {
    if (!mpeg4_scene_) return {};
    avio_flush(muxer_->pb);
    const std::string target = output_.target().string();
    TRY_ASSIGN(const auto file, error_at(target, bytes_of_file(SourceFile(output_.path()))));
    const auto end = static_cast<std::uint64_t>(avio_tell(muxer_->pb));
    TRY_ASSIGN(const auto box, error_at(target, mpeg4::first_box(*file, "moov", 0, end)));
    if (!box || box->end != end) return internal_error("the movie box is not the MP4 file's last");
    TRY_ASSIGN(const auto movie, error_at(target, mpeg4::bytes_at(*file, box->content, end - box->content)));
    TRY_ASSIGN(const auto made, mpeg4::with_scene_stream(movie, *mpeg4_scene_, 1, box->at));
    if (avio_seek(muxer_->pb, static_cast<std::int64_t>(box->at), SEEK_SET) < 0)
        return refuse("cannot be written: no way back in it");
    avio_write(muxer_->pb, made.data(), static_cast<int>(made.size()));
    avio_flush(muxer_->pb);
    return check_status(0);
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
        TRY(write_packet(*packet, sound_stream_, millisecond));
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

AVRational MuxedClipWriter::tick() const {
    if (scene_.rate.own_times) return {1, 1'000'000};
    return {static_cast<int>(scene_.rate.den), static_cast<int>(scene_.rate.num)};
}

std::int64_t MuxedClipWriter::tick_of(std::int64_t frame) const {
    return scene_.rate.own_times ? scene_.rate.time_ns(frame) / 1000 : frame;
}

Result<void> MuxedClipWriter::read_along(const TrackEncoder& colour, TrackCoding coding) {
    if (!storage_.gives_colour || coding != TrackCoding::h264_visual) return {};
    const Muxer container(avformat_alloc_context());
    AVStream* const stream = container ? avformat_new_stream(container.get(), nullptr) : nullptr;
    if (!stream) return memory_error();
    TRY(colour.describe(*stream->codecpar));
    return assign(along_, TrackDecoder::open(*stream, PlaneRole::colour, "what is written"));
}

/// The encoder has no delay, so each packet decodes to a picture at once.
Result<void> MuxedClipWriter::read_again(const AVPacket& colour) {
    if (!along_) return {};
    TRY(along_->send(&colour));
    TRY_ASSIGN(auto picture, along_->receive());
    if (!picture) return internal_error(along_->where() + ": is not decoded before the next one");
    colour_ = std::move(picture->plane);
    return {};
}

Result<void> MuxedClipWriter::write_frame(const RawFrame& frame) {
    if (over_) return internal_error("a frame is given to a clip that is finished, or has failed");
    TRY(check_.check(frame, scene_));
    return add(frame);
}

Result<void> MuxedClipWriter::end() {
    if (over_) return internal_error("the clip is finished already, or has failed");
    if (check_.frames() == 0) return refuse("not written: no frame was given");
    TRY(add_rest());
    TRY(write_sound(time_ms(check_.frames())));
    TRY(check_status(av_write_trailer(muxer_.get())));
    TRY(add_scene());
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
    if (!complete_) TRY(keep(end()));
    return output_.commit();
}

Result<void> check_storable(const std::filesystem::path& path, const SceneDescription& described) {
    const FrameRate& rate = described.scene.rate;
    TRY(error_at(path.string(), validate(described)));
    if (described.unstated.far)
        return input_error(path.string() + ": not written: the scene's depth.far is not known yet");
    if (!clip_tags::is_too_fast(rate)) return {};
    return input_error(path.string() + ": not written: the scene's rate is " + clip_tags::rate_text(rate) +
                       " frames/s; a clip has at most " + std::to_string(clip_tags::fastest_rate));
}

bool is_mp4_name(const fs::path& path) {
    return small_letters(path.extension().string()) == ".mp4";
}

Result<std::unique_ptr<ClipWriter>> create_clip(const fs::path& path, const SceneDescription& described,
                                                const ClipStorage& storage, Existing existing,
                                                const std::optional<SoundPart>& sound) {
    const bool is_mp4 = is_mp4_name(path);
    if (storage.fragmented && !is_mp4)
        return usage_error(path.string() +
                           ": only MP4 is written in fragments: must be a name that ends in .mp4");
    return opened_as<ClipWriter>((is_mp4 ? mp4_writer : matroska_writer)(path, described, storage, existing),
                                 sound);
}

HiddenFolder::HiddenFolder(const fs::path& beside) : path_(hidden_name(beside)) {
    if (fs::create_directory(path_, failure_))
        opened_ = Descriptor(open(path_.c_str(), O_RDONLY | O_CLOEXEC));
}

HiddenFolder::~HiddenFolder() {
    remove();
}

Result<void> HiddenFolder::write(const fs::path& home, const std::string& name,
                                 const std::string& bytes) const {
    std::ofstream out(path_ / name, std::ios::binary);
    out << bytes;
    out.close();
    return out ? Result<void>{} : input_error((home / name).string() + ": cannot be written");
}

Result<void> HiddenFolder::sync(const fs::path& place) const {
    // All at once is a hundred times as fast, but fails by what other programs lost, too.
    if (syncfs(opened_.get()) == 0) return {};
    int why = 0;
    std::error_code failure;
    for (fs::directory_iterator each(path_, failure), end; why == 0 && !failure && each != end;
         each.increment(failure)) {
        if (stop_requested()) return interrupted_error();
        why = sync_path(each->path());
    }
    if (why == 0) why = failure ? failure.value() : sync_path(path_);
    if (why == 0) return {};
    return input_error(place.string() + ": cannot be written: " + std::generic_category().message(why));
}

void HiddenFolder::remove() const {
    std::error_code ignored;
    if (!failure_) fs::remove_all(path_, ignored);
}

Result<void> HiddenFolder::move_to(const fs::path& home, const std::vector<std::string>& names,
                                   Existing existing) const {
    for (auto name = names.begin(); name != names.end(); ++name) {
        const fs::path from = path_ / *name, to = home / *name;
        std::error_code failure;
        if (existing == Existing::replace)
            fs::rename(from, to, failure);
        else
            failure.assign(move_to_free_name(from, to), std::generic_category());
        if (!failure) continue;
        if (existing == Existing::keep)  // remove what was moved
            for (auto done = names.begin(); done != name; ++done) {
                std::error_code ignored;
                fs::remove(home / *done, ignored);
            }
        return input_error(to.string() + ": cannot be written: " + failure.message());
    }
    return sync_names(home, home / names.back());
}

}  // namespace touchable
