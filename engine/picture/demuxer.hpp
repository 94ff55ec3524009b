#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg_input.hpp"

namespace touchable {

/// Of a file that does not say how long it is.
Error never_completed(const std::string& file);

/// Takes a video file apart into packets, stream by stream. Interleaved streams wait in short queues.
class Demuxer {
public:
    /// Refused is a file that does not say how long it is, unless it may be a stream.
    static Result<std::unique_ptr<Demuxer>> open_matroska(const SourceFile& file, bool may_be_stream = false);
    /// QuickTime, and MP4, which is made of the same boxes. Tracks of disparity (disparity_tracks.hpp) are
    /// HEVC like others.
    static Result<std::unique_ptr<Demuxer>> open_quicktime(const SourceFile& file);
    /// The same of other bytes than the file's; `file` is how messages call it.
    static Result<std::unique_ptr<Demuxer>> open_quicktime(std::unique_ptr<ByteSource> bytes,
                                                           const std::string& file);

    /// Any of these, or AVI, as its first bytes tell.
    static Result<std::unique_ptr<Demuxer>> open_video(const SourceFile& file);

    /// Of bytes that end at `end`; `format` as FFmpeg calls it, `name` as people do.
    static Result<std::unique_ptr<Demuxer>> open(std::unique_ptr<ByteSource> bytes, std::uint64_t end,
                                                 const std::string& file, const char* format,
                                                 const std::string& name);

    /// Of bytes as they come, in which what is damaged is passed over where that is possible: `next_packet`
    /// alone. At most 16 tracks.
    static Result<std::unique_ptr<Demuxer>> open_live(std::shared_ptr<ByteFlow> flow, const std::string& file,
                                                      const char* format);

    const AVFormatContext& container() const { return *container_; }
    /// Of Matroska: it does not say how long it is; and whether it ends within something, or before it said.
    bool is_open_ended() const { return is_open_ended_; }
    bool is_cut() const { return is_cut_; }
    /// Whether that is a track of disparity of an iPhone's Cinematic video.
    bool is_disparity(int stream) const;
    /// A tag of the whole file.
    std::optional<std::string> tag(const char* name) const;
    /// Seconds at which the pictures end: of a file that has sound as well, by what its picture tracks say of
    /// themselves, where they do. Nothing where the file says nothing.
    std::optional<double> pictures_end() const;
    /// The bytes of an attached file.
    std::optional<std::string> attachment(const std::string& file_name) const;

    /// Streams never selected are skipped.
    void select(int stream) { queues_[stream]; }
    /// The next packet of a selected stream; null after the last.
    Result<PacketPtr> next(int stream);
    /// The next packet of any stream, whatever is selected; null after the last.
    Result<PacketPtr> next_packet();
    /// To a packet of `stream` that decoding can begin with, at `timestamp` (of that stream) or before. False
    /// where the file offers no way there. What follows may be anything: whoever reads on checks the times.
    bool seek(int stream, std::int64_t timestamp);
    /// When the index has a packet of `stream` that decoding can begin with, at `timestamp` or the last
    /// before; nothing where it has none. Of Matroska, whose index is read by the first `seek`, once there
    /// was one.
    std::optional<std::int64_t> key_before(int stream, std::int64_t timestamp) const;

    // Of a file whose index has every picture, as MP4's: these are counted in the order in which they are
    // decoded, which begins anew with each that decoding can begin with.
    std::int64_t pictures(int stream) const;
    /// The last one up to this that decoding can begin with.
    std::int64_t key_picture(int stream, std::int64_t picture) const;
    /// Whether decoding can begin with any packet of `stream`, as far as the index goes.
    bool is_all_keys(int stream) const;
    /// The packet that `next` gives; null at the end.
    Result<const AVPacket*> peek(int stream);

private:
    Result<bool> read_one();
    bool has_flag(int stream, int entry, int flag) const;
    int entry_of(int stream, std::int64_t picture) const;

    std::string file_;
    InputPtr container_;
    std::map<int, std::deque<PacketPtr>> queues_;
    std::size_t queued_bytes_ = 0;
    std::vector<int> disparities_;  // numbers of such tracks in the file
    bool is_open_ended_ = false, is_cut_ = false;
};

}  // namespace touchable
