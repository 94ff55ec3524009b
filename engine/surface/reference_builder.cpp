// SPDX-License-Identifier: Apache-2.0
// The plain builder, against which the others are tested: docs/conventions.md, step by step, unoptimised.
#include <algorithm>
#include <optional>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

struct Pixel {
    std::uint16_t code = 0;
    bool valid = false;
};

/// A picture that is copied whenever a stage needs the state before it.
struct Picture {
    int width, height;
    std::vector<Pixel> pixels;

    bool inside(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
    Pixel& at(int x, int y) { return pixels[static_cast<std::size_t>(y * width + x)]; }
    const Pixel& at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};

std::uint16_t lower_median_of(std::vector<std::uint16_t> codes) {
    std::ranges::sort(codes);
    return codes[(codes.size() - 1) / 2];
}

Picture decoded(const PlaneView& depth, const DepthCoding& coding) {
    Picture picture{depth.width, depth.height, {}};
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) {
            const std::uint16_t code = stored_code(depth, coding, x, y);
            picture.pixels.push_back(coding.is_valid(code) ? Pixel{code, true} : Pixel{});
        }
    return picture;
}

Picture holes_filled_once(const Picture& before) {
    Picture after = before;
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            if (before.at(x, y).valid) continue;
            std::vector<std::uint16_t> neighbours;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    if ((dx != 0 || dy != 0) && before.inside(x + dx, y + dy) &&
                        before.at(x + dx, y + dy).valid)
                        neighbours.push_back(before.at(x + dx, y + dy).code);
            if (neighbours.size() >= 3) after.at(x, y) = {lower_median_of(neighbours), true};
        }
    return after;
}

Picture median_filtered(const Picture& before, int side) {
    const int radius = side / 2;
    Picture after = before;
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            if (!before.at(x, y).valid) continue;
            std::vector<std::uint16_t> window;
            for (int dy = -radius; dy <= radius; ++dy)
                for (int dx = -radius; dx <= radius; ++dx) {
                    const Pixel& pixel = before.at(std::clamp(x + dx, 0, before.width - 1),
                                                   std::clamp(y + dy, 0, before.height - 1));
                    if (pixel.valid) window.push_back(pixel.code);
                }
            after.at(x, y).code = lower_median_of(window);
        }
    return after;
}

/// Codes of a pixel and of those along a line away from it, up to the first without depth.
std::vector<int> codes_along(const Picture& picture, int x, int y, int dx, int dy) {
    std::vector<int> codes;
    for (int n = 0; n <= flying_reach; ++n, x += dx, y += dy) {
        if (!picture.inside(x, y) || !picture.at(x, y).valid) break;
        codes.push_back(picture.at(x, y).code);
    }
    return codes;
}

/// The code of the surface that a line away from a pixel meets, and the steps to it.
std::optional<std::pair<int, std::size_t>> surface_along(const std::vector<int>& codes, int gate) {
    const auto one_surface = [&](std::size_t n) { return std::abs(codes[n] - codes[n + 1]) <= gate; };
    if (codes.size() > 3 && one_surface(2)) return std::pair(codes[2], one_surface(1) ? 1UL : 2UL);
    std::size_t end = 0;  // of the ramp
    const auto goes_on = [&](std::size_t n) {
        return !one_surface(n) && (codes[n] < codes[n + 1]) == (codes[0] < codes[1]);
    };
    while (end + 1 < codes.size() && goes_on(end)) ++end;
    if (end < 3 || end + 1 >= codes.size() || !one_surface(end)) return std::nullopt;
    return std::pair(codes[end], end);
}

/// A pixel between the surfaces on both sides of a line, and far from both, becomes the nearer one; of
/// several lines, the one whose sides are farthest apart counts.
Picture flying_pixels_landed(const Picture& before, const FlyingPixels& filter) {
    Picture after = before;
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x) {
            if (!before.at(x, y).valid) continue;
            const int code = before.at(x, y).code, gate = filter.gate_at(before.at(x, y).code);
            std::vector<std::pair<int, int>>
                sides;  // minus the distance between both sides; the nearer side's code
            for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
                const auto end_a = surface_along(codes_along(before, x, y, -dx, -dy), gate);
                const auto end_b = surface_along(codes_along(before, x, y, dx, dy), gate);
                if (!end_a || !end_b || end_a->second + end_b->second > widest_ramp) continue;
                const int a = end_a->first, b = end_b->first;
                const bool one_with_neighbours = std::abs(before.at(x - dx, y - dy).code - code) <= gate &&
                                                 std::abs(before.at(x + dx, y + dy).code - code) <= gate;
                const bool between = (a < code) != (b < code);  // with `far`: equal to neither
                const bool far = std::abs(a - code) > 2 * gate && std::abs(b - code) > 2 * gate;
                if (one_with_neighbours || !between || !far) continue;
                const auto nearer =
                    std::min(std::pair(std::abs(a - code), a), std::pair(std::abs(b - code), b));
                sides.emplace_back(-std::abs(a - b), nearer.second);
            }
            if (!sides.empty())
                after.at(x, y).code = static_cast<std::uint16_t>(std::ranges::min_element(sides)->second);
        }
    return after;
}

/// 0 if either tap is outside the picture or invalid.
int second_difference(const Picture& picture, int x, int y, int dx, int dy) {
    if (!picture.inside(x + dx, y + dy) || !picture.inside(x - dx, y - dy)) return 0;
    const Pixel &a = picture.at(x + dx, y + dy), &b = picture.at(x - dx, y - dy);
    return a.valid && b.valid ? a.code + b.code - 2 * picture.at(x, y).code : 0;
}

/// The second difference itself up to the gate, from there falling to 0 at twice the gate.
int tent(int difference, int gate) {
    return 2 * std::clamp(difference, -gate, gate) - std::clamp(difference, -2 * gate, 2 * gate);
}

/// 16 times what a pass adds to a code.
int levelling_of(const Picture& picture, int x, int y, int step, int gate) {
    const auto part = [&](int dx, int dy) {
        return tent(second_difference(picture, x, y, dx * step, dy * step), gate);
    };
    return 2 * (part(1, 0) + part(0, 1)) + part(1, 1) + part(1, -1);
}

Picture terraces_removed(Picture picture, const TerraceFilter& filter) {
    for (Pixel& pixel : picture.pixels) pixel.code = filter.working.of(pixel.code);
    const Picture first = picture;
    for (int pass = 0; pass < filter.passes(); ++pass) {
        const int step = filter.tap_of(pass);
        const bool is_last = pass + 1 == filter.passes();
        const Picture before = picture;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) {
                if (!before.at(x, y).valid) continue;
                const std::uint16_t code = before.at(x, y).code;
                const std::uint16_t was = first.at(x, y).code;
                const int sum = levelling_of(before, x, y, step, filter.gate_at(was, step));
                // The last pass doubles codes, so that half of a step is not rounded away.
                int after = is_last ? 2 * code + ((sum + 4) >> 3) : code + ((sum + 8) >> 4);
                const int most = filter.most_at(was);
                if (is_last) after = std::clamp(after, 2 * (was - most), 2 * (was + most));
                picture.at(x, y).code = static_cast<std::uint16_t>(after);
            }
    }
    return picture;
}

/// A picture, and for each pixel the frames for which it has only been held.
struct Remembered {
    RawFrame::Place place;
    Picture picture;
    std::vector<int> held;
};

/// The code of a frame, drawn towards the one before by the part that is likely to be noise.
std::uint16_t smoothed(int code, int before, const CodeCurve& gate) {
    const int noise = tent(code - before, gate.at(static_cast<std::uint16_t>(code)));
    const int kept = std::abs(noise) * 3 / 4;
    return static_cast<std::uint16_t>(noise > 0 ? code - kept : code + kept);
}

/// Updates the remembered picture with this frame.
void smooth(Picture picture, const RawFrame& raw, const TemporalFilter& filter,
            std::optional<Remembered>& remembered) {
    for (Pixel& pixel : picture.pixels) pixel.code = filter.working.of(pixel.code);
    if (!remembered || !remembered->place.is_before(raw)) {
        remembered = {RawFrame::Place(raw), picture, std::vector<int>(picture.pixels.size(), 0)};
        return;
    }
    remembered->place = RawFrame::Place(raw);
    for (std::size_t k = 0; k < picture.pixels.size(); ++k) {
        const Pixel& now = picture.pixels[k];
        Pixel& kept = remembered->picture.pixels[k];
        int& held = remembered->held[k];
        if (now.valid) {
            kept = {kept.valid ? smoothed(now.code, kept.code, filter.gate) : now.code, true};
            held = 0;
        } else if (kept.valid && held < temporal_hold_frames) {
            ++held;
        } else {
            kept = {};
            held = 0;
        }
    }
}

TileBounds bounds_of_tile(const Picture& picture, int tx, int ty) {
    TileBounds bounds;
    for (int y = ty * TileGrid::cells; y <= ty * TileGrid::cells + TileGrid::cells; ++y)
        for (int x = tx * TileGrid::cells; x <= tx * TileGrid::cells + TileGrid::cells; ++x) {
            if (!picture.inside(x, y)) continue;
            const Pixel& pixel = picture.at(x, y);
            if (pixel.valid) {
                bounds.least = std::min(bounds.least, pixel.code);
                bounds.greatest = std::max(bounds.greatest, pixel.code);
            } else {
                bounds.any_invalid = true;
            }
        }
    return bounds;
}

class ReferenceBuilder final : public SurfaceBuilder {
public:
    explicit ReferenceBuilder(const Scene& scene) : scene_(scene), plan_(scene) {}
    std::string_view name() const override { return "reference"; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        TRY(check_raw_frame(raw, scene_));
        Picture picture = decoded(raw.depth, plan_.stored);
        for (const FilterPlan::Stage& stage : plan_.filters)
            picture = std::visit(
                [&](const auto& filter) { return filtered(std::move(picture), filter, raw); }, stage.filter);
        store(picture, out);
        copy_touch_planes(raw, out);
        out.filled = raw.filled;
        return {};
    }

private:
    static Picture filtered(Picture picture, const FlyingPixels& filter, const RawFrame&) {
        return flying_pixels_landed(picture, filter);
    }
    static Picture filtered(Picture picture, const FilterPlan::HoleFilling& filling, const RawFrame&) {
        for (int pass = 0; pass < filling.passes; ++pass) picture = holes_filled_once(picture);
        return picture;
    }
    static Picture filtered(Picture picture, const FilterPlan::MedianWindow& window, const RawFrame&) {
        return median_filtered(picture, window.side);
    }
    Picture filtered(Picture picture, const TemporalFilter& filter, const RawFrame& raw) {
        smooth(std::move(picture), raw, filter, remembered_);
        return remembered_->picture;
    }
    static Picture filtered(Picture picture, const TerraceFilter& filter, const RawFrame&) {
        return terraces_removed(std::move(picture), filter);
    }

    void store(const Picture& picture, SurfaceFrame& out) const {
        out.width = picture.width;
        out.height = picture.height;
        out.coding = plan_.coding();
        out.raw = {};
        out.codes.clear();
        out.validity.assign(static_cast<std::size_t>(out.validity_words_per_row() * out.height), 0);
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) {
                out.codes.push_back(picture.at(x, y).code);
                if (picture.at(x, y).valid) out.validity_row(y)[x / 32] |= std::uint32_t{1} << (x % 32);
            }
        out.tiles.clear();
        const TileGrid grid = TileGrid::of(picture.width, picture.height);
        for (int ty = 0; ty < grid.tiles_y; ++ty)
            for (int tx = 0; tx < grid.tiles_x; ++tx) out.tiles.push_back(bounds_of_tile(picture, tx, ty));
        out.vertices = std::make_unique<FilteredVertices>(out);
    }

    const Scene scene_;
    const FilterPlan plan_;
    std::optional<Remembered> remembered_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_reference_builder(const Scene& scene) {
    return std::make_unique<ReferenceBuilder>(scene);
}

}  // namespace touchable
