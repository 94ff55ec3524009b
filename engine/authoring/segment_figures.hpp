#pragma once

#include "engine/authoring/segmentation.hpp"
#include "engine/base/row_bands.hpp"

namespace touchable {

/// Fills in `segments` from `labels` and the frame they are of.
class SegmentFigures {
public:
    void find(const RawFrame& frame, Segmentation& of, RowBands& bands);

private:
    void find_deviations(const PlaneView& colour, int width, int height, RowBands& bands);
    void list_segments(Segmentation& of);
    void find_means(const PlaneView& colour, Segmentation& of) const;
    void find_middles(Segmentation& of) const;

    std::vector<std::uint16_t> brightness_, deviations_;
    std::vector<std::uint32_t> place_of_;
};

}  // namespace touchable
