// SPDX-License-Identifier: Apache-2.0
// Sources of a received stream's bytes: FFmpeg's protocols, pipes and files (StreamBytes; SRT: srt.cpp), and
// files on a server that are read part by part (open_http).

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>

#include "engine/base/try.hpp"
#include "engine/stream/srt.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {
namespace {

// --- FFmpeg's protocols

AVDictionary* network_options(const StreamUrl& url) {
    if (url.transport == StreamTransport::http) return http_options(url.is_tls);
    AVDictionary* options = nullptr;
    const auto set = [&](const char* name, const std::string& value) {
        if (!value.empty()) av_dict_set(&options, name, value.c_str(), 0);
    };
    set("protocol_whitelist", url.protocols());
    if (url.transport == StreamTransport::udp) {
        set("overrun_nonfatal", "1");
        set("buffer_size", "4194304");
        set("localaddr", url.value("localaddr"));
    }
    return options;
}

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
        // Without a stated length, HTTP has no other end.
        const bool may_end_so = transport_ == StreamTransport::http && !file_size();
        const bool is_end = got == AVERROR_EOF || (got == AVERROR(EIO) && may_end_so);
        return is_end ? 0 : got;
    }

    bool ends_in_silence() const override { return transport_ == StreamTransport::udp; }

    const IoPtr io_;
    const StreamTransport transport_;
};

Error no_connection(const StreamUrl& url, const std::string& why, int status = 0) {
    const char* hint = status == AVERROR_HTTP_SERVER_ERROR
                           ? "; its listeners may be too many, try again later"
                       : url.transport == StreamTransport::http ? "; is the server running at that address?"
                       : url.transport == StreamTransport::udp  ? ""
                                                                : "; does the sender listen there?";
    return input_error("no connection: " + why + hint);
}

/// Opens on another thread: while FFmpeg looks a name up, it waits as long as the system does.
Result<IoPtr> open_network(const StreamUrl& url) {
    struct Opened {
        int status = 0;
        IoPtr io;
        bool has_no_host = false;
    };
    auto opened = unless_stopped([url] {
        // FFmpeg would read UDP's settings in other units.
        const bool has_settings = url.transport == StreamTransport::udp;
        const std::string address = has_settings ? url.text.substr(0, url.text.find('?')) : url.text;
        AVDictionary* options = network_options(url);
        AVIOContext* io = nullptr;
        const int status = avio_open2(&io, address.c_str(), AVIO_FLAG_READ, &stops_with_thread, &options);
        av_dict_free(&options);
        return Opened{status, IoPtr(io), status == AVERROR(EIO) && !look_up(url)};
    });
    if (!opened || opened->status == AVERROR_EXIT) return no_connection(url, "it did not answer in time");
    if (opened->has_no_host) return input_error("no connection: no host of that name");
    if (opened->status < 0) return no_connection(url, ffmpeg_text(opened->status), opened->status);
    return std::move(opened->io);
}

// --- Pipes

class PipeBytes final : public StreamBytes {
public:
    PipeBytes(std::shared_ptr<StreamWait> wait, int descriptor)
        : StreamBytes(std::move(wait)), descriptor_(descriptor) {}

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        while (wait_unless_stopped(descriptor_, POLLIN)) {
            const auto got = ::read(descriptor_, to, count);
            if (got >= 0) return got;
            if (errno != EAGAIN && errno != EINTR) return AVERROR(errno);
        }
        return AVERROR_EXIT;
    }

    const int descriptor_;
};

Result<std::shared_ptr<StreamBytes>> open_pipe(const StreamUrl& url, std::shared_ptr<StreamWait> wait) {
    int descriptor = -1;
    const char* const digits = url.text.data() + std::string_view("pipe:").size();
    (void)std::from_chars(digits, url.text.data() + url.text.size(), descriptor);
    if (::fcntl(descriptor, F_GETFD) < 0)
        return input_error("there is no open descriptor " + std::to_string(descriptor));
    return std::shared_ptr<StreamBytes>(std::make_shared<PipeBytes>(std::move(wait), descriptor));
}

// --- Files

class FileBytes final : public StreamBytes {
public:
    explicit FileBytes(GivenFile file)
        : StreamBytes(std::make_shared<StreamWait>()), file_(std::move(file)) {}

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(count, file_.size() - at_));
        if (!file_.read(at_, reinterpret_cast<char*>(to), some)) return AVERROR(EIO);
        at_ += some;
        return static_cast<std::int64_t>(some);
    }
    const char* usual_end() const override { return "ends"; }

    GivenFile file_;
    std::uint64_t at_ = 0;
};

// --- Files on a server

/// A file on a server, shared by all its readers. Holds the part that was read last.
class HttpFile {
public:
    HttpFile(StreamUrl url, const StreamSource::Patience& patience, std::uint64_t size,
             std::shared_ptr<StreamWait> wait, std::shared_ptr<StreamBytes> connection)
        : url_(std::move(url)),
          patience_(patience),
          size_(size),
          wait_(std::move(wait)),
          connection_(std::move(connection)) {}

    /// Like GivenFile::Reading.
    std::ptrdiff_t read(std::uint64_t at, char* to, std::size_t count, bool may_wait) {
        std::unique_lock held(mutex_, std::defer_lock);
        if (may_wait)
            held.lock();
        else if (!held.try_lock())
            return -EAGAIN;
        if (at >= size_) return 0;
        if (at < at_ || at - at_ >= part_.size()) {
            if (const int failure = failure_; failure != 0) return -failure;
            if (!may_wait) return -EAGAIN;
            if (const int failure = fetch(at); failure != 0) return -failure;
        }
        const auto from = static_cast<std::size_t>(at - at_);
        const std::size_t some = std::min(count, part_.size() - from);
        std::memcpy(to, part_.data() + from, some);
        return static_cast<std::ptrdiff_t>(some);
    }

    std::optional<Error> end_opening() {
        is_opening_ = false;
        if (failure_ == 0) return std::nullopt;
        return input_error(failure_ == ETIMEDOUT
                               ? "comes too slowly: its clip was not open within " +
                                     std::to_string(patience_.opening.count() / 1000) +
                                     " s; save it first, and open it here"
                               : "cannot be read: the connection was lost, and another gave no more of it");
    }

private:
    /// 0, or an errno.
    int fetch(std::uint64_t at) {
        constexpr std::uint64_t part_bytes = std::uint64_t{1} << 20;
        part_.resize(static_cast<std::size_t>(std::min(part_bytes, size_ - at)));
        at_ = at;
        if (!is_opening_) wait_->together_at_most(patience_.frameset);
        for (int go = 0; go < 2; ++go) {
            if (!connection_) connect();
            wait_->at_most(patience_.frameset);
            const StopScope in_time(wait_->until());
            if (connection_ && connection_->read_at(at, part_.data(), part_.size())) return 0;
            connection_.reset();
            if (stop_requested()) break;
        }
        part_.clear();
        if (stop_requested()) return EIO;
        failure_ = wait_->is_too_long() ? ETIMEDOUT : EIO;
        return failure_;
    }

    /// Connects again, if the file still has its size.
    void connect() {
        auto made = StreamBytes::connect(url_, wait_, patience_);
        if (made && (*made)->file_size() == size_) connection_ = std::move(*made);
    }

    const StreamUrl url_;
    const StreamSource::Patience patience_;
    const std::uint64_t size_;
    const std::shared_ptr<StreamWait> wait_;
    std::atomic<bool> is_opening_{true};
    std::atomic<int> failure_{0};  // an errno, after which nothing more is read
    std::mutex mutex_;
    std::shared_ptr<StreamBytes> connection_;  // guarded by mutex_, as are the next members
    std::uint64_t at_ = 0;
    std::vector<std::uint8_t> part_;
};

}  // namespace

AVDictionary* http_options(bool is_tls) {
    StreamUrl url;
    url.transport = StreamTransport::http;
    url.is_tls = is_tls;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "protocol_whitelist", url.protocols().c_str(), 0);
    av_dict_set(&options, "max_redirects", "0", 0);
    av_dict_set(&options, "icy", "0", 0);
    av_dict_set(&options, "user_agent", "touchable", 0);
    if (is_tls) av_dict_set(&options, "tls_verify", "1", 0);
    return options;
}

// --- StreamBytes

Result<std::shared_ptr<StreamBytes>> StreamBytes::connect(const StreamUrl& url,
                                                          std::shared_ptr<StreamWait> wait,
                                                          const StreamSource::Patience& patience) {
    silence_ffmpeg();
    wait->at_most(url.is_called() ? patience.caller : patience.connection);
    if (url.transport == StreamTransport::pipe) return open_pipe(url, std::move(wait));
    return wait->in_time([&]() -> Result<std::shared_ptr<StreamBytes>> {
        if (url.transport == StreamTransport::srt) return connect_by_srt(url, wait);
        TRY_ASSIGN(auto io, open_network(url));
        return std::shared_ptr<StreamBytes>(
            std::make_shared<NetworkBytes>(wait, std::move(io), url.transport));
    });
}

Result<std::shared_ptr<StreamBytes>> StreamBytes::of_file(const SourceFile& file) {
    TRY_ASSIGN(auto opened, file.open("must be a stream in MPEG-TS"));
    return std::shared_ptr<StreamBytes>(std::make_shared<FileBytes>(std::move(opened)));
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
    std::int64_t got = AVERROR_EXIT;
    if (const StopScope in_time(wait_->until()); !stop_requested())
        got = some(to, static_cast<std::size_t>(std::min<std::uint64_t>(count, left_)));
    if (got > 0) {
        left_ -= static_cast<std::uint64_t>(got);
        return static_cast<std::size_t>(got);
    }
    if (stop_requested()) return interrupted_error();
    const bool is_silent = wait_->is_too_long();
    if (is_silent && (!ends_in_silence() || wait_->is_together()))
        return input_error("sent no whole frameset in time");
    has_ended_ = true;
    was_lost_ = got < 0;
    how_it_ended_ = is_silent ? "sent no further whole frameset in time"
                    : got < 0 ? "was lost (" + ffmpeg_text(static_cast<int>(got)) + ")"
                              : usual_end();
    return std::size_t{0};
}

// --- open_http

Result<HttpSource> open_http(const StreamUrl& url, const StreamSource::Patience& patience) {
    const auto wait = std::make_shared<StreamWait>();
    wait->together_at_most(patience.opening);
    TRY_ASSIGN(auto connection, error_at(url.name(), StreamBytes::connect(url, wait, patience)));
    const auto size = connection->file_size();
    if (!size) return HttpSource{.stream = std::move(connection)};
    const auto file = std::make_shared<HttpFile>(url, patience, *size, wait, std::move(connection));
    const GivenFile given([file](std::uint64_t at, char* to, std::size_t count,
                                 bool may_wait) { return file->read(at, to, count, may_wait); },
                          *size);
    return HttpSource{.file = SourceFile(std::filesystem::path(url.name()), given),
                      .end_opening = [file] { return file->end_opening(); }};
}

}  // namespace touchable
