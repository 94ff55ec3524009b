// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/ffmpeg.hpp"

extern "C" {
#include <libavutil/base64.h>
#include <libavutil/imgutils.h>
}

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>

#include "engine/base/threads.hpp"
#include "engine/picture/input.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {

namespace {

constexpr int input_buffer_bytes = 1 << 16;

/// Serves FFmpeg's reads and seeks.
struct InputBytes {
    std::optional<Error> failure{};

    virtual ~InputBytes() = default;
    virtual int read(std::uint8_t* to, int count) = 0;
    virtual std::int64_t seek(std::int64_t, int) { return AVERROR(ENOSYS); }
    int failed(const Error& why) {
        failure = why;
        return why.kind == ErrorKind::interrupted ? AVERROR_EXIT : AVERROR(EIO);
    }
};

struct StoredBytes : InputBytes {
    std::unique_ptr<ByteSource> source;
    std::uint64_t end;
    std::uint64_t at = 0;

    StoredBytes(std::unique_ptr<ByteSource> of, std::uint64_t up_to) : source(std::move(of)), end(up_to) {}

    int read(std::uint8_t* to, int count) override {
        if (stop_requested()) return failed(interrupted_error());
        if (at >= end) return AVERROR_EOF;
        const auto some = std::min<std::uint64_t>(static_cast<std::uint64_t>(count), end - at);
        if (auto read = source->read(at, reinterpret_cast<char*>(to), static_cast<std::size_t>(some)); !read)
            return failed(read.error());
        at += some;
        return static_cast<int>(some);
    }

    std::int64_t seek(std::int64_t offset, int whence) override {
        if ((whence & AVSEEK_SIZE) != 0) return static_cast<std::int64_t>(end);
        whence &= ~AVSEEK_FORCE;
        const std::int64_t from = whence == SEEK_CUR   ? static_cast<std::int64_t>(at)
                                  : whence == SEEK_END ? static_cast<std::int64_t>(end)
                                                       : 0;
        if (from + offset < 0) return AVERROR(EINVAL);
        at = static_cast<std::uint64_t>(from + offset);
        return from + offset;
    }
};

/// With the bytes themselves.
struct KeptBytes final : StoredBytes {
    const std::string bytes;

    explicit KeptBytes(std::string of) : StoredBytes(nullptr, of.size()), bytes(std::move(of)) {
        source = bytes_in_memory(bytes);
    }
};

struct FlowingBytes final : InputBytes {
    std::shared_ptr<Demuxer::ByteFlow> flow;

    explicit FlowingBytes(std::shared_ptr<Demuxer::ByteFlow> of) : flow(std::move(of)) {}

    int read(std::uint8_t* to, int count) override {
        const auto got = flow->read(to, static_cast<std::size_t>(count));
        if (!got) return failed(got.error());
        return *got > 0 ? static_cast<int>(*got) : AVERROR_EOF;
    }
};

InputBytes& bytes_of(const AVIOContext& io) {
    return *static_cast<InputBytes*>(io.opaque);
}

void close_io(AVIOContext* io) {
    delete &bytes_of(*io);
    av_freep(&io->buffer);
    avio_context_free(&io);
}

AVIOContext* open_io(std::unique_ptr<InputBytes> bytes, bool is_stored) {
    const auto read = [](void* own, std::uint8_t* to, int count) {
        return static_cast<InputBytes*>(own)->read(to, count);
    };
    const auto seek = [](void* own, std::int64_t offset, int whence) {
        return static_cast<InputBytes*>(own)->seek(offset, whence);
    };
    auto* const buffer = static_cast<unsigned char*>(av_malloc(input_buffer_bytes));
    AVIOContext* const io = buffer ? avio_alloc_context(buffer, input_buffer_bytes, 0, bytes.get(), read,
                                                        nullptr, is_stored ? +seek : nullptr)
                                   : nullptr;
    if (io)
        (void)bytes.release();
    else
        av_free(buffer);
    return io;
}

Error failure_of(const InputBytes& bytes, int status) {
    if (bytes.failure) return *bytes.failure;
    if (status == AVERROR_EXIT) return interrupted_error();
    return input_error(ffmpeg_text(status));
}

Result<InputPtr> open_bytes(std::unique_ptr<InputBytes> bytes, bool is_stored, const std::string& url,
                            const InputKind& kind) {
    silence_ffmpeg();
    AVFormatContext* container = avformat_alloc_context();
    AVIOContext* const io = container ? open_io(std::move(bytes), is_stored) : nullptr;
    if (!io) {
        avformat_free_context(container);
        return memory_error();
    }
    container->pb = io;
    container->interrupt_callback = stops_with_thread;
    container->error_recognition = kind.error_recognition;
    if (kind.most_streams > 0) container->max_streams = kind.most_streams;
    if (kind.probed > 0) container->probesize = kind.probed;
    AVDictionary* options = nullptr;
    if (kind.formats) av_dict_set(&options, "format_whitelist", kind.formats, 0);
    const int status = avformat_open_input(
        &container, url.c_str(), kind.format ? av_find_input_format(kind.format) : nullptr, &options);
    av_dict_free(&options);
    if (status >= 0) return InputPtr(container);
    const Error why = failure_of(bytes_of(*io), status);
    close_io(io);
    return why;
}

constexpr int buffer_bytes = 1 << 15;
// Bytes for the buffer and a muxer's end; bytes in its index of a picture with its sound.
constexpr std::int64_t least_reserve = 1 << 16, bytes_of_index = 128;
constexpr std::int64_t pictures_reserved = 4;
// Bytes around a packet, and in the index.
constexpr std::int64_t bytes_beside_packet = 48;

/// Null: out of memory.
AVBufferRef* plane_buffer(std::size_t bytes, PlaneContent content) {
    using Lease = std::shared_ptr<std::uint8_t>;
    // The caller may be FFmpeg, which knows no exceptions.
    std::unique_ptr<Lease> lease(new (std::nothrow) Lease(take_plane_memory(bytes, content)));
    if (!lease || !*lease) return nullptr;
    const auto end = [](void* ended, std::uint8_t*) { delete static_cast<Lease*>(ended); };
    AVBufferRef* const buffer = av_buffer_create(lease->get(), bytes, end, lease.get(), 0);
    if (buffer) static_cast<void>(lease.release());
    return buffer;
}

}  // namespace

std::string ffmpeg_text(int error) {
    std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
    if (av_strerror(error, text.data(), text.size()) < 0) return "FFmpeg error " + std::to_string(error);
    return text.data();
}

std::string file_url(const std::filesystem::path& path) {
    return "file:" + path.string();
}

const AVIOInterruptCB stops_with_thread{[](void*) { return stop_requested() ? 1 : 0; }, nullptr};

void silence_ffmpeg() {
    static std::once_flag once;
    std::call_once(once, [] { av_log_set_level(AV_LOG_QUIET); });
}

FramePtr bare_picture(AVPixelFormat format, int width, int height) {
    FramePtr picture(av_frame_alloc());
    if (!picture) return nullptr;
    picture->format = format;
    picture->width = width;
    picture->height = height;
    return picture;
}

FramePtr blank_picture(AVPixelFormat format, int width, int height, int alignment) {
    FramePtr picture = bare_picture(format, width, height);
    return !picture || av_frame_get_buffer(picture.get(), alignment) < 0 ? nullptr : std::move(picture);
}

FramePtr plane_picture(AVPixelFormat format, int width, int height) {
    const int row_bytes = av_image_get_linesize(format, width, 0);
    FramePtr picture = bare_picture(format, width, height);
    if (!picture || row_bytes < 0) return nullptr;
    const std::size_t stride = aligned_bytes(static_cast<std::size_t>(row_bytes), plane_row_alignment);
    picture->buf[0] =
        plane_buffer(stride * static_cast<std::size_t>(height) + plane_row_alignment, PlaneContent::any);
    if (!picture->buf[0]) return nullptr;
    picture->data[0] = picture->buf[0]->data;
    picture->linesize[0] = static_cast<int>(stride);
    return picture;
}

int give_plane_memory(AVCodecContext* decoder, AVFrame* picture, int flags) {
    const auto format = static_cast<AVPixelFormat>(picture->format);
    const AVPixFmtDescriptor* const kind = av_pix_fmt_desc_get(format);
    if (decoder->codec_type != AVMEDIA_TYPE_VIDEO || (decoder->codec->capabilities & AV_CODEC_CAP_DR1) == 0 ||
        !kind || (kind->flags & (AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_PAL)) != 0)
        return avcodec_default_get_buffer2(decoder, picture, flags);
    int width = picture->width, height = picture->height;
    std::array<int, AV_NUM_DATA_POINTERS> alignments{};  // powers of two, at most that of our rows
    avcodec_align_dimensions2(decoder, &width, &height, alignments.data());
    // All strides are those of one width, because some decoders rely on their ratio.
    std::array<int, 4> strides{};
    do {
        if (const int status = av_image_fill_linesizes(strides.data(), format, width); status < 0)
            return status;
        width += width & -width;
    } while (!std::ranges::all_of(strides, [](int stride) { return stride % plane_row_alignment == 0; }));
    std::array<std::size_t, 4> sizes{};
    const std::array<std::ptrdiff_t, 4> wide{strides[0], strides[1], strides[2], strides[3]};
    if (const int status = av_image_fill_plane_sizes(sizes.data(), format, height, wide.data()); status < 0)
        return status;
    // Some decoders write past the end of a plane: FFmpeg's own function leaves them this much room.
    constexpr std::size_t overrun = 16 + 64 - 1;
    std::size_t bytes = 0;
    std::array<std::size_t, 4> begins{};
    for (std::size_t plane = 0; plane < sizes.size() && sizes[plane] > 0; ++plane) {
        if (sizes[plane] > INT_MAX - overrun) return AVERROR(EINVAL);
        begins[plane] = bytes;
        bytes += aligned_bytes(sizes[plane] + overrun, plane_alignment);
    }
    // If data are missing, decoders leave samples as they are. These must not be another picture's.
    picture->buf[0] = plane_buffer(bytes, PlaneContent::zero);
    if (!picture->buf[0]) return AVERROR(ENOMEM);
    for (std::size_t plane = 0; plane < sizes.size() && sizes[plane] > 0; ++plane) {
        picture->data[plane] = picture->buf[0]->data + begins[plane];
        picture->linesize[plane] = strides[plane];
    }
    picture->extended_data = picture->data;
    return 0;
}

bool is_key_frame(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_MAJOR >= 59
    return (frame.flags & AV_FRAME_FLAG_KEY) != 0;
#else
    return frame.key_frame != 0;
#endif
}

bool encodes(const AVCodec& codec, AVPixelFormat format) {
    const AVPixelFormat* formats = nullptr;
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(61, 13, 100)
    const void* listed = nullptr;
    if (avcodec_get_supported_config(nullptr, &codec, AV_CODEC_CONFIG_PIX_FORMAT, 0, &listed, nullptr) < 0)
        return false;
    formats = static_cast<const AVPixelFormat*>(listed);
#else
    formats = codec.pix_fmts;
#endif
    if (!formats) return true;
    while (*formats != AV_PIX_FMT_NONE)
        if (*formats++ == format) return true;
    return false;
}

std::optional<std::string> decode_base64(std::string_view text, Base64Padding padding) {
    std::string digits(text);
    std::erase_if(digits, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
    const std::size_t written = digits.size();
    digits.resize(digits.find_last_not_of('=') + 1);
    const std::size_t padded = written - digits.size();
    const bool fits = padded == 0 && padding == Base64Padding::optional ? written % 4 != 1
                                                                        : written % 4 == 0 && padded <= 2;
    if (!fits) return std::nullopt;
    // FFmpeg stops at a "=" or a 0 anywhere: it then gives fewer bytes.
    std::string bytes(digits.size() * 3 / 4, '\0');
    const auto size = static_cast<int>(bytes.size());
    if (av_base64_decode(reinterpret_cast<std::uint8_t*>(bytes.data()), digits.c_str(), size) != size)
        return std::nullopt;
    return bytes;
}

void FfmpegDeleter::operator()(AVFormatContext* input) const {
    AVIOContext* const io = input->pb;
    avformat_close_input(&input);
    close_io(io);
}

Result<InputPtr> open_input(std::unique_ptr<ByteSource> bytes, std::uint64_t end, const std::string& file,
                            const InputKind& kind) {
    return open_bytes(std::make_unique<StoredBytes>(std::move(bytes), end), true, file_url(file), kind);
}

Result<InputPtr> open_flow(std::shared_ptr<Demuxer::ByteFlow> flow, const InputKind& kind) {
    return open_bytes(std::make_unique<FlowingBytes>(std::move(flow)), false, "", kind);
}

AVIOContext* open_memory(std::string bytes) {
    return open_io(std::make_unique<KeptBytes>(std::move(bytes)), true);
}

void close_memory(AVIOContext* io) {
    if (io) close_io(io);
}

Error input_failure(const AVFormatContext& container, int status) {
    return failure_of(bytes_of(*container.pb), status);
}

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
