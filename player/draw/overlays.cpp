// SPDX-License-Identifier: Apache-2.0
#include "player/draw/overlays.hpp"

#include "engine/base/same_bits.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/overlay_rows.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"

// Compiled without errno and floating-point traps, like overlay_rows.cpp.

namespace touchable {
namespace {

// Colours of classes, distinct also for red-green colour blindness (Okabe and Ito 2008).
constexpr PackedColour whole_colour = pack_colour(0, 114, 178), mixed_colour = pack_colour(230, 159, 0),
                       valid_colour = pack_colour(86, 180, 233), rim_colour = pack_colour(213, 94, 0),
                       once_colour = pack_colour(240, 228, 66), filled_colour = pack_colour(204, 121, 167);

void put(PackedColour colour, std::uint8_t* rgb) {
    rgb[0] = static_cast<std::uint8_t>(colour);
    rgb[1] = static_cast<std::uint8_t>(colour >> 8);
    rgb[2] = static_cast<std::uint8_t>(colour >> 16);
}

/// A scale's name and unit; `factor`: the unit's value per value of ScalarRows.
struct Meaning {
    Scalar scalar;
    const char *name, *unit;
    double factor;
};

Meaning meaning_of(Overlay kind, const Scene& scene) {
    const double deepest_m = scene.depth.far * scene.metres_per_unit;
    const bool is_room = deepest_m > 10, is_arm_long = deepest_m > 1;
    const double millimetres = 1000 * scene.metres_per_unit;
    switch (kind) {
        case Overlay::stiffness:
            return {Scalar::stiffness, "stiffness", "N/mm", 0.001};
        case Overlay::static_friction:
            return {Scalar::static_friction, "static friction", "", 1};
        case Overlay::dynamic_friction:
            return {Scalar::dynamic_friction, "dynamic friction", "", 1};
        case Overlay::height:
            // Scene millimetres, not the hand's, in which relief options are given.
            return {Scalar::height, "height", is_room ? "m of the scene" : "mm of the scene",
                    is_room ? scene.metres_per_unit : millimetres};
        case Overlay::errors:
            return {Scalar::errors, "forces err by less (95 %)", "degrees", 1};
        default:
            return {Scalar::depth, "depth", is_arm_long ? "m" : "mm",
                    is_arm_long ? scene.metres_per_unit : millimetres};
    }
}

struct SeenValues {
    Overlays::Range shown, all;
    std::vector<float> values;  // except those at the far plane, unordered
};

/// A grid of at most 256 pixels a side. `shown` excludes the outermost depths and the far plane, where
/// backgrounds are.
SeenValues seen_values(Scalar scalar, const HeightField& field, ScalarRows& rows, std::vector<float>& row) {
    const int step = 1 + std::max(field.width(), field.height()) / 256;
    const auto most = static_cast<float>(scalar == Scalar::depth ? 0.999 * field.scene().depth.far
                                                                 : std::numeric_limits<float>::max());
    SeenValues seen;
    std::vector<float>& values = seen.values;
    float least = std::numeric_limits<float>::max(), greatest = std::numeric_limits<float>::lowest();
    for (int y = step / 2; y < field.height(); y += step) {
        rows.read(y, row.data());
        for (int x = step / 2; x < field.width(); x += step) {
            const float value = row[static_cast<std::size_t>(x)];
            if (value < most) values.push_back(value);
            if (value < least) least = value;
            if (value > greatest) greatest = value;
        }
    }
    if (values.empty()) return seen;
    const auto quantile = [&](std::size_t percent) {
        return static_cast<double>(sorted_element(values, (values.size() - 1) * percent / 100));
    };
    const std::size_t outermost = scalar == Scalar::depth || scalar == Scalar::errors ? 1 : 0;
    seen.shown = {quantile(outermost), quantile(100 - outermost)};
    seen.all = {static_cast<double>(least), static_cast<double>(greatest)};
    return seen;
}

/// Whether a plane of the clip holds the values.
bool has_map(Scalar scalar, const HeightField& field, const FramePair& pair) {
    const auto has = [scalar](const SurfaceFrame& frame) {
        return scalar == Scalar::depth || scalar == Scalar::errors ||
               (scalar == Scalar::height ? !frame.heights.empty() : !frame.haptic.empty());
    };
    return has(*pair.prev.frame) || (field.blend() > 0 && has(*pair.next.frame));
}

/// The range; equal ends if they differ by no more than rounding.
Overlays::Range apart(const Overlays::Range& range) {
    const double size = std::max(std::fabs(range.least), std::fabs(range.greatest));
    return range.greatest - range.least > 1e-5 * size ? range
                                                      : Overlays::Range{range.greatest, range.greatest};
}

/// Converts values of a row to indices on the ramp, 0 to 255; 256: no value.
void indices_of(const float* values, int width, float least, float per_value, std::uint32_t* indices) {
    for (int x = 0; x < width; ++x) {
        const float value = values[x], share = (value - least) * per_value + 0.5F;
        const float held = share > 0.0F ? (share < 255.0F ? share : 255.0F) : 0.0F;
        indices[x] = value == value ? static_cast<std::uint32_t>(static_cast<int>(held)) : 256U;
    }
}

/// The usual colour of a unit normal: X to the right red, Y up green, Z towards the clip's camera blue.
PackedColour normal_colour(const glm::dvec3& normal) {
    const glm::uvec3 byte(127.5 * normal + 128.0);
    return pack_colour(byte.r, byte.g, byte.b);
}

}  // namespace

class Overlays::Painter {
public:
    const Overlays::Picture& paint(Overlay kind, const HeightField& field, const FramePair& pair) {
        assert(kind != Overlay::colour);
        picture_.width = field.width();
        picture_.height = field.height();
        picture_.rgb.resize(3 * pixel_count(field.width(), field.height()));
        picture_.scale = {};
        if (kind == Overlay::normals || kind == Overlay::tiles) lattices_.q_of(field, pair, q_);
        if (kind == Overlay::normals)
            paint_normals(field);
        else if (kind == Overlay::tiles)
            paint_tiles(field);
        else if (kind == Overlay::validity)
            paint_validity(field, pair);
        else
            paint_values(kind, field, pair);
        return picture_;
    }

private:
    void paint_values(Overlay kind, const HeightField& field, const FramePair& pair) {
        const Meaning meaning = meaning_of(kind, field.scene());
        const int width = field.width();
        std::vector<float> row(static_cast<std::size_t>(width));
        std::vector<std::uint32_t> indices(row.size());
        rows_.begin(meaning.scalar, field, pair);
        const SeenValues seen = seen_values(meaning.scalar, field, rows_, row);
        Overlays::Range range = apart(ranges_[static_cast<std::size_t>(kind)].update(seen.shown, field));
        const auto& hole_stiffness = field.scene().hole_stiffness;  // N/mm
        const bool is_mapped = has_map(meaning.scalar, field, pair);
        if (!is_mapped && kind == Overlay::stiffness && hole_stiffness) {
            range.least = range.greatest = field.default_properties().stiffness;
            picture_.scale.at_holes = *hole_stiffness;
        }
        const bool even = !(range.greatest > range.least), is_equalised = kind == Overlay::depth && !even;
        Overlays::Scale& scale = picture_.scale;
        scale.name = meaning.name;
        scale.unit = meaning.unit;
        scale.range = {range.least * meaning.factor, range.greatest * meaning.factor};
        scale.is_less = !even && seen.all.least < range.least;
        scale.is_more = !even && seen.all.greatest > range.greatest;
        scale.least_is_light = meaning.scalar == Scalar::depth;  // near is light
        scale.has_map = is_mapped;
        if (seen.values.empty()) scale.classes = {{hole_colour(0, 0), "not known"}};
        if (kind == Overlay::depth_linear) scale.spread = "linear, 1 to 99 %";
        if (is_equalised) {
            equalised_.update(seen.values, field);
            make_equalised(range, meaning.factor);
        } else {
            colours_.assign(colour_ramp().begin(), colour_ramp().end());
            if (scale.least_is_light) std::ranges::reverse(colours_);
            if (even) std::fill(colours_.begin(), colours_.end(), ramp_colour(0.5));
        }
        const auto least = static_cast<float>(range.least);
        const auto per_value = static_cast<float>(even ? 0.0 : 255.0 / (range.greatest - range.least));
        for (int y = 0; y < field.height(); ++y) {
            rows_.read(y, row.data());
            if (is_equalised)
                equalised_.find_bins(row.data(), width, indices.data());
            else
                indices_of(row.data(), width, least, per_value, indices.data());
            std::uint8_t* rgb = this->row(y);
            for (int x = 0; x < width; ++x, rgb += 3) {
                const std::uint32_t index = indices[static_cast<std::size_t>(x)];
                put(index < colours_.size() ? colours_[index] : hole_colour(x, y), rgb);
            }
        }
    }

    /// Colours of `equalised_`'s bins, and the scale's levels. `factor`: the scale unit's value per scene
    /// unit.
    void make_equalised(const Overlays::Range& range, double factor) {
        std::uint32_t ends[2];
        const float values[] = {static_cast<float>(range.least), static_cast<float>(range.greatest)};
        equalised_.find_bins(values, 2, ends);
        const double first = equalised_.share_of_bin(ends[0]), last = equalised_.share_of_bin(ends[1]);
        colours_.resize(equalised_.bins());
        for (std::size_t k = 0; k < colours_.size(); ++k) {
            const double share = (equalised_.share_of_bin(k) - first) / std::max(last - first, 1e-9);
            colours_[k] = ramp_colour(1 - share);
        }
        Overlays::Scale& scale = picture_.scale;
        scale.spread = "equalised";
        constexpr int steps = 4;
        for (int k = 0; k <= steps; ++k) {
            const double value = equalised_.depth_at(first + (last - first) * k / steps);
            scale.levels.push_back(factor * std::clamp(value, range.least, range.greatest));
        }
        scale.levels.front() = scale.range.least;
        scale.levels.back() = scale.range.greatest;
    }

    void paint_normals(const HeightField& field) {
        picture_.scale.name = "normals";
        picture_.scale.classes = {{normal_colour({1, 0, 0}), "to the right"},
                                  {normal_colour({0, 1, 0}), "up"},
                                  {normal_colour({0, 0, 1}), "towards the clip's camera"}};
        NormalRows rows(field.scene().camera, field.width(), field.height(), q_.data());
        for (int y = 0; y < field.height(); ++y) {
            rows.paint(y, row(y));
            const float* q = q_.data() + std::ptrdiff_t{y} * field.width();
            for (int x = 0; x < field.width(); ++x)
                if (!(q[x] > 0)) put(hole_colour(x, y), row(y) + std::ptrdiff_t{3} * x);
        }
    }

    void paint_tiles(const HeightField& field) {
        picture_.scale.name = "tiles of 16x16 cells";
        picture_.scale.classes = {{whole_colour, "all of it is drawn"},
                                  {mixed_colour, "some of it is drawn"}};
        const TileGrid grid = TileGrid::of(field.width(), field.height());
        const ViewSurface::Tiles tiles = lattices_.tiles_of(field.width(), field.height(), q_);
        std::vector<PackedColour> colours(grid.count());
        for (const std::uint32_t tile : tiles.whole) colours[tile] = whole_colour;
        for (const std::uint32_t tile : tiles.mixed) colours[tile] = mixed_colour;
        for (int y = 0; y < field.height(); ++y)
            for (int x = 0; x < field.width(); ++x) {
                const int tile = grid.row_of_cell(y) * grid.tiles_x + grid.column_of_cell(x);
                PackedColour colour = colours[static_cast<std::size_t>(tile)];
                // A darker line at each tile's border.
                if (x % TileGrid::cells == 0 || y % TileGrid::cells == 0) colour = colour >> 1 & 0x7F7F7FU;
                put(colours[static_cast<std::size_t>(tile)] != 0 ? colour : hole_colour(x, y),
                    row(y) + std::ptrdiff_t{3} * x);
            }
    }

    void paint_validity(const HeightField& field, const FramePair& pair) {
        picture_.scale.name = "validity";
        picture_.scale.classes = {{valid_colour, "has depth"}, {rim_colour, "next to a hole"}};
        rows_.begin(Scalar::depth, field, pair);
        if (rows_.is_between())
            picture_.scale.classes.push_back({once_colour, "has depth in one of two frames"});
        if (rows_.has_filled()) picture_.scale.classes.push_back({filled_colour, "depth of another frame"});
        const int width = field.width(), height = field.height();
        const std::size_t columns = static_cast<std::size_t>(width) + 2;  // one more at either side
        // read_validity's states of three rows; beyond the picture there is no hole.
        std::array<std::vector<std::uint8_t>, 3> states;
        const auto line = [&](int y) -> std::vector<std::uint8_t>& {
            return states[static_cast<std::size_t>((y + 3) % 3)];
        };
        const auto read = [&](int y) {
            line(y).assign(columns, 1);
            if (y >= 0 && y < height) rows_.read_validity(y, line(y).data() + 1);
        };
        read(-1);
        read(0);
        std::vector<std::uint8_t> open(columns);
        for (int y = 0; y < height; ++y) {
            read(y + 1);
            for (std::size_t x = 0; x < columns; ++x)
                open[x] = states[0][x] == 0 || states[1][x] == 0 || states[2][x] == 0 ? 1 : 0;
            const std::uint8_t* state = line(y).data() + 1;
            std::uint8_t* rgb = row(y);
            for (int x = 0; x < width; ++x, rgb += 3) {
                const std::uint8_t* beside = open.data() + x;
                const bool rim = (beside[0] | beside[1] | beside[2]) != 0;
                const PackedColour colour = state[x] == 3   ? filled_colour
                                            : state[x] == 2 ? once_colour
                                            : rim           ? rim_colour
                                                            : valid_colour;
                put(state[x] == 0 ? hole_colour(x, y) : colour, rgb);
            }
        }
    }

    std::uint8_t* row(int y) { return picture_.rgb.data() + std::ptrdiff_t{3} * y * picture_.width; }

    Overlays::Picture picture_;
    ScalarRows rows_;
    std::array<SteadyRange, 11> ranges_;  // by Overlay
    EqualisedDepth equalised_;
    CpuLattices lattices_{1};
    std::vector<float> q_;
    std::vector<PackedColour> colours_;  // by ramp index or depth bin
};

Overlays::Overlays() : painter_(std::make_unique<Painter>()) {}
Overlays::~Overlays() = default;

const Overlays::Picture& Overlays::paint(Overlay kind, const HeightField& field, const FramePair& pair) {
    return painter_->paint(kind, field, pair);
}

Lighting light_of(Overlay kind) {
    const bool shows_relief =
        kind == Overlay::depth || kind == Overlay::depth_linear || kind == Overlay::normals;
    return shows_relief ? Lighting::values : Lighting::soft;
}

}  // namespace touchable
