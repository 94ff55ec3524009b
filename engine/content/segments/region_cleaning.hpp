#pragma once

#include <cstdint>
#include <vector>

namespace touchable {

/// Gives islands of a few pixels to the region that they touch most: those that have fewer than `smallest`
/// and are not all there is of their region. `regions`: row by row, `none` where there is none.
class RegionCleaning {
public:
    static constexpr std::uint16_t none = 0xFFFF;
    void clean(std::vector<std::uint16_t>& regions, int width, int height, std::int32_t smallest);

private:
    struct Run {
        std::int32_t first, last, row;
        std::uint16_t region;
        std::uint32_t island;
    };
    std::uint32_t island_of(std::uint32_t run);

    std::vector<Run> runs_;
    std::vector<std::uint32_t> row_begins_;
};

}  // namespace touchable
