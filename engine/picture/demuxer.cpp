// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"

namespace touchable {
namespace {

constexpr std::string_view hevc = "hvc1";

/// Bytes of a file with `hvc1` in place of each of these names.
class ShownAsHevc final : public ByteSource {
public:
    ShownAsHevc(std::unique_ptr<ByteSource> bytes, std::vector<std::uint64_t> names_at)
        : bytes_(std::move(bytes)), names_at_(std::move(names_at)) {}
    std::uint64_t size() const override { return bytes_->size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        TRY(bytes_->read(at, to, count));
        for (const std::uint64_t name : names_at_)
            for (std::size_t k = 0; k < hevc.size(); ++k)
                if (name + k >= at && name + k < at + count) to[name + k - at] = hevc[k];
        return {};
    }

private:
    std::unique_ptr<ByteSource> bytes_;
    std::vector<std::uint64_t> names_at_;
};

/// Frames by which a stream may run ahead of another, and bytes of all packets that wait.
constexpr std::size_t queue_limit = 64, queued_bytes_limit = std::size_t{1} << 30;

std::optional<std::string> entry(const AVDictionary* dictionary, const char* name) {
    const AVDictionaryEntry* found = av_dict_get(dictionary, name, nullptr, 0);
    if (!found) return std::nullopt;
    return found->value;
}

}  // namespace

Error never_completed(const std::string& file) {
    return input_error(file + ": was never completed: its writer stopped before the end");
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_matroska(const SourceFile& file, bool may_be_stream) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    TRY_ASSIGN(const auto end, check_matroska(*bytes, file.string()));
    if (!end.is_stated && !may_be_stream) return never_completed(file.string());
    auto demuxer = open(std::move(bytes), end.at, file.string(), "matroska", "Matroska");
    if (!demuxer) return demuxer;
    (*demuxer)->is_open_ended_ = !end.is_stated;
    (*demuxer)->is_cut_ = end.is_cut;
    return demuxer;
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_quicktime(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    return open_quicktime(std::move(bytes), file.string());
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_quicktime(std::unique_ptr<ByteSource> bytes,
                                                         const std::string& file) {
    TRY_ASSIGN(const auto end, error_at(file, end_of_boxes(*bytes)));
    if (!end) return input_error(file + ": is truncated, or no QuickTime or MP4 file");
    TRY_ASSIGN(auto disparity, error_at(file, checked_boxes(*bytes, *end)));
    if (!disparity.ids.empty())
        bytes = std::make_unique<ShownAsHevc>(std::move(bytes), std::move(disparity.names_at));
    auto demuxer = open(std::move(bytes), *end, file, "mov", "QuickTime or MP4");
    if (demuxer) (*demuxer)->disparities_ = std::move(disparity.ids);
    return demuxer;
}

bool Demuxer::is_disparity(int stream) const {
    return std::ranges::find(disparities_, container_->streams[stream]->id) != disparities_.end();
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_video(const SourceFile& file) {
    const std::string begin = first_bytes(file, 4);
    if (begin == "\x1a\x45\xdf\xa3") return open_matroska(file);
    if (begin != "RIFF") return open_quicktime(file);
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    TRY_ASSIGN(const auto end, error_at(file.string(), end_of_riff(*bytes)));
    if (!end) return input_error(file.string() + ": is truncated, or no AVI file");
    return open(std::move(bytes), *end, file.string(), "avi", "AVI");
}

Result<std::unique_ptr<Demuxer>> Demuxer::open(std::unique_ptr<ByteSource> bytes, std::uint64_t end,
                                               const std::string& file, const char* format,
                                               const std::string& name) {
    auto container = open_input(std::move(bytes), end, file,
                                {.format = format, .error_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE});
    if (!container && container.error().kind == ErrorKind::input)
        return error_at(file + ": is not a readable " + name + " file", container.error());
    if (!container) return error_at(file, container.error());
    return std::make_unique<Demuxer>(file, std::move(*container));
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_live(std::shared_ptr<ByteFlow> flow, const std::string& file,
                                                    const char* format) {
    TRY_ASSIGN(auto container,
               error_at(file, open_flow(std::move(flow),
                                        {.format = format, .most_streams = 16, .probed = 1 << 15})));
    return std::make_unique<Demuxer>(file, std::move(container));
}

std::optional<std::string> Demuxer::tag(const char* name) const {
    return entry(container_->metadata, name);
}

std::vector<std::pair<const AVStream*, std::string>> Demuxer::tagged_pictures(const char* name) const {
    std::vector<std::pair<const AVStream*, std::string>> found;
    for (const AVStream* const stream : std::span(container_->streams, container_->nb_streams))
        if (auto value = entry(stream->metadata, name);
            value && stream->codecpar->codec_type == AVMEDIA_TYPE_VIDEO)
            found.emplace_back(stream, std::move(*value));
    return found;
}

std::optional<double> Demuxer::pictures_end() const {
    bool has_sound = false;
    double pictures_s = 0;
    for (unsigned k = 0; k < container_->nb_streams; ++k) {
        const AVStream& stream = *container_->streams[k];
        has_sound = has_sound || stream.codecpar->codec_type == AVMEDIA_TYPE_AUDIO;
        if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO) continue;
        // Matroska's form: 00:00:03.007000000.
        int hours = 0, minutes = 0;
        double seconds = 0;
        const std::string stated = entry(stream.metadata, "DURATION").value_or("");
        if (std::sscanf(stated.c_str(), "%d:%d:%lf", &hours, &minutes, &seconds) != 3) {
            if (stream.duration <= 0) continue;  // nor has it MP4's duration
            hours = minutes = 0;
            seconds = static_cast<double>(stream.duration) * av_q2d(stream.time_base);
        }
        pictures_s = std::max(pictures_s, 3600.0 * hours + 60.0 * minutes + seconds);
    }
    // FFmpeg 7 leaves an MP4's own duration open; its tracks have theirs.
    const std::int64_t whole_us = container_->duration;
    if (whole_us == AV_NOPTS_VALUE || whole_us <= 0)
        return pictures_s > 0 ? std::optional(pictures_s) : std::nullopt;
    const double whole_s = static_cast<double>(whole_us) / AV_TIME_BASE;
    return has_sound && pictures_s > 0 && pictures_s < whole_s ? pictures_s : whole_s;
}

std::optional<std::string> Demuxer::attachment(const std::string& file_name) const {
    for (unsigned k = 0; k < container_->nb_streams; ++k) {
        const AVStream& stream = *container_->streams[k];
        if (stream.codecpar->codec_type != AVMEDIA_TYPE_ATTACHMENT) continue;
        if (entry(stream.metadata, "filename") != file_name) continue;
        return std::string(reinterpret_cast<const char*>(stream.codecpar->extradata),
                           static_cast<std::size_t>(stream.codecpar->extradata_size));
    }
    return std::nullopt;
}

/// Null at the end; `failed` follows the file's name in an error.
Result<PacketPtr> Demuxer::read_packet(const char* failed) {
    PacketPtr packet(av_packet_alloc());
    if (!packet) return memory_error();
    const int status = av_read_frame(container_.get(), packet.get());
    if (status == AVERROR_EOF && container_->pb->error >= 0) return PacketPtr();
    if (status < 0) return error_at(file_ + failed, input_failure(*container_, status));
    return packet;
}

/// Puts one packet into its queue; false at the end of the file.
Result<bool> Demuxer::read_one() {
    TRY_ASSIGN(auto packet, read_packet(": cannot be read further"));
    if (!packet) return false;
    const auto queue = queues_.find(packet->stream_index);
    if (queue == queues_.end()) return true;
    if (queue->second.size() >= queue_limit)
        return input_error(file_ + ": its tracks run apart by more than " + std::to_string(queue_limit) +
                           " frames: interleave them");
    queued_bytes_ += static_cast<std::size_t>(packet->size);
    if (queued_bytes_ > queued_bytes_limit)
        return input_error(file_ + ": its tracks run apart by more than 1 GiB: interleave them");
    queue->second.push_back(std::move(packet));
    return true;
}

Result<const AVPacket*> Demuxer::peek(int stream) {
    auto& queue = queues_.at(stream);
    while (queue.empty()) {
        TRY_ASSIGN(const auto more, read_one());
        if (!more) return nullptr;
    }
    return queue.front().get();
}

Result<PacketPtr> Demuxer::next(int stream) {
    TRY_ASSIGN(const auto there, peek(stream));
    if (!there) return PacketPtr{};
    auto& queue = queues_.at(stream);
    PacketPtr packet = std::move(queue.front());
    queue.pop_front();
    queued_bytes_ -= static_cast<std::size_t>(packet->size);
    return packet;
}

bool Demuxer::seek(int stream, std::int64_t timestamp) {
    for (auto& [number, queue] : queues_) queue.clear();
    queued_bytes_ = 0;
    return av_seek_frame(container_.get(), stream, timestamp, AVSEEK_FLAG_BACKWARD) >= 0;
}

std::optional<std::int64_t> Demuxer::key_before(int stream, std::int64_t timestamp) const {
    const AVIndexEntry* entry =
        avformat_index_get_entry_from_timestamp(container_->streams[stream], timestamp, AVSEEK_FLAG_BACKWARD);
    if (!entry) return std::nullopt;
    return entry->timestamp;
}

bool Demuxer::has_flag(int stream, int entry, int flag) const {
    const AVIndexEntry* const found = avformat_index_get_entry(container_->streams[stream], entry);
    return found && (found->flags & flag) != 0;
}

/// A picture's place in the index, which may begin with pictures that only serve to decode others.
int Demuxer::entry_of(int stream, std::int64_t picture) const {
    const int entries = avformat_index_get_entries_count(container_->streams[stream]);
    int first = 0;
    while (first + 1 < entries && has_flag(stream, first, AVINDEX_DISCARD_FRAME)) ++first;
    return static_cast<int>(std::clamp<std::int64_t>(first + picture, first, std::max(first, entries - 1)));
}

std::int64_t Demuxer::pictures(int stream) const {
    const int entries = avformat_index_get_entries_count(container_->streams[stream]);
    std::int64_t shown = 0;
    for (int k = 0; k < entries; ++k) shown += has_flag(stream, k, AVINDEX_DISCARD_FRAME) ? 0 : 1;
    return shown;
}

std::int64_t Demuxer::key_picture(int stream, std::int64_t picture) const {
    const int first = entry_of(stream, 0);
    int at = entry_of(stream, picture);
    while (at > first && !has_flag(stream, at, AVINDEX_KEYFRAME)) --at;
    return at - first;
}

}  // namespace touchable
