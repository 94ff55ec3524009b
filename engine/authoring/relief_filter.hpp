#pragma once

#include <array>

#include "engine/authoring/difference_of_gaussians.hpp"
#include "engine/scene/depth_coding.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// What of a picture's details becomes relief.
struct ReliefSettings {
    std::array<int, DifferenceOfGaussians::bands> bands{
        100, 70, 40};     ///< per cent of fine, medium, coarse; -400 to 400
    int amount = 100;     ///< per cent of the largest height, 0 to 400
    bool invert = false;  ///< dark stands out, not bright
    bool operator==(const ReliefSettings&) const = default;
};

/// The relief that the colour of a frame suggests, before it is scaled: what is brighter than around it
/// stands out. There is none across a step of depth, where depth is missing, in deep shadow and in
/// highlights.
class ReliefFilter {
public:
    ReliefFilter(const ReliefSettings& settings, const DepthCoding& depth)
        : settings_(settings), depth_(depth) {}

    /// `frame` has colour. Numbers are sixteenths of a level of brightness; about -4096 to 4096 for bands of
    /// 100 %.
    const NumberField& apply(const RawFrame& frame);
    /// Of each pixel of the last frame, how much its relief counts: 0 to DifferenceOfGaussians::most_weight.
    const NumberField& confidence() const { return split_.confidence(); }

private:
    void read_luma(const PlaneView& colour);
    void part_surfaces(const RawFrame& frame);

    const ReliefSettings settings_;
    const DepthCoding depth_;
    DifferenceOfGaussians split_;
    NumberField luma_, weights_, relief_;
    SurfaceRuns runs_;
};

}  // namespace touchable
