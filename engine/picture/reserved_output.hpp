#pragma once

#include <cstdint>
#include <filesystem>

#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// A file that an FFmpeg muxer writes, which has room on its disk for what is still to come before it is
/// written: the next pictures, and what a muxer puts at the end. So whoever stops in time has a whole file on
/// a disk that became full. File systems that cannot reserve room have none.
class ReservedOutput {
public:
    ReservedOutput() = default;
    ~ReservedOutput();
    ReservedOutput(const ReservedOutput&) = delete;
    ReservedOutput& operator=(const ReservedOutput&) = delete;

    /// A file that is there already, for `muxer`, which lives as long as this. Below 0: FFmpeg's error.
    int open(const std::filesystem::path& file, AVFormatContext& muxer);
    /// A picture is written: the next ones may be as large.
    void end_picture();
    /// Before the muxer is given a packet, which it may hold for a while: room for it. False: it is full.
    bool reserve_for(const AVPacket& packet);
    /// No room is left but what is reserved: it is time to end.
    bool is_full() const { return is_full_; }
    /// What waits is written, and the file is as long as what is in it. Below 0: FFmpeg's error.
    int close();

private:
    static int write(void* self, MuxedBytes* bytes, int size);
    static std::int64_t seek(void* self, std::int64_t to, int whence);
    void reserve();

    AVIOContext* io_ = nullptr;
    int file_ = -1;
    std::int64_t at_ = 0, end_ = 0;  // of the file
    std::int64_t allocated_ = 0;     // of it, with what is reserved
    std::int64_t packets_end_ = 0;   // where it ends at most once the muxer has written all its packets
    std::int64_t pictures_ = 0, picture_begin_ = 0, largest_picture_ = 0;
    bool can_reserve_ = true, is_full_ = false;
};

}  // namespace touchable
