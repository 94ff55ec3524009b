// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bytes of a received stream (StreamBytes: stream_bytes.cpp; SRT: srt.cpp), and the deadlines of its
// reads (StreamWait), for the code that makes pictures and framesets of them (stream_pictures.hpp,
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

/// The deadline of the next read of a stream, or of several together. Used by one thread at a time.
class StreamWait {
public:
    /// Limits the next wait, which also ends at the deadline of `together_at_most`.
    void at_most(std::chrono::milliseconds longest) {
        until_ = std::min(std::chrono::steady_clock::now() + longest, together_until_);
    }
    /// Limits all waits from now on together, until this or `each_alone` is called.
    void together_at_most(std::chrono::milliseconds longest) {
        until_ = together_until_ = std::chrono::steady_clock::now() + longest;
    }
    void each_alone() { together_until_ = StopScope::never; }
    bool is_together() const { return together_until_ != StopScope::never; }
    StopScope::Deadline until() const { return until_; }
    bool is_too_long() const { return std::chrono::steady_clock::now() > until_; }
    /// The Result of `work`, which runs under a StopScope until the deadline. An error is
    /// ErrorKind::interrupted exactly if a stop of the thread was requested; lateness is ErrorKind::input.
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

/// FFmpeg's options for a request by HTTP: only the address's own protocol, and no redirection. The caller
/// frees them.
AVDictionary* http_options(bool is_tls);

/// A sender's bytes as they come: by libsrt, through a pipe, or over FFmpeg's protocols, limited to those of
/// its address. No read waits longer than its StreamWait. HTTP redirections are refused. Used by one thread.
class StreamBytes : public Demuxer::ByteFlow {
public:
    /// Connects within the time of `wait`; an error gives the reason, without the stream's name.
    static Result<std::shared_ptr<StreamBytes>> connect(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const StreamSource::Patience& patience);
    /// The bytes of a file, from its first on.
    static Result<std::shared_ptr<StreamBytes>> of_file(const SourceFile& file);

    /// The next byte, without taking it; 0 at the end.
    Result<std::uint8_t> peek();
    /// 0 after the sender's end, a lost connection, or UDP's silence. Errors are without the stream's name.
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) final;
    /// Allows this many more bytes to be read from now on; reading beyond them is an error.
    void allow(std::uint64_t bytes) { left_ = bytes; }
    /// Whether nothing was read yet.
    bool is_unread() const { return left_ == 0 && !has_ended_; }
    /// Size of a file over HTTP, which can be read anywhere; nothing: it is a stream.
    virtual std::optional<std::uint64_t> file_size() const { return std::nullopt; }
    /// Reads all of these bytes of such a file, or returns false.
    virtual bool read_at(std::uint64_t, std::uint8_t*, std::size_t) { return false; }
    /// Figures of the datagrams that carry it; any thread.
    virtual std::optional<StreamFigures::Link> link() const { return std::nullopt; }
    /// The wait that limits its reads.
    const std::shared_ptr<StreamWait>& waits() const { return wait_; }
    /// After its end: whether the connection was lost, and how it ended, such as "closed the connection".
    bool was_lost() const { return was_lost_; }
    const std::string& how_it_ended() const { return how_it_ended_; }

protected:
    explicit StreamBytes(std::shared_ptr<StreamWait> wait) : wait_(std::move(wait)) {}
    /// Like `read`, or FFmpeg's error number.
    virtual std::int64_t some(std::uint8_t* to, std::size_t count) = 0;
    /// Whether the transport tells of no end, so that a sender that falls silent after the first frameset
    /// has ended.
    virtual bool ends_in_silence() const { return false; }
    /// How it ends if it is not lost.
    virtual const char* usual_end() const { return "closed the connection"; }

private:
    const std::shared_ptr<StreamWait> wait_;
    std::uint64_t left_ = 0;
    std::optional<std::uint8_t> peeked_;
    bool has_ended_ = false, was_lost_ = false;
    std::string how_it_ended_;
};

}  // namespace touchable
