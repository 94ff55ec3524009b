#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/vector_unit.hpp"
#include "engine/scene/surface_frame.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {

/// One row of decoded pixels as windows of a filter read it: the border is repeated on both sides, on the
/// right to the end of the memory, so that windows need no clamping and vectors no end. Codes of invalid
/// pixels are 0.
class CodeLine {
public:
    /// Windows reach `reach` pixels to each side, at most a strip. No allocation where it had the size.
    void resize(int width, int reach);

    /// Stored values of row `y`, by `coding`.
    void decode(const PlaneView& depth, const DepthCoding& coding, int y, VectorUnit unit);
    /// Row `y` of decoded pixels.
    void copy(const SurfaceFrame& decoded, int y);

    /// From the left end of the window around pixel 0; readable for `strips() + 1` strips.
    const std::uint16_t* codes() const { return codes_.front().pixels; }
    /// All ones where the pixel is invalid, as long as codes.
    const std::uint16_t* invalid() const { return invalid_.front().pixels; }
    /// Invalid pixels as bits, none outside the picture; a word per strip.
    const std::uint32_t* holes() const { return holes_.data(); }
    /// Per strip: whether a window around one of its pixels has an invalid one, as not 0.
    const std::uint32_t* holes_near() const { return holes_near_.data(); }
    int strips() const { return static_cast<int>(holes_.size()); }

    void write_codes(std::uint16_t* codes) const;
    void write_validity(std::uint32_t* validity) const;

private:
    struct alignas(64) Strip {
        std::uint16_t pixels[strip_pixels];
    };
    void load(const PlaneView& depth, const DepthCoding& coding, int y);
    void repeat_border(std::uint16_t* line) const;
    void set_clean();
    void look_near();
    std::uint16_t* inside(std::vector<Strip>& line) { return line.front().pixels + reach_; }

    int width_ = 0, reach_ = 0;
    std::vector<Strip> codes_, invalid_;
    std::vector<std::uint32_t> holes_, holes_near_;
    bool clean_ = false;
};

}  // namespace touchable
