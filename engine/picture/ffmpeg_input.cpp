#include "engine/picture/ffmpeg_input.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/stop_request.hpp"

namespace touchable {
namespace {

constexpr int input_buffer_bytes = 1 << 16;

Error interrupted_input() {
    return {ErrorKind::interrupted, "interrupted while it was read"};
}

/// What FFmpeg's calls for bytes come to.
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

struct StoredBytes final : InputBytes {
    std::unique_ptr<ByteSource> source;
    std::uint64_t end;
    std::uint64_t at = 0;

    StoredBytes(std::unique_ptr<ByteSource> of, std::uint64_t up_to) : source(std::move(of)), end(up_to) {}

    int read(std::uint8_t* to, int count) override {
        if (stop_requested()) return failed(interrupted_input());
        if (at >= end) return AVERROR_EOF;
        const auto some = std::min<std::uint64_t>(static_cast<std::uint64_t>(count), end - at);
        if (auto read = source->read(at, reinterpret_cast<char*>(to), static_cast<std::size_t>(some));
            !read) {
            failure = read.error();
            return AVERROR(EIO);
        }
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

struct FlowingBytes final : InputBytes {
    std::shared_ptr<ByteFlow> flow;

    explicit FlowingBytes(std::shared_ptr<ByteFlow> of) : flow(std::move(of)) {}

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

/// For what FFmpeg does between its reads.
int asks_to_stop(void*) {
    return stop_requested() ? 1 : 0;
}

Error failure_of(const InputBytes& bytes, int status) {
    if (bytes.failure) return *bytes.failure;
    if (status == AVERROR_EXIT) return interrupted_input();
    return input_error(ffmpeg_text(status));
}

Result<InputPtr> open_bytes(std::unique_ptr<InputBytes> bytes, bool is_stored, const std::string& url,
                            const InputKind& kind) {
    silence_ffmpeg();
    AVFormatContext* container = avformat_alloc_context();
    AVIOContext* const io = container ? open_io(std::move(bytes), is_stored) : nullptr;
    if (!io) {
        avformat_free_context(container);
        return Error{ErrorKind::internal, "out of memory"};
    }
    container->pb = io;
    container->interrupt_callback = {asks_to_stop, nullptr};
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

}  // namespace

void InputCloser::operator()(AVFormatContext* container) const {
    AVIOContext* const io = container->pb;
    avformat_close_input(&container);
    close_io(io);
}

Result<InputPtr> open_input(std::unique_ptr<ByteSource> bytes, std::uint64_t end, const std::string& file,
                            const InputKind& kind) {
    return open_bytes(std::make_unique<StoredBytes>(std::move(bytes), end), true, file_url(file), kind);
}

Result<InputPtr> open_flow(std::shared_ptr<ByteFlow> flow, const InputKind& kind) {
    return open_bytes(std::make_unique<FlowingBytes>(std::move(flow)), false, "", kind);
}

Error input_failure(const AVFormatContext& container, int status) {
    return failure_of(bytes_of(*container.pb), status);
}

}  // namespace touchable
