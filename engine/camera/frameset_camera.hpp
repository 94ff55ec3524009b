#pragma once

// Programs that send framesets (docs/streaming.md): depth and colour of one moment, with a header that says
// what they mean, by a pipe or a connection.
//
// open_frameset_camera gives what a FramesetChoice names as a live clip. FramesetParser finds framesets in
// any bytes, and knows nothing of where they come from. Each object is used by one thread.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// What a frameset says of itself (docs/streaming.md has its bytes).
struct FramesetHeader {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0;  ///< of the sender's clock; 0: it does not say
    int width = 0, height = 0;
    double metres_per_unit = 0;               ///< of a depth of 1
    double fx = 0, fy = 0, cx = 0, cy = 0;    ///< of the depth picture, pixels
    int colour_width = 0, colour_height = 0;  ///< 0: there is no colour
    bool colour_is_registered = false;        ///< seen from where depth is seen from, by the same lens

    bool has_colour() const { return colour_width > 0; }
    std::size_t depth_bytes() const {
        return std::size_t{2} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    /// Of depth and colour.
    std::size_t payload_bytes() const {
        return depth_bytes() + std::size_t{3} * static_cast<std::size_t>(colour_width) *
                                   static_cast<std::size_t>(colour_height);
    }
    /// All but number and time.
    bool means_the_same_as(const FramesetHeader& other) const {
        return width == other.width && height == other.height && metres_per_unit == other.metres_per_unit &&
               fx == other.fx && fy == other.fy && cx == other.cx && cy == other.cy &&
               colour_width == other.colour_width && colour_height == other.colour_height &&
               colour_is_registered == other.colour_is_registered;
    }
};

inline constexpr std::size_t frameset_header_bytes = 100;
/// Of a depth picture, and of one of colour.
inline constexpr std::size_t most_frameset_pixels = std::size_t{1} << 24U;

/// A whole one.
struct Frameset {
    FramesetHeader header;
    std::shared_ptr<std::vector<std::uint8_t>> payload;  ///< depth in host order, then colour

    /// 1 channel, 16 bits; 0 is no depth.
    PlaneView depth() const {
        return {payload->data(),
                2 * static_cast<std::ptrdiff_t>(header.width),
                header.width,
                header.height,
                2,
                1};
    }
    PlaneView colour() const;  ///< RGB of 8 bits; without colour none
};

/// Finds the framesets in a stream of bytes, from anywhere in it: what is damaged is passed over up to the
/// next one that is whole. It holds what it was given since the last whole one, at most one frameset and what
/// `take` was given at once; and works at most for a few times as many bytes as came.
class FramesetParser {
public:
    void take(std::span<const std::uint8_t> bytes);
    /// The next whole one; nothing: more bytes are needed. An error, for good: what the sender gives is none,
    /// or another than before.
    Result<std::optional<Frameset>> next();
    /// Framesets that were damaged or cut short, as far as they can be told from each other.
    std::int64_t damaged() const { return damaged_; }
    /// That came again, by their number, one after the other.
    std::int64_t repeated() const { return repeated_; }

private:
    std::span<const std::uint8_t> rest() const { return std::span(bytes_).subspan(begin_); }
    bool find_header();
    void pass_over(std::size_t count) {
        begin_ += count;
        strays_ += count;
        if (count > 0 && !is_lost_) ++damaged_;
        is_lost_ = is_lost_ || count > 0;
    }
    /// False: bytes that say again and again that a frameset begins here, and none does, would keep this
    /// busy. What waits is passed over.
    bool may_check(std::size_t count) {
        if (count <= credit_) {
            credit_ -= count;
            return true;
        }
        pass_over(rest().size());
        return false;
    }

    std::vector<std::uint8_t> bytes_;
    std::size_t begin_ = 0;  // of what is not used yet
    std::optional<FramesetHeader> first_;
    std::uint64_t last_number_ = 0;
    std::size_t strays_ = 0;  // bytes passed over since the last whole one
    std::size_t credit_ = 0;  // bytes that may be checked
    bool is_lost_ = true;     // what is passed over is damage that was counted, or a beginning
    std::int64_t damaged_ = 0, repeated_ = 0;
};

/// A program that sends framesets (above): a command that is started, or one that listens.
struct FramesetChoice {
    std::string command{};  ///< of /bin/sh; empty: `address`
    std::string address{};  ///< as check_address takes it
    /// Before a run: for the first byte, and from then on for each frameset.
    std::chrono::milliseconds first_patience{30'000}, patience{10'000};

    std::string name() const { return command.empty() ? "tcp://" + address : "pipe:" + command; }
};

/// Whether an address is "HOST:PORT", of which HOST is an address in numbers or localhost ("127.0.0.1:7000",
/// "[::1]:7000"); an error (usage) says what would be right.
Result<void> check_address(const std::string& address);

/// What it sends as a live source, as `open_v4l2_camera` gives a camera's, but that the sender says its unit
/// and its lens, where `known` or `scene_file` do not. Frames are timed by a JitterBuffer that believes in a
/// way of 0.1 s, and waits for none. The command ends with the reader.
Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const std::optional<SourceDescription>& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

}  // namespace touchable
