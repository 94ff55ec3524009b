#include "engine/media/demuxer.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

#include "engine/media/matroska_check.hpp"

extern "C" {
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

/// Frames one stream may run ahead of another, and what they all may hold while they wait.
constexpr std::size_t queue_limit = 64, queued_bytes_limit = std::size_t{1} << 30;

constexpr std::uint64_t largest_trailer = 1 << 16;

std::optional<std::string> entry(const AVDictionary* dictionary, const char* name) {
    const AVDictionaryEntry* found = av_dict_get(dictionary, name, nullptr, 0);
    if (!found) return std::nullopt;
    return found->value;
}

/// Whether a QuickTime file's outermost boxes, each a length, a type and a content, fill it exactly. FFmpeg
/// is content with a last box that is cut. Record3D puts JSON behind the last box.
bool boxes_are_whole(const std::filesystem::path& file) {
    std::error_code failure;
    const std::uint64_t length = std::filesystem::file_size(file, failure);
    std::ifstream in(file, std::ios::binary);
    std::uint64_t position = 0;
    while (!failure && position < length) {
        std::array<std::uint8_t, 16> head{};
        in.seekg(static_cast<std::streamoff>(position));
        in.read(reinterpret_cast<char*>(head.data()), head.size());
        if (in.gcount() < 8) return false;
        in.clear();  // a last box may be shorter than a long head
        const std::uint64_t stated = AV_RB32(head.data());
        const bool is_text = head[0] == '{' && head[1] == '"' && length - position < largest_trailer;
        if (is_text && position > 0) return true;
        const std::uint64_t size = stated == 0   ? length - position  // to the end of the file
                                   : stated == 1 ? AV_RB64(head.data() + 8)
                                                 : stated;
        if (size < 8 || size > length - position) return false;
        position += size;
    }
    return position == length && length > 0;
}

/// Whether an AVI file is as long as its first chunk says; what may follow are further ones of a large file.
bool riff_is_whole(const std::filesystem::path& file) {
    std::error_code failure;
    const std::uint64_t length = std::filesystem::file_size(file, failure);
    std::ifstream in(file, std::ios::binary);
    while (!failure && length > 0) {
        std::array<std::uint8_t, 8> head{};
        const auto position = static_cast<std::uint64_t>(in.tellg());
        in.read(reinterpret_cast<char*>(head.data()), head.size());
        if (in.gcount() < 8) return false;
        const std::uint64_t end = position + 8 + AV_RL32(head.data() + 4);
        if (end > length) return false;
        if (end + 8 > length) return true;  // a byte of padding at most
        in.seekg(static_cast<std::streamoff>(end));
    }
    return false;
}

}  // namespace

Result<std::unique_ptr<Demuxer>> Demuxer::open_matroska(const std::filesystem::path& file) {
    if (auto whole = check_matroska(file); !whole) return whole.error();
    return open(file, "matroska", "Matroska");
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_quicktime(const std::filesystem::path& file) {
    if (!boxes_are_whole(file))
        return input_error(file.string() + ": is truncated, or no QuickTime or MP4 file");
    return open(file, "mov", "QuickTime or MP4");
}

Result<std::unique_ptr<Demuxer>> Demuxer::open_video(const std::filesystem::path& file) {
    std::array<char, 4> first{};
    std::ifstream(file, std::ios::binary).read(first.data(), first.size());
    const std::string_view begin(first.data(), first.size());
    if (begin == "\x1a\x45\xdf\xa3") return open_matroska(file);
    if (begin != "RIFF") return open_quicktime(file);
    if (!riff_is_whole(file)) return input_error(file.string() + ": is truncated, or no AVI file");
    return open(file, "avi", "AVI");
}

Result<std::unique_ptr<Demuxer>> Demuxer::open(const std::filesystem::path& file, const char* format,
                                               const std::string& name) {
    silence_ffmpeg();
    auto demuxer = std::make_unique<Demuxer>();
    demuxer->file_ = file.string();
    AVFormatContext* container = avformat_alloc_context();
    if (!container) return Error{ErrorKind::internal, "out of memory"};
    container->error_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
    const int status =
        avformat_open_input(&container, file_url(file).c_str(), av_find_input_format(format), nullptr);
    if (status < 0)
        return input_error(file.string() + ": is not a readable " + name + " file: " + ffmpeg_text(status));
    demuxer->container_.reset(container);
    return demuxer;
}

std::optional<std::string> Demuxer::tag(const char* name) const {
    return entry(container_->metadata, name);
}

std::optional<double> Demuxer::pictures_end() const {
    const std::int64_t whole_us = container_->duration;
    if (whole_us == AV_NOPTS_VALUE || whole_us <= 0) return std::nullopt;
    const double whole_s = static_cast<double>(whole_us) / AV_TIME_BASE;
    bool has_sound = false;
    double pictures_s = 0;
    for (unsigned k = 0; k < container_->nb_streams; ++k) {
        const AVStream& stream = *container_->streams[k];
        has_sound = has_sound || stream.codecpar->codec_type == AVMEDIA_TYPE_AUDIO;
        if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO) continue;
        // As Matroska's writers have it: 00:00:03.007000000.
        int hours = 0, minutes = 0;
        double seconds = 0;
        const std::string stated = entry(stream.metadata, "DURATION").value_or("");
        if (std::sscanf(stated.c_str(), "%d:%d:%lf", &hours, &minutes, &seconds) != 3) continue;
        pictures_s = std::max(pictures_s, 3600.0 * hours + 60.0 * minutes + seconds);
    }
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

/// Puts one packet into its queue; false at the end of the file.
Result<bool> Demuxer::read_one() {
    PacketPtr packet(av_packet_alloc());
    if (!packet) return Error{ErrorKind::internal, "out of memory"};
    const int status = av_read_frame(container_.get(), packet.get());
    if (status == AVERROR_EOF && (!container_->pb || container_->pb->error >= 0)) return false;
    if (status < 0) return input_error(file_ + ": cannot be read further: " + ffmpeg_text(status));
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
        const auto more = read_one();
        if (!more) return more.error();
        if (!*more) return nullptr;
    }
    return queue.front().get();
}

Result<PacketPtr> Demuxer::next(int stream) {
    const auto there = peek(stream);
    if (!there) return there.error();
    if (!*there) return PacketPtr{};
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

}  // namespace touchable
