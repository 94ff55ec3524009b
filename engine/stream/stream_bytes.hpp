#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/stream_figures.hpp"
#include "engine/picture/ffmpeg_input.hpp"
#include "engine/stream/stream_url.hpp"
#include "engine/stream/stream_wait.hpp"

namespace touchable {

/// What may be read of a stream before there is a packet: of its header, and later.
inline constexpr std::uint64_t most_of_a_header = std::uint64_t{2} << 20U,
                               most_of_a_packet = std::uint64_t{256} << 20U;

/// What a sender sends, as it comes: by libsrt, over FFmpeg's protocols, of which it uses those of its
/// address alone, or through a pipe. No read waits longer than its StreamWait. An HTTP server that sends one
/// elsewhere is refused.
class StreamBytes : public ByteFlow {
public:
    /// Connected, within that time; otherwise why not, behind the stream's name.
    static Result<std::shared_ptr<StreamBytes>> connect(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const StreamPatience& patience);

    /// The byte that comes next, which `read` will give; 0 at the end.
    Result<std::uint8_t> peek();
    /// 0 once the sender has ended it, or the connection is lost. Errors go behind the stream's name.
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) final;
    /// So many more bytes may be read from now on; beyond them is an error.
    void allow(std::uint64_t bytes) { left_ = bytes; }
    /// Whether nobody has read of it.
    bool is_unread() const { return left_ == 0 && !has_ended_; }
    /// Of what HTTP has as a file, which can be read anywhere: its size.
    virtual std::optional<std::uint64_t> file_size() const { return std::nullopt; }
    /// Of such a file: all of these bytes, or false.
    virtual bool read_at(std::uint64_t, std::uint8_t*, std::size_t) { return false; }
    /// What is known of the datagrams that carry it; any thread.
    virtual std::optional<LinkFigures> link() const { return std::nullopt; }
    /// How it was read; it waits as this says.
    const std::shared_ptr<StreamWait>& waits() const { return wait_; }
    /// What follows its end.
    bool was_lost() const { return was_lost_; }
    /// Once it has ended: how, such as "closed the connection".
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
