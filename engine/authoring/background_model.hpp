#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/authoring/coded_depth.hpp"
#include "engine/base/row_bands.hpp"

namespace touchable {

using Rgb = std::array<std::uint8_t, 3>;
/// Whether both may be the same thing in the same light.
bool agree(const Rgb& a, const Rgb& b);

/// What is behind at a pixel.
struct BackgroundPixel {
    std::uint16_t code = 0;
    bool is_known = false;
    /// Something nearer was there as well, of the same colour: colour does not tell the two apart.
    bool is_ambiguous = false;
    Rgb colour{};  ///< of the frames in which that depth was seen, their mean
};
using Background = std::vector<BackgroundPixel>;

/// Of each pixel that a camera at rest sees the depths that it had, as a few modes: bounded memory, however
/// many frames there are. Whole numbers only; frames in their order.
class BackgroundModel {
public:
    BackgroundModel(const CodedDepth& depth, int width, int height);
    /// `codes` of CodedDepth::codes_of. Colour, where all frames have it, is of the same size; otherwise
    /// empty.
    void add(const PlaneView& codes, const PlaneView& colour, RowBands& bands);
    /// Of each pixel the deepest of its modes that was seen for long: in 1/16 of the frames, and without
    /// colour in a quarter of them, as then a thing that comes by may look like what is behind. And begins
    /// anew.
    Background finish(bool has_colour);
    /// Forgets what it was given.
    void begin();

private:
    struct Mode {
        std::int32_t mean = 0;                  // 1/256 of a code
        std::uint16_t code = 0;                 // the one that was seen nearest to it
        std::uint16_t count = 0;                // at most 65535; 0: there is none
        std::array<std::uint16_t, 3> colour{};  // mean, sixteenths
    };
    using Modes = std::array<Mode, 3>;

    void add_rows(const PlaneView& codes, const PlaneView& colour, const RowBand& band);
    void see(Modes& modes, std::uint16_t code, const std::uint8_t* rgb) const;
    BackgroundPixel behind(const Modes& modes, std::int32_t least, bool has_colour) const;

    const CodedDepth& depth_;
    int width_;
    std::vector<Modes> pixels_;
    std::int32_t frames_ = 0;
};

}  // namespace touchable
