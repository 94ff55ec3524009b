#include "engine/authoring/region_cleaning.hpp"

#include <algorithm>
#include <utility>

namespace touchable {

/// `Run::island` leads to the first run of its island.
std::uint32_t RegionCleaning::island_of(std::uint32_t run) {
    while (runs_[run].island != run) {
        runs_[run].island = runs_[runs_[run].island].island;
        run = runs_[run].island;
    }
    return run;
}

/// Of one region, row by row.
void RegionCleaning::find_runs(const std::vector<std::uint16_t>& regions, int width, int height) {
    runs_.clear();
    row_begins_.clear();
    for (int y = 0; y < height; ++y) {
        row_begins_.push_back(static_cast<std::uint32_t>(runs_.size()));
        const std::uint16_t* row = &regions[static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
        for (int x = 0, first = 0; x < width; ++x)
            if (x + 1 == width || row[x + 1] != row[x]) {
                const auto island = static_cast<std::uint32_t>(runs_.size());
                runs_.push_back({first, x, y, row[x], island});
                first = x + 1;
            }
    }
    row_begins_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

/// Calls `touch(run above, run below, pixels)` where two of them meet.
template <class Touch>
void RegionCleaning::for_each_contact(Touch&& touch) const {
    for (std::size_t y = 1; y + 1 < row_begins_.size(); ++y)
        for (std::uint32_t above = row_begins_[y - 1], below = row_begins_[y];
             above < row_begins_[y] && below < row_begins_[y + 1];) {
            const Run &a = runs_[above], &b = runs_[below];
            const std::int32_t pixels = std::min(a.last, b.last) - std::max(a.first, b.first) + 1;
            if (pixels > 0) touch(above, below, pixels);
            const bool above_ends = a.last <= b.last, below_ends = b.last <= a.last;
            above += above_ends ? 1 : 0;
            below += below_ends ? 1 : 0;
        }
}

void RegionCleaning::find_islands() {
    for_each_contact([&](std::uint32_t above, std::uint32_t below, std::int32_t) {
        if (runs_[above].region != runs_[below].region) return;
        const std::uint32_t a = island_of(above), b = island_of(below);
        runs_[std::max(a, b)].island = std::min(a, b);
    });
}

RegionCleaning::Contacts RegionCleaning::contacts_of_small(std::int32_t smallest) {
    std::vector<std::int32_t> island_pixels(runs_.size()), of_region(std::size_t{none} + 1);
    for (std::uint32_t k = 0; k < runs_.size(); ++k) {
        const std::int32_t pixels = runs_[k].last - runs_[k].first + 1;
        island_pixels[island_of(k)] += pixels;
        of_region[runs_[k].region] += pixels;
    }
    const auto is_small = [&](std::uint32_t island) {
        const std::uint16_t region = runs_[island].region;
        return region != none && island_pixels[island] < smallest &&
               island_pixels[island] < of_region[region];
    };
    Contacts contacts;
    const auto touch = [&](std::uint32_t a, std::uint32_t b, std::int32_t pixels) {
        a = island_of(a);
        b = island_of(b);
        if (a == b) return;
        for (const auto& [small, other] : {std::pair{a, b}, {b, a}})
            if (is_small(small) && !is_small(other) && runs_[other].region != none)
                contacts[small][runs_[other].region] += pixels;
    };
    for_each_contact(touch);
    for (std::uint32_t k = 1; k < runs_.size(); ++k)
        if (runs_[k].row == runs_[k - 1].row) touch(k - 1, k, 1);
    return contacts;
}

void RegionCleaning::clean(std::vector<std::uint16_t>& regions, int width, int height,
                           std::int32_t smallest) {
    find_runs(regions, width, height);
    find_islands();
    const Contacts contacts = contacts_of_small(smallest);
    for (std::uint32_t k = 0; k < runs_.size(); ++k) {
        const auto found = contacts.find(island_of(k));
        if (found == contacts.end()) continue;
        std::uint16_t best = none;
        std::int32_t most = 0;
        for (const auto& [region, pixels] : found->second)
            if (pixels > most) most = pixels, best = region;
        std::uint16_t* row =
            &regions[static_cast<std::size_t>(runs_[k].row) * static_cast<std::size_t>(width)];
        std::fill(row + runs_[k].first, row + runs_[k].last + 1, best);
    }
}

}  // namespace touchable
