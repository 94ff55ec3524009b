// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/regions.hpp"

#include <cstdlib>

namespace touchable {

namespace {

/// Neighbours that differ by this much are two surfaces.
constexpr std::int64_t apart = 1024;
/// If more regions than this touch others, the least different ones are merged.
constexpr std::ptrdiff_t most_regions = 40;
/// Each of these alone equals `apart`: 16 levels of colour; a step of 1.5 % of the depth; a concave crease of
/// 20 degrees, where one thing stands on another, or a convex one of 100, since a box's edge is the same
/// thing on both sides. Creases are chords in 1024ths of a unit normal.
constexpr std::int64_t colour_apart = 64 * 64, step_apart = 90, concave_apart = 356, convex_apart = 1600;
/// Squared differences of brightness, which come mostly from light, are divided by this.
constexpr std::int64_t shading_share = 8;
/// Limits on a border's piece, however much it differs, so that its length decides.
constexpr std::int64_t most_times = 16, most_step = 4 * step_apart;
/// A region of this many times the smallest has to differ twice as much, in squares, as a large one.
constexpr std::int64_t small_times = 3;
/// The difference of regions that were one in the last frame is divided by this, that of regions that were
/// two is multiplied by it.
constexpr std::int64_t hysteresis = 3;

/// Greatest distance in cells of superpixels that may be neighbours: a pixel's superpixel is at most a cell
/// away, and a hole of two cells may lie between.
constexpr int reach = 5, reach_side = 2 * reach + 1, reach_slots = (reach + 1) * reach_side;
constexpr int widest_gap = 2;

/// Fixed point: 2^14 to a unit of rays, 2^10 to one of normals.
constexpr int ray_unit = 1 << 14, normal_unit = 1 << 10;

/// Square root, rounded down.
std::int64_t whole_root(std::int64_t number) {
    std::int64_t root = 0;
    for (std::int64_t bit = std::int64_t{1} << 30; bit > 0; bit >>= 1)
        if ((root + bit) * (root + bit) <= number) root += bit;
    return root;
}

/// Clamps rays and focal lengths beyond any camera's, so that products stay within 63 bits.
std::int64_t fixed(double number, int unit) {
    constexpr double most = 1 << 20;
    return static_cast<std::int64_t>(std::clamp(number * unit, -most, most));
}

std::int64_t colour_difference(std::int64_t brightness, std::int64_t red_green, std::int64_t yellow_blue) {
    return squared(brightness) / shading_share + squared(red_green) + squared(yellow_blue);
}

}  // namespace

void RegionMerging::find_borders(const Superpixels& superpixels) {
    const int columns = superpixels.columns(), gap = widest_gap * superpixels.side();
    const std::vector<std::uint16_t>& of_pixels = superpixels.of_pixels();
    table_.assign(superpixels.all().size() * reach_slots, Border{});
    const auto meet = [&](std::uint16_t a, std::uint16_t b, int x, int y) {
        if (a > b) std::swap(a, b);
        const int rows_on = b / columns - a / columns, columns_on = b % columns - a % columns;
        if (rows_on > reach || std::abs(columns_on) > reach) return;
        Border& border = table_[static_cast<std::size_t>(a) * reach_slots +
                                static_cast<std::size_t>(rows_on * reach_side + columns_on + reach)];
        ++border.length;
        border.x += x;
        border.y += y;
    };
    const int width = superpixels.width(), height = superpixels.height();
    const std::size_t step = static_cast<std::size_t>(width);
    std::vector<int> newest(step, -1);  // by column: the row of the last surface
    for (int y = 0; y < height; ++y) {
        const std::uint16_t* row = &of_pixels[static_cast<std::size_t>(y) * step];
        int newest_x = -1;
        for (int x = 0; x < width; ++x) {
            const std::uint16_t here = row[x];
            if (here == Superpixels::none) continue;
            if (newest_x >= 0 && row[newest_x] != here && x - newest_x <= gap)
                meet(row[newest_x], here, (newest_x + x) / 2, y);
            newest_x = x;
            int& above = newest[static_cast<std::size_t>(x)];
            if (above >= 0 && y - above <= gap) {
                const std::uint16_t there =
                    of_pixels[static_cast<std::size_t>(above) * step + static_cast<std::size_t>(x)];
                if (there != here) meet(there, here, x, (above + y) / 2);
            }
            above = y;
        }
    }
}

/// With g and h the slopes of log depth by the ray's u and v, the normal is along (g, h, -(1 + g u + h v)).
void RegionMerging::find_normals(const Superpixels& superpixels) {
    const std::vector<Superpixel>& all = superpixels.all();
    // Per pixel and octave / (256 PixelFeatures::depth_per_octave), in normal_unit.
    const double unit = 0.6931471805599453 / (256.0 * PixelFeatures::depth_per_octave) * normal_unit;
    const std::int64_t per_x = fixed(camera_.fx * unit, 1 << 16), per_y = fixed(camera_.fy * unit, 1 << 16);
    normals_.assign(all.size(), {});
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Superpixel& one = all[k];
        if (one.pixels == 0) continue;
        Normal& normal = normals_[k];
        normal.point_x = fixed(camera_.u(one.x), ray_unit);
        normal.point_y = fixed(-camera_.v(one.y), ray_unit);
        const std::int64_t g = (one.slope_x * per_x) >> 16, h = (one.slope_y * per_y) >> 16;
        const std::int64_t z = -(normal_unit + ((g * normal.point_x + h * normal.point_y) >> 14));
        const std::int64_t length = std::max<std::int64_t>(1, whole_root(g * g + h * h + z * z));
        normal.x = g * normal_unit / length;
        normal.y = h * normal_unit / length;
        normal.z = z * normal_unit / length;
        // Four times the variance of a slope, as noise of depth is correlated between neighbouring pixels.
        const std::int64_t per_slope = squared((256 * std::max(per_x, per_y)) >> 16);
        const std::int64_t pixels = std::int64_t{one.pixels} * one.spread;
        // Plus one code from end to end, which may be rounding and no slope.
        const std::int64_t coarse =
            squared(256 * std::max(per_x, per_y) / 65536 * one.quantum / superpixels.side());
        normal.doubt = std::min<std::int64_t>(4 * normal_unit * normal_unit,
                                              4 * per_slope * one.noise / pixels + coarse);
    }
}

void RegionMerging::measure(const std::vector<Superpixel>& all, std::size_t a, std::size_t b,
                            Border& border) const {
    const Superpixel &one = all[a], &other = all[b];
    const auto x = static_cast<std::int32_t>(border.x / border.length),
               y = static_cast<std::int32_t>(border.y / border.length);
    border.colour = border.length * std::min(most_times * colour_apart,
                                             colour_difference(one.brightness - other.brightness,
                                                               one.red_green - other.red_green,
                                                               one.yellow_blue - other.yellow_blue));
    // Each plane may be off by half a code.
    const std::int64_t step = one.depth_at(x, y) - other.depth_at(x, y),
                       sure = std::max<std::int64_t>(
                           0, std::abs(step) - std::max(one.quantum, other.quantum) / 2);
    border.step = border.length * std::min(sure, most_step) * (step < 0 ? -1 : 1);
    const Normal &n = normals_[a], &m = normals_[b];
    const std::int64_t crease = whole_root(std::max<std::int64_t>(
        0, squared(n.x - m.x) + squared(n.y - m.y) + squared(n.z - m.z) - n.doubt - m.doubt));
    // From the other's point to this one's, whose depths are about alike.
    const std::int64_t nearer = (one.depth - other.depth) * std::int64_t{ray_unit} * 710 / (1 << 22);
    const std::int64_t along_x = n.point_x - m.point_x + ((nearer * n.point_x) >> 14),
                       along_y = n.point_y - m.point_y + ((nearer * n.point_y) >> 14);
    const bool is_convex = along_x * (n.x - m.x) + along_y * (n.y - m.y) + nearer * (n.z - m.z) > 0;
    border.crease = border.length * (is_convex ? -crease : crease);
}

/// How much regions differ by their border and their mean colours; reduced for small ones.
std::int64_t RegionMerging::difference(std::size_t a, std::size_t b, const Border& border) const {
    const Region &one = regions_[a], &other = regions_[b];
    const auto apart_by = [&](std::int64_t Region::*sum) {
        return one.*sum / one.pixels - other.*sum / other.pixels;
    };
    const std::int64_t colour = colour_difference(apart_by(&Region::brightness), apart_by(&Region::red_green),
                                                  apart_by(&Region::yellow_blue));
    const std::int64_t crease = border.crease / border.length;
    std::int64_t sum = apart * (colour + border.colour / border.length) / (2 * colour_apart) +
                       apart * squared(border.step / border.length) / squared(step_apart) +
                       apart * squared(crease) / squared(crease > 0 ? concave_apart : convex_apart);
    const std::int64_t smaller = std::min(one.pixels, other.pixels);
    sum = sum * smaller / (smaller + small_times * smallest_);
    if (one.label != 0 && other.label != 0)
        sum = one.label == other.label ? sum / hysteresis : sum * hysteresis;
    return sum;
}

void RegionMerging::offer(std::size_t region) {
    const Region& one = regions_[region];
    for (const auto& [other, border] : one.borders) {
        const auto a = static_cast<std::uint16_t>(std::min<std::size_t>(region, other)),
                   b = static_cast<std::uint16_t>(std::max<std::size_t>(region, other));
        queue_.push_back({difference(a, b, border), a, b, regions_[a].version, regions_[b].version});
        std::push_heap(queue_.begin(), queue_.end());
    }
}

void RegionMerging::join(std::size_t into, std::size_t from) {
    Region &one = regions_[into], &gone = regions_[from];
    if (gone.pixels > one.pixels || one.label == 0) one.label = gone.label != 0 ? gone.label : one.label;
    one.pixels += gone.pixels;
    one.brightness += gone.brightness;
    one.red_green += gone.red_green;
    one.yellow_blue += gone.yellow_blue;
    const auto place_of = [](auto& borders, std::size_t region) {
        return std::ranges::lower_bound(borders, region, {}, [](const auto& border) { return border.first; });
    };
    one.borders.erase(place_of(one.borders, from));
    for (const auto& [other, border] : gone.borders) {
        if (other == into) continue;
        auto& theirs = regions_[other].borders;
        theirs.erase(place_of(theirs, from));
        for (const auto& [whose, whom] : {std::pair{&one.borders, std::size_t{other}}, {&theirs, into}}) {
            auto at = place_of(*whose, whom);
            if (at == whose->end() || at->first != whom)
                at = whose->insert(at, {static_cast<std::uint16_t>(whom), Border{}});
            at->second.length += border.length;
            at->second.colour += border.colour;
            at->second.crease += border.crease;
            at->second.step += whose == &one.borders ? border.step : -border.step;
        }
    }
    gone.borders.clear();
    ++one.version;
    ++gone.version;
}

/// Makes a region of each superpixel.
void RegionMerging::make_regions(const Superpixels& superpixels, const std::vector<std::uint16_t>& labels) {
    const std::vector<Superpixel>& all = superpixels.all();
    regions_.assign(all.size(), {});
    region_of_.resize(all.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Superpixel& one = all[k];
        const std::int64_t n = one.pixels;
        region_of_[k] = static_cast<std::uint16_t>(k);
        regions_[k].pixels = n;
        regions_[k].brightness = n * one.brightness;
        regions_[k].red_green = n * one.red_green;
        regions_[k].yellow_blue = n * one.yellow_blue;
        regions_[k].label = labels[k];
    }
}

/// Each border belongs to the regions on both of its sides.
void RegionMerging::share_borders(const Superpixels& superpixels) {
    for (std::size_t k = 0; k < regions_.size(); ++k)
        for (std::size_t slot = 0; slot < reach_slots; ++slot) {
            Border border = table_[k * reach_slots + slot];
            if (border.length == 0) continue;
            const std::size_t other = k +
                                      slot / reach_side * static_cast<std::size_t>(superpixels.columns()) +
                                      slot % reach_side - reach;
            measure(superpixels.all(), k, other, border);
            regions_[k].borders.emplace_back(static_cast<std::uint16_t>(other), border);
            border.step = -border.step;
            regions_[other].borders.emplace_back(static_cast<std::uint16_t>(k), border);
        }
    for (Region& region : regions_)
        std::ranges::sort(region.borders, {}, [](const auto& border) { return border.first; });
}

/// Merges the least different regions first; beyond `apart` only those that are too small, or too many.
void RegionMerging::join_alike() {
    queue_.clear();
    for (std::size_t k = 0; k < regions_.size(); ++k) offer(k);
    auto left = std::ranges::count_if(regions_, [](const Region& region) { return !region.borders.empty(); });
    while (!queue_.empty()) {
        std::pop_heap(queue_.begin(), queue_.end());
        const Candidate next = queue_.back();
        queue_.pop_back();
        const Region &one = regions_[next.a], &other = regions_[next.b];
        if (one.version != next.version_a || other.version != next.version_b) continue;
        const Region& smaller = one.pixels <= other.pixels ? one : other;
        // A region of the last frame may get smaller before it is merged.
        const bool stays = smaller.label != 0 && one.label != other.label;
        const bool is_crumb = smaller.pixels * (stays ? 2 : 1) < smallest_;
        if (next.difference >= apart && !is_crumb && left <= most_regions) continue;
        --left;
        const bool into_first = one.borders.size() >= other.borders.size();
        const std::uint16_t into = into_first ? next.a : next.b, from = into_first ? next.b : next.a;
        join(into, from);
        region_of_[from] = into;
        offer(into);
    }
}

const std::vector<std::uint16_t>& RegionMerging::merge(const Superpixels& superpixels,
                                                       const std::vector<std::uint16_t>& labels) {
    find_borders(superpixels);
    find_normals(superpixels);
    make_regions(superpixels, labels);
    share_borders(superpixels);
    join_alike();
    for (std::size_t k = 0; k < region_of_.size(); ++k) {
        std::uint16_t root = static_cast<std::uint16_t>(k);
        while (region_of_[root] != root) root = region_of_[root];
        region_of_[k] = root;
    }
    return region_of_;
}

/// `Run::island` leads to the first run of its island.
std::uint32_t RegionCleaning::island_of(std::uint32_t run) {
    while (runs_[run].island != run) {
        runs_[run].island = runs_[runs_[run].island].island;
        run = runs_[run].island;
    }
    return run;
}

/// Finds runs of one region, row by row.
void RegionCleaning::find_runs(const std::vector<std::uint16_t>& regions, int width, int height) {
    runs_.clear();
    row_begins_.clear();
    for (int y = 0; y < height; ++y) {
        row_begins_.push_back(static_cast<std::uint32_t>(runs_.size()));
        const std::uint16_t* row = &regions[pixel_place(0, y, width)];
        for (int x = 0, first = 0; x < width; ++x)
            if (x + 1 == width || row[x + 1] != row[x]) {
                const auto island = static_cast<std::uint32_t>(runs_.size());
                runs_.push_back({first, x, y, row[x], island});
                first = x + 1;
            }
    }
    row_begins_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

/// Calls `touch(run above, run below, pixels)` for runs that meet. The last runs of all rows end at the
/// picture's right edge, so that a row and the row below it end together.
template <class Touch>
void RegionCleaning::for_each_contact(Touch&& touch) const {
    for (std::size_t y = 1; y + 1 < row_begins_.size(); ++y)
        for (std::uint32_t above = row_begins_[y - 1], below = row_begins_[y]; above < row_begins_[y];) {
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
