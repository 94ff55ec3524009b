#include "engine/stream/stream_bytes.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/stream/srt_bytes.hpp"

namespace touchable {
namespace {

struct IoCloser {
    void operator()(AVIOContext* io) const { avio_closep(&io); }
};
using IoPtr = std::unique_ptr<AVIOContext, IoCloser>;

/// FFmpeg keeps its address as long as the connection is there.
int is_over(void* wait) {
    return static_cast<const StreamWait*>(wait)->is_over() ? 1 : 0;
}

/// As FFmpeg takes it: of UDP without settings, which it would read in units of its own.
std::string address_of(const StreamUrl& url) {
    const bool has_settings = url.transport == StreamTransport::udp;
    return has_settings ? url.text.substr(0, url.text.find('?')) : url.text;
}

/// What goes with its address.
struct NetworkOptions {
    AVDictionary* all = nullptr;
    explicit NetworkOptions(const StreamUrl& url) {
        set("protocol_whitelist", url.protocols());
        if (url.transport == StreamTransport::http) {
            set("max_redirects", "0");
            set("icy", "0");
            set("user_agent", "touchable");
            if (url.is_tls) set("tls_verify", "1");
        }
        if (url.transport == StreamTransport::udp) {
            set("overrun_nonfatal", "1");
            set("buffer_size", "4194304");
            if (const std::string own = url.value("localaddr"); !own.empty()) set("localaddr", own);
        }
    }
    ~NetworkOptions() { av_dict_free(&all); }
    NetworkOptions(const NetworkOptions&) = delete;
    NetworkOptions& operator=(const NetworkOptions&) = delete;
    void set(const char* name, const std::string& value) { av_dict_set(&all, name, value.c_str(), 0); }
};

class NetworkBytes final : public StreamBytes {
public:
    NetworkBytes(std::shared_ptr<StreamWait> wait, IoPtr io, StreamTransport transport)
        : StreamBytes(std::move(wait)), io_(std::move(io)), transport_(transport) {}
    std::optional<std::uint64_t> file_size() const override {
        const std::int64_t size = transport_ == StreamTransport::http ? avio_size(io_.get()) : -1;
        if (size < 0 || (io_->seekable & AVIO_SEEKABLE_NORMAL) == 0) return std::nullopt;
        return static_cast<std::uint64_t>(size);
    }
    bool read_at(std::uint64_t at, std::uint8_t* to, std::size_t count) override {
        return avio_seek(io_.get(), static_cast<std::int64_t>(at), SEEK_SET) >= 0 &&
               avio_read(io_.get(), to, static_cast<int>(count)) == static_cast<int>(count);
    }

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        constexpr std::size_t most = 1 << 20;
        const int got = avio_read_partial(io_.get(), to, static_cast<int>(std::min(count, most)));
        // HTTP has no other end where nothing says how long it is.
        const bool may_end_so = transport_ == StreamTransport::http && !file_size();
        const bool is_end = got == AVERROR_EOF || (got == AVERROR(EIO) && may_end_so);
        return is_end ? 0 : got;
    }

    const IoPtr io_;
    const StreamTransport transport_;
};

class PipeBytes final : public StreamBytes {
public:
    PipeBytes(std::shared_ptr<StreamWait> wait, int descriptor)
        : StreamBytes(std::move(wait)), descriptor_(descriptor) {}

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        constexpr int look_again_ms = 50;
        while (!waits()->is_over()) {
            pollfd waited{descriptor_, POLLIN, 0};
            if (::poll(&waited, 1, look_again_ms) <= 0) continue;
            const auto got = ::read(descriptor_, to, count);
            if (got >= 0) return got;
            if (errno != EAGAIN && errno != EINTR) return AVERROR(errno);
        }
        return AVERROR_EXIT;
    }

    const int descriptor_;
};

Error no_connection(const StreamUrl& url, const std::string& why, int status = 0) {
    const char* hint = status == AVERROR_HTTP_SERVER_ERROR
                           ? "; its listeners may be too many, try again later"
                       : url.transport == StreamTransport::http ? "; is it there, and not elsewhere?"
                       : url.transport == StreamTransport::udp  ? ""
                                                                : "; does the sender listen there?";
    return input_error("no connection: " + why + hint);
}

Result<std::shared_ptr<StreamBytes>> open_pipe(const StreamUrl& url, std::shared_ptr<StreamWait> wait) {
    int descriptor = -1;
    const char* const digits = url.text.data() + std::string_view("pipe:").size();
    (void)std::from_chars(digits, url.text.data() + url.text.size(), descriptor);
    if (::fcntl(descriptor, F_GETFD) < 0)
        return input_error("there is no open descriptor " + std::to_string(descriptor));
    return std::shared_ptr<StreamBytes>(std::make_shared<PipeBytes>(std::move(wait), descriptor));
}

/// Where a name is looked up FFmpeg waits as long as the system does: then another thread waits alone.
Result<IoPtr> open_network(const StreamUrl& url, const std::shared_ptr<StreamWait>& wait) {
    struct Opened {
        int status = 0;
        IoPtr io;
    };
    auto opened = unless_stopped(
        [url, wait] {
            NetworkOptions options(url);
            AVIOContext* io = nullptr;
            const AVIOInterruptCB callback{is_over, wait.get()};
            const int status =
                avio_open2(&io, address_of(url).c_str(), AVIO_FLAG_READ, &callback, &options.all);
            return Opened{status, IoPtr(io)};
        },
        [wait] { return wait->is_over(); });
    if (wait->is_interrupted()) return interrupted_error();
    if (!opened || opened->status == AVERROR_EXIT) return no_connection(url, "it did not answer in time");
    if (opened->status < 0) return no_connection(url, ffmpeg_text(opened->status), opened->status);
    return std::move(opened->io);
}

}  // namespace

Result<std::shared_ptr<StreamBytes>> StreamBytes::connect(const StreamUrl& url,
                                                          std::shared_ptr<StreamWait> wait,
                                                          const StreamPatience& patience) {
    silence_ffmpeg();
    const bool listens = url.transport == StreamTransport::srt && url.value("mode") == "listener";
    wait->at_most(listens ? patience.caller : patience.connection);
    if (url.transport == StreamTransport::pipe) return open_pipe(url, std::move(wait));
    if (url.transport == StreamTransport::srt) return connect_by_srt(url, std::move(wait));
    TRY_ASSIGN(auto io, open_network(url, wait));
    return std::shared_ptr<StreamBytes>(
        std::make_shared<NetworkBytes>(std::move(wait), std::move(io), url.transport));
}

Result<std::uint8_t> StreamBytes::peek() {
    std::uint8_t byte = 0;
    TRY_ASSIGN(const auto got, peeked_ ? Result<std::size_t>(1) : read(&byte, 1));
    if (got > 0 && !peeked_) peeked_ = byte;
    return peeked_.value_or(0);
}

Result<std::size_t> StreamBytes::read(std::uint8_t* to, std::size_t count) {
    if (peeked_ && count > 0) {
        *to = *std::exchange(peeked_, std::nullopt);
        return std::size_t{1};
    }
    if (has_ended_) return std::size_t{0};
    if (left_ == 0) return input_error("sends without end what is no frameset");
    if (wait_->is_interrupted()) return interrupted_error();
    if (wait_->is_too_long()) return input_error("sent no whole frameset in time");
    const std::int64_t got = some(to, static_cast<std::size_t>(std::min<std::uint64_t>(count, left_)));
    if (got > 0) {
        left_ -= static_cast<std::uint64_t>(got);
        return static_cast<std::size_t>(got);
    }
    if (wait_->is_interrupted()) return interrupted_error();
    if (wait_->is_too_long()) return input_error("sent no whole frameset in time");
    has_ended_ = true;
    was_lost_ = got < 0;
    how_it_ended_ =
        got < 0 ? "was lost (" + ffmpeg_text(static_cast<int>(got)) + ")" : "closed the connection";
    return std::size_t{0};
}

}  // namespace touchable
