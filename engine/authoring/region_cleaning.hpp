#pragma once

#include <cstdint>
#include <map>
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
    /// Pixels along which a small island touches each region; by its first run.
    using Contacts = std::map<std::uint32_t, std::map<std::uint16_t, std::int32_t>>;

    void find_runs(const std::vector<std::uint16_t>& regions, int width, int height);
    template <class Touch>
    void for_each_contact(Touch&& touch) const;
    std::uint32_t island_of(std::uint32_t run);
    void find_islands();
    Contacts contacts_of_small(std::int32_t smallest);

    std::vector<Run> runs_;
    std::vector<std::uint32_t> row_begins_;
};

}  // namespace touchable
