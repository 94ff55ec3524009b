#pragma once

// The bytes of a received stream as they come (StreamBytes: stream_bytes.cpp, and by SRT srt.cpp), and how
// long they are waited for (StreamWait), for what makes pictures and framesets of them (stream_pictures.hpp,
// receiver.hpp).

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/receiving.hpp"

namespace touchable {

/// For how long a stream is waited for: the deadline of the next read, or of several together. One thread at
/// a time.
class StreamWait {
public:
    /// The next wait, which also ends when `together_at_most` does.
    void at_most(std::chrono::milliseconds longest) {
        until_ = std::min(std::chrono::steady_clock::now() + longest, together_until_);
    }
    /// All waits from now on together, until this or `each_alone` is called.
    void together_at_most(std::chrono::milliseconds longest) {
        until_ = together_until_ = std::chrono::steady_clock::now() + longest;
    }
    void each_alone() { together_until_ = StopScope::never; }
    bool is_together() const { return together_until_ != StopScope::never; }
    StopScope::Deadline until() const { return until_; }
    bool is_too_long() const { return std::chrono::steady_clock::now() > until_; }
    /// What `work` returns, a Result, under a StopScope until then. An error is ErrorKind::interrupted
    /// exactly where the thread is asked to stop; of what is late it is ErrorKind::input.
    auto in_time(auto&& work) const -> decltype(work()) {
        auto made = work_until(until_, work);
        if (made) return made;
        if (stop_requested()) return interrupted_error();
        Error why = made.error();
        if (why.kind == ErrorKind::interrupted) why.kind = ErrorKind::input;
        return why;
    }

private:
    StopScope::Deadline until_ = StopScope::never, together_until_ = StopScope::never;
};

struct IoCloser {
    void operator()(AVIOContext* io) const { avio_closep(&io); }
};
using IoPtr = std::unique_ptr<AVIOContext, IoCloser>;

/// FFmpeg's options for a request by HTTP: no protocol but the address's own, and no redirection.
/// The caller frees them.
AVDictionary* http_options(bool is_tls);

/// A sender's bytes as they come: by libsrt, over FFmpeg's protocols, of which it uses those of its address
/// alone, or through a pipe. No read waits longer than its StreamWait. An HTTP server that sends one
/// elsewhere is refused. One thread.
class StreamBytes : public Demuxer::ByteFlow {
public:
    /// Connected, within that time; otherwise why not, without the stream's name.
    static Result<std::shared_ptr<StreamBytes>> connect(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const StreamSource::Patience& patience);

    /// The byte that comes next, which `read` will give; 0 at the end.
    Result<std::uint8_t> peek();
    /// 0 once the sender has ended it, or the connection is lost. Errors are without the stream's name.
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) final;
    /// Allows this many more bytes to be read from now on; reading beyond them is an error.
    void allow(std::uint64_t bytes) { left_ = bytes; }
    /// Whether nothing was read of it.
    bool is_unread() const { return left_ == 0 && !has_ended_; }
    /// The size of what HTTP has as a file, which can be read anywhere.
    virtual std::optional<std::uint64_t> file_size() const { return std::nullopt; }
    /// Reads all of these bytes of such a file, or returns false.
    virtual bool read_at(std::uint64_t, std::uint8_t*, std::size_t) { return false; }
    /// Figures of the datagrams that carry it; any thread.
    virtual std::optional<StreamFigures::Link> link() const { return std::nullopt; }
    /// The wait that ends its reads.
    const std::shared_ptr<StreamWait>& waits() const { return wait_; }
    /// Once it has ended: whether the connection was lost, and how it ended, such as "closed the connection".
    bool was_lost() const { return was_lost_; }
    const std::string& how_it_ended() const { return how_it_ended_; }

protected:
    explicit StreamBytes(std::shared_ptr<StreamWait> wait) : wait_(std::move(wait)) {}
    /// As `read`, or FFmpeg's error number.
    virtual std::int64_t some(std::uint8_t* to, std::size_t count) = 0;

private:
    const std::shared_ptr<StreamWait> wait_;
    std::uint64_t left_ = 0;
    std::optional<std::uint8_t> peeked_;
    bool has_ended_ = false, was_lost_ = false;
    std::string how_it_ended_;
};

}  // namespace touchable
