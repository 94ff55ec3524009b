// SPDX-License-Identifier: Apache-2.0
#pragma once

// FFmpeg's C API with owners, the files that it reads and writes, and base64 by it.
//
// FramePtr, PacketPtr, CodecPtr, ScalerPtr and InputPtr own FFmpeg's objects; what differs between FFmpeg's
// versions is here and nowhere else. plane_picture and give_plane_memory put pictures into plane memory. A
// Demuxer takes a video file apart into packets by stream: what a container claims is checked first (its
// boxes, its Matroska elements, its end), and FFmpeg reads by our own functions, so that a stop is obeyed.
// ReservedOutput writes a container with room reserved for its end.
//
// Include it in .cpp files and in private headers: it brings FFmpeg's own. Errors are lines about the named
// file (ErrorKind::input), or ErrorKind::interrupted.
// Threads: one at a time uses an object.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <deque>
#include <map>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

enum class Base64Padding { required, optional };

/// RFC 4648, with white space between characters. Nullopt for anything else.
std::optional<std::string> decode_base64(std::string_view text,
                                         Base64Padding padding = Base64Padding::required);

/// Interrupt callback of everything that FFmpeg opens here: ends its waits and work once its thread is to
/// stop (stop_requested).
extern const AVIOInterruptCB stops_with_thread;

struct FfmpegDeleter {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
    void operator()(AVFormatContext* input) const;  ///< with the bytes that it reads
};
using FramePtr = std::unique_ptr<AVFrame, FfmpegDeleter>;
using PacketPtr = std::unique_ptr<AVPacket, FfmpegDeleter>;
using CodecPtr = std::unique_ptr<AVCodecContext, FfmpegDeleter>;
using ScalerPtr = std::unique_ptr<SwsContext, FfmpegDeleter>;
using InputPtr = std::unique_ptr<AVFormatContext, FfmpegDeleter>;

inline Error memory_error() {
    return internal_error("out of memory");
}

/// What FFmpeg means by a negative return value.
std::string ffmpeg_text(int error);

/// A path as FFmpeg takes it: with no characters mistaken for a protocol or an option.
std::string file_url(const std::filesystem::path& path);

/// Errors come back as Results, so FFmpeg itself prints nothing. Holds for the whole process; called wherever
/// a file or a codec is opened.
void silence_ffmpeg();

/// The bytes that an AVIOContext hands to its `write` callback: FFmpeg 7 made them const. (This and the next
/// two are what differs between FFmpeg's versions: no other file asks for the version.)
#if LIBAVFORMAT_VERSION_MAJOR >= 61
using MuxedBytes = const std::uint8_t;
#else
using MuxedBytes = std::uint8_t;
#endif

/// A picture of one plane, grey or packed colours, in plane memory (plane_memory.hpp), with any content.
/// Whole vectors of 64 bytes may be written past the end of a row. Null: out of memory.
FramePtr plane_picture(AVPixelFormat format, int width, int height);

/// A picture without memory. Null: out of memory.
FramePtr bare_picture(AVPixelFormat format, int width, int height);

/// A picture in FFmpeg's own memory, with any content; `alignment`: of its rows, bytes; 0: FFmpeg's choice.
/// Null: out of memory.
FramePtr blank_picture(AVPixelFormat format, int width, int height, int alignment = 0);

/// An AVCodecContext::get_buffer2 that allocates a decoder's pictures in plane memory, with the layout of
/// avcodec_default_get_buffer2. It calls that function for hardware, palettes, sound, and decoders that must
/// have FFmpeg's own memory.
int give_plane_memory(AVCodecContext* decoder, AVFrame* picture, int flags);

/// Whether a decoder needs no earlier frame for this one (a flag from FFmpeg 6.1 on).
bool is_key_frame(const AVFrame& frame);

/// Whether an encoder takes pictures of this format. One that lists none takes any.
bool encodes(const AVCodec& codec, AVPixelFormat format);

/// Bytes that FFmpeg reads as a file, until the thread is to stop; null: out of memory. `close_memory` ends
/// them; it takes null, too.
AVIOContext* open_memory(std::string bytes);
void close_memory(AVIOContext* io);

/// The error for a file that does not state its length.
Error never_completed(const std::string& file);

/// Takes a video file apart into packets, stream by stream. Interleaved streams wait in short queues.
class Demuxer {
public:
    /// Bytes that can be read once, in order.
    class ByteFlow {
    public:
        virtual ~ByteFlow() = default;
        /// Waits for bytes and reads up to `count`; returns how many, 0 at the end.
        virtual Result<std::size_t> read(std::uint8_t* to, std::size_t count) = 0;
    };

    /// `file` names it in messages.
    Demuxer(std::string file, InputPtr container)
        : file_(std::move(file)), container_(std::move(container)) {}
    /// Refuses a file that does not state its length, unless it may be a stream.
    static Result<std::unique_ptr<Demuxer>> open_matroska(const SourceFile& file, bool may_be_stream = false);
    /// QuickTime, and MP4, which has the same boxes. Disparity tracks are opened as HEVC.
    static Result<std::unique_ptr<Demuxer>> open_quicktime(const SourceFile& file);
    /// The same for bytes from elsewhere; `file`: their name in messages.
    static Result<std::unique_ptr<Demuxer>> open_quicktime(std::unique_ptr<ByteSource> bytes,
                                                           const std::string& file);

    /// Any of these, or AVI, as its first bytes tell.
    static Result<std::unique_ptr<Demuxer>> open_video(const SourceFile& file);

    /// Opens bytes that end at `end`; `format`: FFmpeg's name; `name`: that of messages.
    static Result<std::unique_ptr<Demuxer>> open(std::unique_ptr<ByteSource> bytes, std::uint64_t end,
                                                 const std::string& file, const char* format,
                                                 const std::string& name);

    /// Opens bytes as they come; skips damage where possible. Only `next_packet` reads them. At most 16
    /// tracks.
    static Result<std::unique_ptr<Demuxer>> open_live(std::shared_ptr<ByteFlow> flow, const std::string& file,
                                                      const char* format);

    const AVFormatContext& container() const { return *container_; }
    /// Matroska: no length is stated; and whether it ends within an element, or before its stated length.
    bool is_open_ended() const { return is_open_ended_; }
    bool is_cut() const { return is_cut_; }
    /// Whether a stream is the disparity of an iPhone's Cinematic video.
    bool is_disparity(int stream) const;
    /// A tag of the whole file.
    std::optional<std::string> tag(const char* name) const;
    /// The streams of pictures that have a tag, each with its value.
    std::vector<std::pair<const AVStream*, std::string>> tagged_pictures(const char* name) const;
    /// Seconds at which the pictures end; if the file has sound as well, by the picture tracks' own
    /// durations, if stated. Nullopt if the file states none.
    std::optional<double> pictures_end() const;
    /// The bytes of an attached file.
    std::optional<std::string> attachment(const std::string& file_name) const;

    /// Streams never selected are skipped.
    void select(int stream) { queues_[stream]; }
    /// The next packet of a selected stream; null after the last.
    Result<PacketPtr> next(int stream);
    /// The next packet of any stream, whatever is selected; null after the last.
    Result<PacketPtr> next_packet() { return read_packet(""); }
    /// Seeks to a keyframe of `stream` at or before `timestamp` (of that stream). False if the file offers no
    /// way there. The next packets may be any: readers must check their times.
    bool seek(int stream, std::int64_t timestamp);
    /// Time of the index's last keyframe of `stream` at or before `timestamp`; nullopt if it has none.
    /// Matroska's index is read by the first `seek`.
    std::optional<std::int64_t> key_before(int stream, std::int64_t timestamp) const;

    /// Number of pictures in an index that has all, as MP4's. They are counted in decoding order; none is
    /// reordered across a keyframe.
    std::int64_t pictures(int stream) const;
    /// The last keyframe at or before this picture.
    std::int64_t key_picture(int stream, std::int64_t picture) const;
    /// The packet that `next` will return; null at the end.
    Result<const AVPacket*> peek(int stream);

private:
    Result<PacketPtr> read_packet(const char* failed);
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

/// Checks that sample tables of QuickTime and MP4, up to `end`, hold what they claim: FFmpeg allocates all
/// that a table claims before it reads any. Refused (ErrorKind::input): a table that claims more than it
/// holds, and more samples than the file has bytes for, without a table of their own or repeated by edits.
Result<void> check_box_tables(ByteSource& bytes, std::uint64_t end);

/// A file written by an FFmpeg muxer, with disk space reserved for the next pictures and for what the muxer
/// puts at the end. So a writer that stops in time leaves a whole file on a full disk. Some file systems
/// cannot reserve space.
class ReservedOutput : NonCopyable {
public:
    ReservedOutput() = default;
    ~ReservedOutput();

    /// Opens an existing file for `muxer`, which lives as long as this. Below 0: FFmpeg's error.
    int open(const std::filesystem::path& file, AVFormatContext& muxer);
    /// Call after each picture: the next ones may be as large.
    void end_picture();
    /// Reserves room for a packet; call before the muxer gets it, which may hold it back. False: the disk is
    /// full.
    bool reserve_for(const AVPacket& packet);
    /// Whether only reserved room is left: time to end the file.
    bool is_full() const { return is_full_; }
    /// Flushes, cuts off the reserved room and closes the file. Below 0: FFmpeg's error.
    int close();

private:
    static int write(void* self, MuxedBytes* bytes, int size);
    static std::int64_t seek(void* self, std::int64_t to, int whence);
    void reserve();

    AVIOContext* io_ = nullptr;
    int file_ = -1;
    std::int64_t at_ = 0, end_ = 0;  // of the file
    std::int64_t allocated_ = 0;     // bytes on disk, with those reserved
    std::int64_t packets_end_ = 0;   // upper bound of the file's end with all packets written
    std::int64_t pictures_ = 0, picture_begin_ = 0, largest_picture_ = 0;
    bool can_reserve_ = true, is_full_ = false;
};

}  // namespace touchable
