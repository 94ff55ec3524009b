// SPDX-License-Identifier: Apache-2.0
#pragma once

// Programs that send framesets (docs/streaming.md): depth and colour of one moment, with a header that says
// what they mean, by a pipe or a connection.
//
// open_frameset_camera opens a FramesetChoice as a live clip. FramesetParser finds framesets in bytes of any
// origin. Each object is used by one thread.

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

/// The header of a frameset (docs/streaming.md has its bytes).
struct FramesetHeader {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0;  ///< of the sender's clock; 0: not stated
    int width = 0, height = 0;
    double metres_per_unit = 0;               ///< of a depth of 1
    double fx = 0, fy = 0, cx = 0, cy = 0;    ///< of the depth picture, pixels
    int colour_width = 0, colour_height = 0;  ///< 0: there is no colour
    bool colour_is_registered = false;        ///< seen from where depth is seen from, by the same lens

    bool has_colour() const { return colour_width > 0; }
    std::size_t depth_bytes() const { return 2 * pixel_count(width, height); }
    /// Bytes of depth and colour.
    std::size_t payload_bytes() const { return depth_bytes() + 3 * pixel_count(colour_width, colour_height); }
    /// All but number and time.
    bool means_the_same_as(FramesetHeader other) const {
        other.number = number;
        other.time_ns = time_ns;
        return *this == other;
    }
    bool operator==(const FramesetHeader&) const = default;
};

inline constexpr std::size_t frameset_header_bytes = 100;
/// Limit for the depth picture, and for the colour picture.
inline constexpr std::size_t most_frameset_pixels = std::size_t{1} << 24U;

/// A whole frameset.
struct Frameset {
    FramesetHeader header;
    std::shared_ptr<std::vector<std::uint8_t>> payload;  ///< depth in host order, then colour

    /// 1 channel, 16 bits; 0 is no depth.
    PlaneView depth() const { return packed_plane(payload->data(), header.width, header.height, 2, 1); }
    PlaneView colour() const;  ///< RGB of 8 bits; without colour none
};

/// Finds the framesets in a stream of bytes, from anywhere in it: damage is skipped up to the next whole one.
/// It holds the bytes since the last whole one, at most one frameset and one `take`; and checks at most a few
/// times as many bytes as came.
class FramesetParser {
public:
    void take(std::span<const std::uint8_t> bytes);
    /// The next whole frameset; nullopt: more bytes are needed. An error is final: the sender gives no
    /// framesets, or others than before.
    Result<std::optional<Frameset>> next();
    /// Number of framesets that were damaged or cut short, as far as they can be told apart.
    std::int64_t damaged() const { return damaged_; }
    /// Number of framesets with the same number as the one before.
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
    /// Limits the work on bytes that claim again and again that a frameset begins. False: the limit is
    /// reached; waiting bytes are skipped.
    bool may_check(std::size_t count) {
        if (count <= credit_) {
            credit_ -= count;
            return true;
        }
        pass_over(rest().size());
        return false;
    }

    std::vector<std::uint8_t> bytes_;
    std::size_t begin_ = 0;  // first unused byte
    std::optional<FramesetHeader> first_;
    std::uint64_t last_number_ = 0;
    std::size_t strays_ = 0;  // bytes skipped since the last whole one
    std::size_t credit_ = 0;  // bytes that may be checked
    bool is_lost_ = true;     // skipped bytes are damage already counted, or a beginning
    std::int64_t damaged_ = 0, repeated_ = 0;
};

/// A program that sends framesets (above): a command that is started, or one that listens.
struct FramesetChoice {
    std::string command{};  ///< of /bin/sh; empty: `address`
    std::string address{};  ///< as check_address takes it
    /// Timeouts before a run: for the first byte, and then for each frameset.
    std::chrono::milliseconds first_patience{30'000}, patience{10'000};

    std::string name() const { return command.empty() ? "tcp://" + address : "pipe:" + command; }
};

/// Checks that an address is "HOST:PORT" with a numeric HOST or localhost ("127.0.0.1:7000", "[::1]:7000");
/// the error (usage) says what would be right.
Result<void> check_address(const std::string& address);

/// Opens a sender as a live source, like `open_v4l2_camera`, with the sender's unit and lens unless `known`
/// or `scene_file` state them. A JitterBuffer without delay times frames, and believes in transit times of
/// 0.1 s at most. The command ends with the reader.
Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const SourceDescription& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

}  // namespace touchable
