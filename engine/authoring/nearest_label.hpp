#pragma once

#include <cstdint>
#include <vector>

namespace touchable {

/// Gives pixels without a label (0) that of the nearest one that has any, by a distance transform.
class NearestLabel {
public:
    /// `labels`: width x height, row by row. Where none has a label all stay as they are.
    void fill(std::vector<std::uint16_t>& labels, int width, int height);

private:
    std::vector<std::int32_t> distances_;  // to the label, a third of a pixel
};

}  // namespace touchable
