#include "engine/authoring/camera_rest.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

namespace touchable {
namespace {

constexpr std::int64_t least_elsewhere = 48;
constexpr std::int32_t same_level = 5 * Cell::per_level / 2, much_other_level = 24 * Cell::per_level;
/// Of so many cells with depth one must be textured to tell of the camera.
constexpr std::size_t texture_share = 6;
constexpr std::int32_t times_much = 16;

/// Brightness that all cells gained: a camera's exposure.
std::int32_t exposure_change(const CellPicture& then, const CellPicture& now) {
    std::vector<std::int32_t> gained;
    for (std::size_t k = 0; k < now.cells.size(); ++k)
        gained.push_back(now.cells[k].luma - then.cells[k].luma);
    const auto middle = gained.begin() + static_cast<std::ptrdiff_t>(gained.size() / 2);
    std::nth_element(gained.begin(), middle, gained.end());
    return *middle;
}

}  // namespace

bool Rest::is_long_enough() const {
    return count >= (begins_with_cut && ends_with_cut ? least_between_cuts : least_elsewhere);
}

CameraRest::Changes CameraRest::changes(const CellPicture& then, const CellPicture& now) const {
    Changes changes;
    const bool has_colour = then.has_colour && now.has_colour;
    const std::int32_t gain = has_colour ? exposure_change(then, now) : 0;
    for (std::size_t k = 0; k < now.cells.size(); ++k) {
        const Cell &was = then.cells[k], &is = now.cells[k];
        ++changes.all;
        const std::int32_t level = has_colour ? std::abs(is.luma - was.luma - gain) : 0;
        changes.textured += was.is_textured;
        changes.luma += was.is_textured && level > same_level;
        changes.much_luma += level > much_other_level;
        if (was.depth == Cell::none || is.depth == Cell::none) continue;
        ++changes.known;
        // A quarter of the tolerance of a pixel and half a code, as a cell is the mean of many.
        const auto code = static_cast<std::uint16_t>(was.depth / Cell::per_code);
        const std::int32_t tolerance = (depth_.tolerance(code) + 2) * Cell::per_code / 4;
        changes.depth += std::abs(is.depth - was.depth) > tolerance;
        changes.much_depth += std::abs(is.depth - was.depth) > times_much * tolerance;
    }
    return changes;
}

bool CameraRest::ends_with(CellPicture picture) {
    const std::int64_t frame = current_.first + current_.count;
    if (frame == 0 || before_.cells.size() != picture.cells.size()) {
        first_ = before_ = std::move(picture);
        ended_ = std::exchange(current_, {frame, 1, true, true});
        return frame > 0;
    }
    const Changes since_first = changes(first_, picture);
    const bool has_moved = 2 * since_first.depth > since_first.known ||
                           (texture_share * since_first.textured >= since_first.known &&
                            2 * since_first.luma > since_first.textured);
    if (has_moved) {
        const Changes at_once = changes(before_, picture);
        const bool is_cut = 2 * at_once.much_luma > at_once.all || 2 * at_once.much_depth > at_once.known;
        current_.ends_with_cut = is_cut;
        ended_ = std::exchange(current_, {frame, 1, is_cut, true});
        first_ = picture;
    } else {
        ++current_.count;
        for (std::size_t k = 0; k < first_.cells.size(); ++k)
            if (first_.cells[k].depth == Cell::none) first_.cells[k].depth = picture.cells[k].depth;
    }
    before_ = std::move(picture);
    return has_moved;
}

}  // namespace touchable
