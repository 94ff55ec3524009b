#include "engine/picture/reserved_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

namespace touchable {
namespace {

constexpr int buffer_bytes = 1 << 15;
// What waits in the buffer, and a muxer's end; of its index what a picture and its sound take in it.
constexpr std::int64_t least_reserve = 1 << 16, bytes_of_index = 128;
constexpr std::int64_t pictures_reserved = 4;
// Around a packet, and in the index.
constexpr std::int64_t bytes_beside_packet = 48;

}  // namespace

ReservedOutput::~ReservedOutput() {
    if (io_) {
        av_freep(&io_->buffer);
        avio_context_free(&io_);
    }
    if (file_ >= 0) ::close(file_);
}

int ReservedOutput::open(const std::filesystem::path& file, AVFormatContext& muxer) {
    file_ = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
    if (file_ < 0) return AVERROR(errno);
    auto* const buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    if (buffer) io_ = avio_alloc_context(buffer, buffer_bytes, 1, this, nullptr, write, seek);
    if (!io_) {
        av_free(buffer);
        return AVERROR(ENOMEM);
    }
    muxer.pb = io_;
    muxer.flags |= AVFMT_FLAG_CUSTOM_IO;
    return 0;
}

void ReservedOutput::reserve() {
    const std::int64_t next_pictures =
        end_ + pictures_reserved * largest_picture_ + bytes_of_index * pictures_;
    const std::int64_t wanted = std::max(next_pictures, packets_end_) + least_reserve;
    if (!can_reserve_ || is_full_ || wanted <= allocated_) return;
    const std::int64_t target = wanted + least_reserve;  // not anew for every picture
    if (fallocate(file_, 0, allocated_, target - allocated_) == 0)
        allocated_ = target;
    else if (errno == ENOSPC || errno == EFBIG || errno == EDQUOT)
        is_full_ = true;
    else if (errno != EINTR)
        can_reserve_ = false;
}

int ReservedOutput::write(void* self, MuxedBytes* bytes, int size) {
    auto& it = *static_cast<ReservedOutput*>(self);
    for (int done = 0; done < size;) {
        const ssize_t count =
            pwrite(it.file_, bytes + done, static_cast<std::size_t>(size - done), it.at_ + done);
        if (count > 0)
            done += static_cast<int>(count);
        else if (count == 0 || errno != EINTR)
            return count == 0 ? AVERROR(ENOSPC) : AVERROR(errno);
    }
    it.at_ += size;
    it.end_ = std::max(it.end_, it.at_);
    it.reserve();
    return size;
}

std::int64_t ReservedOutput::seek(void* self, std::int64_t to, int whence) {
    auto& it = *static_cast<ReservedOutput*>(self);
    if ((whence & AVSEEK_SIZE) != 0) return it.end_;
    if (whence == SEEK_CUR) to += it.at_;
    if (whence == SEEK_END) to += it.end_;
    return to < 0 ? AVERROR(EINVAL) : it.at_ = to;
}

void ReservedOutput::end_picture() {
    const std::int64_t end = std::max(end_, avio_tell(io_));
    largest_picture_ = std::max(largest_picture_, end - picture_begin_);
    picture_begin_ = end;
    ++pictures_;
}

bool ReservedOutput::reserve_for(const AVPacket& packet) {
    packets_end_ += packet.size + bytes_beside_packet;
    reserve();
    return !is_full_;
}

int ReservedOutput::close() {
    avio_flush(io_);
    if (io_->error < 0) return io_->error;
    if (allocated_ > end_ && ftruncate(file_, end_) != 0) return AVERROR(errno);
    return ::close(std::exchange(file_, -1)) == 0 ? 0 : AVERROR(errno);
}

}  // namespace touchable
