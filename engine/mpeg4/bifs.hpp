// SPDX-License-Identifier: Apache-2.0
#pragma once

// BIFS: the binary form of an MPEG-4 scene (ISO/IEC 14496-11), bit by bit, for the nodes that node_types.hpp
// knows.
//
// encode_scene writes a tree as one access unit, which MP4Box and this decoder read, with a BifsConfig that
// says how many bits its numbers take: config_for finds the least, encode_config writes it into a file's
// description of the stream. decode_config and decode_scene are the inverse; they refuse parts whose length
// they cannot know. Nesting, counts and lengths are limited, because the bits come from outside.
//
// BitReader and BitWriter are streams of bits, the highest first, also for other formats; each is used by one
// thread. The functions keep no state, for any thread.

#include <cstdint>
#include <span>

#include "engine/base/result.hpp"
#include "engine/mpeg4/node_types.hpp"

namespace touchable::mpeg4 {

/// The fewest bits that hold this number.
constexpr int bits_for(std::uint64_t value) {
    int bits = 0;
    while (bits < 64 && value >> bits != 0) ++bits;
    return bits;
}

/// Writes numbers one after the other, each in so many bits, the highest first.
class BitWriter {
public:
    void put(std::uint64_t value, int bits) {
        for (int k = bits - 1; k >= 0; --k) {
            if (used_ % 8 == 0) bytes_.push_back(0);
            bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | ((value >> k & 1) << (7 - used_ % 8)));
            ++used_;
        }
    }
    /// The bits, filled up with zeros to a whole byte.
    std::vector<std::uint8_t> take() { return std::move(bytes_); }

private:
    std::vector<std::uint8_t> bytes_;
    std::size_t used_ = 0;
};

/// Reads what BitWriter wrote. Beyond the end it returns zeros, and `is_over` is true.
class BitReader {
public:
    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    std::uint64_t get(int bits) {
        std::uint64_t value = 0;
        for (int k = 0; k < bits; ++k, ++at_) {
            const std::size_t byte = at_ / 8;
            const bool bit = byte < bytes_.size() && (bytes_[byte] >> (7 - at_ % 8) & 1) != 0;
            value = value << 1 | (bit ? 1 : 0);
        }
        return value;
    }
    bool flag() { return get(1) != 0; }
    /// Exp-Golomb: as many bits follow as zeros came, 32 at most.
    std::uint64_t golomb() {
        int zeros = 0;
        while (zeros < 32 && !flag()) ++zeros;
        return (std::uint64_t{1} << zeros) - 1 + get(zeros);
    }
    std::size_t position() const { return at_; }
    std::size_t left() const { return is_over() ? 0 : 8 * bytes_.size() - at_; }
    bool is_over() const { return at_ > 8 * bytes_.size(); }

private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;  // the next bit
};

/// Parameters for reading a BIFS stream, stated before it (BIFSConfig, BIFSv2Config).
struct BifsConfig {
    int version = 2;  ///< 1 has no prototypes
    int node_id_bits = 1, route_id_bits = 0, prototype_id_bits = 0;
    int width = 0, height = 0;  ///< of the picture, pixels; 0: not stated
    /// MPEG-4's number of such a stream (objectTypeIndication).
    std::uint8_t object_type() const { return version == 1 ? 1 : 2; }
};
/// The smallest configuration for this scene.
BifsConfig config_for(const SceneTree& scene, int width, int height);
std::vector<std::uint8_t> encode_config(const BifsConfig& config);
/// `object_type`: 1 or 2.
Result<BifsConfig> decode_config(std::span<const std::uint8_t> bytes, int object_type);

/// Writes a scene as one access unit that begins it anew (SceneReplace), with the names of nodes, prototypes
/// and fields. An error if a node has no binary form, such as the paper's own, or none in its place.
Result<std::vector<std::uint8_t>> encode_scene(const SceneTree& scene, const BifsConfig& config);
/// Ignores bytes after the scene. Errors name the bit at which they occurred.
Result<SceneTree> decode_scene(std::span<const std::uint8_t> bytes, const BifsConfig& config);

}  // namespace touchable::mpeg4
