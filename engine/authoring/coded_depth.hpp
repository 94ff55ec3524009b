#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/scene/depth_coding.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// What the codes of a clip's depth mean to whoever compares them, by tables.
class CodedDepth {
public:
    explicit CodedDepth(const DepthCoding& coding);
    const DepthCoding& coding() const { return coding_; }
    bool is_valid(std::uint16_t code) const { return tolerance_[code] != 0; }
    /// By how many codes two measurements of one surface may differ: 1/64 of the depth, at least 2; 0 of
    /// codes that are invalid.
    std::int32_t tolerance(std::uint16_t code) const { return tolerance_[code]; }
    /// By how many codes `code` is deeper than `than`.
    std::int32_t deeper_by(std::uint16_t code, std::uint16_t than) const {
        return deeper_is_higher_ ? code - than : than - code;
    }

    /// The depth of a frame as a plane of codes, 1 channel; of hue it is made in `codes`.
    PlaneView codes_of(const RawFrame& frame, std::vector<std::uint16_t>& codes) const;
    /// So that `put` has a pixel for each hue that was seen. `codes`: of that frame.
    void remember(const RawFrame& frame, const PlaneView& codes);
    /// Writes a code that was seen into pixel x, of the row of a depth plane.
    void put(std::uint16_t code, std::uint8_t* row, int x, int bytes_per_sample) const;

private:
    DepthCoding coding_;
    bool deeper_is_higher_;
    std::vector<std::int32_t> tolerance_;              // of each code
    std::vector<std::array<std::uint8_t, 3>> hue_of_;  // likewise, of hue: the first pixel that had it
    std::vector<bool> is_known_;                       // whether a pixel had it
};

}  // namespace touchable
