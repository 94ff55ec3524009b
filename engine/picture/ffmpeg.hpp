#pragma once

// FFmpeg's C API with owners, the files that it reads and writes, and base64 by it.
//
// FramePtr, PacketPtr, CodecPtr, ScalerPtr and InputPtr own FFmpeg's objects; what differs between FFmpeg's
// versions is here and nowhere else. plane_picture and give_plane_memory put pictures into plane memory. A
// Demuxer takes a video file apart into packets by stream: what a container claims of itself is checked first
// (its boxes, its Matroska elements, where it ends), before FFmpeg believes it, and FFmpeg reads by our own
// reads, so that a stop is obeyed meanwhile. ReservedOutput writes a container with room kept for its end.
//
// Include it in .cpp files and in private headers: it brings FFmpeg's own. Errors are lines about the named
// file (ErrorKind::input), or ErrorKind::interrupted. Each object is used by one thread at a time.

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

/// RFC 4648, with white space between characters. Nothing where it is anything else.
std::optional<std::string> decode_base64(std::string_view text,
                                         Base64Padding padding = Base64Padding::required);

/// Of all that FFmpeg opens here: it gives up waits and work once the thread that it works on is asked to
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

/// An AVCodecContext::get_buffer2 that allocates a decoder's pictures in plane memory, with the layout of
/// avcodec_default_get_buffer2. It calls that function for hardware, palettes, sound, and decoders that must
/// have FFmpeg's own memory.
int give_plane_memory(AVCodecContext* decoder, AVFrame* picture, int flags);

/// Whether a decoder needs no earlier frame for this one (a flag from FFmpeg 6.1 on).
bool is_key_frame(const AVFrame& frame);

/// Whether an encoder takes pictures of this format. One that lists none takes any.
bool encodes(const AVCodec& codec, AVPixelFormat format);

/// Of a file that does not say how long it is.
Error never_completed(const std::string& file);

/// Takes a video file apart into packets, stream by stream. Interleaved streams wait in short queues.
class Demuxer {
public:
    /// Bytes that come one after the other, and once.
    class ByteFlow {
    public:
        virtual ~ByteFlow() = default;
        /// At most `count` bytes, as soon as there are any: how many; 0 at the end.
        virtual Result<std::size_t> read(std::uint8_t* to, std::size_t count) = 0;
    };

    /// Refused is a file that does not say how long it is, unless it may be a stream.
    static Result<std::unique_ptr<Demuxer>> open_matroska(const SourceFile& file, bool may_be_stream = false);
    /// QuickTime, and MP4, which is made of the same boxes. Tracks of disparity are
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
    Result<PacketPtr> next_packet() { return read_packet(""); }
    /// To a packet of `stream` that decoding can begin with, at `timestamp` (of that stream) or before. False
    /// where the file offers no way there. What follows may be anything: a reader checks the times.
    bool seek(int stream, std::int64_t timestamp);
    /// When the index has a packet of `stream` that decoding can begin with, at `timestamp` or the last
    /// before; nothing where it has none. Of Matroska, whose index is read by the first `seek`, once there
    /// was one.
    std::optional<std::int64_t> key_before(int stream, std::int64_t timestamp) const;

    /// How many pictures a file has whose index has every one, as MP4's. They are counted in the order in
    /// which they are decoded, which begins anew with each that decoding can begin with.
    std::int64_t pictures(int stream) const;
    /// The last one up to this that decoding can begin with.
    std::int64_t key_picture(int stream, std::int64_t picture) const;
    /// Whether decoding can begin with any packet of `stream`, as far as the index goes.
    bool is_all_keys(int stream) const;
    /// The packet that `next` gives; null at the end.
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

/// Of QuickTime and MP4, up to `end`: whether the tables of samples hold what they claim. FFmpeg takes memory
/// for all that a table claims before it reads any of it. Refused (ErrorKind::input) are one that claims more
/// than it holds, and samples without a table of their own, or played again and again, of which there are
/// more than the file has bytes for.
Result<void> check_box_tables(ByteSource& bytes, std::uint64_t end);

/// A file that an FFmpeg muxer writes, which has room on its disk for what is still to come before it is
/// written: the next pictures, and what a muxer puts at the end. So a writer that stops in time leaves a
/// whole file on a disk that became full. File systems that cannot reserve room have none.
class ReservedOutput : NonCopyable {
public:
    ReservedOutput() = default;
    ~ReservedOutput();

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
