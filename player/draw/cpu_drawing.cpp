// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <glm/matrix.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/vectors.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "shaders/cut_rule.h"
#include "shaders/dents.h"

// Pictures of a surface one after another, by the CPU: of the surface alone (CpuSurface), with dents
// (DentPatches), and with fingers (CpuDrawing).

namespace touchable {
namespace {

/// The channels of two adjacent pixels, and of one.
using Pair = std::uint16_t __attribute__((vector_size(16)));
using Channels = std::uint16_t __attribute__((vector_size(8)));

Pair pair_at(const PackedColour* at) {
    using Bytes = std::uint8_t __attribute__((vector_size(8)));
    Bytes bytes;
    std::memcpy(&bytes, at, sizeof bytes);
    return __builtin_convertvector(bytes, Pair);
}

/// Interpolates two colours; `share`: 256ths.
template <class Vector>
Vector between(Vector a, Vector b, int share) {
    const auto of_a = static_cast<std::uint16_t>(256 - share), of_b = static_cast<std::uint16_t>(share);
    return (a * of_a + b * of_b + std::uint16_t{128}) >> 8;
}

/// A value that changes linearly from pixel to pixel, times `unit`, in 16.16 fixed point.
struct Steadily {
    std::int32_t now = 0, change = 0;

    Steadily(float first, float last, float per_step, float unit = 1)
        : now(static_cast<std::int32_t>(65536 * unit * first)),
          change(static_cast<std::int32_t>(65536 * unit * (last - first) * per_step)) {}
    int whole() const { return now >> 16; }
    void go_on() { now += change; }
};

/// `light`: 64ths, below 257, as products have 16 bits (dent_light is below 3.2); `gloss`: 0 to 255.
PackedColour lit(Channels colour, int light, int gloss) {
    Channels value = ((colour * static_cast<std::uint16_t>(light) + std::uint16_t{32}) >> 6) +
                     static_cast<std::uint16_t>(gloss);
    const Channels most = Channels{} + std::uint16_t{255};
    value = value > most ? most : value;
    using Bytes = std::uint8_t __attribute__((vector_size(4)));
    return std::bit_cast<PackedColour>(__builtin_convertvector(value, Bytes)) | 0xff000000U;
}

/// The interpolated colour at a position in 256ths of a pixel, from the first pixel's centre to before the
/// last one's.
Channels colour_around(const FlatPicture& flat, int x, int y) {
    const PackedColour* const at = flat.colours.data() + std::ptrdiff_t{y >> 8} * flat.width + (x >> 8);
    const auto column =
        std::bit_cast<std::array<Channels, 2>>(between(pair_at(at), pair_at(at + flat.width), y & 255));
    return between(column[0], column[1], x & 255);
}

}  // namespace

void CpuSurface::show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int step) {
    edges_are_found_ = false;
    if (step == 1 || !SurfaceUnproject::has_codes(field, pair)) return make(field, pair, colour, lighting, 1);
    decimation_.make(field, pair, colour, step);
    make(decimation_.field(), decimation_.pair(), decimation_.colour(), lighting, step);
}

void CpuSurface::make(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int step) {
    lattices_.q_of(field, pair, q_);
    lattices_.light(field, q_, colour, lighting, colours_, cut_ratio(step));
    focal_length_ = static_cast<float>(field.scene().camera.fx);
    lattice_ = {
        q_.data(), colours_.data(), field.width(), field.height(), step, fills_gaps(colour, lighting)};
}

void CpuSurface::paint(const ViewCamera& camera, std::span<PackedColour> colours,
                       std::span<float> z) {
    if (background_.size() != static_cast<std::size_t>(camera.height)) {
        background_.resize(static_cast<std::size_t>(camera.height));
        for (int y = 0; y < camera.height; ++y)
            background_[static_cast<std::size_t>(y)] = background_colour(y, camera.height);
    }
    if (lattice_.width == 0) {
        for (std::size_t k = 0; k < colours.size(); ++k)
            colours[k] = background_[k / static_cast<std::size_t>(camera.width)];
        std::fill(z.begin(), z.end(), 0.0F);
        return;
    }
    const ViewCamera seen = decimated(camera, lattice_.step);
    if (OwnViewPicture::draws(seen)) return own_view_.draw(lattice_, seen, background_, colours, z);
    const bool is_own = is_own_view(seen);
    if (is_own) edges_.clear();
    if (!is_own && !edges_are_found_)
        edges_.find(edge_lattice(lattice_.q, lattice_.width, lattice_.height, lattice_.width, lattice_.step,
                                 focal_length_));
    edges_are_found_ = !is_own;
    turned_view_.draw(lattice_, edges_, seen, background_, colours, z);
    if (!is_own) silhouettes_.smooth(colours, z, seen.width, seen.height);
}

void double_picture(std::span<const PackedColour> from, int width, int height, std::span<PackedColour> to) {
    const auto pixels = static_cast<std::size_t>(width);
    // Two channels of 16 bits in each value; of two rows, the outer pixels twice.
    constexpr std::uint32_t channels = 0x00ff00ff, half = 0x00080008;
    std::vector<std::uint32_t> reds(pixels + 2), greens(pixels + 2);
    const auto stretch = [&](auto) __attribute__((always_inline)) {
        const int count = width, last = height - 1;  // in registers, which lets the loops vectorise
        for (int y = 0; y <= 2 * last + 1; ++y) {
            const int beside = std::clamp(y / 2 + y % 2 * 2 - 1, 0, last);
            const PackedColour* const near = from.data() + pixels * static_cast<std::size_t>(y / 2);
            const PackedColour* const far = from.data() + pixels * static_cast<std::size_t>(beside);
            std::uint32_t* const red = reds.data() + 1;
            std::uint32_t* const green = greens.data() + 1;
            for (int x = 0; x < count; ++x) {
                red[x] = 3 * (near[x] & channels) + (far[x] & channels);
                green[x] = 3 * (near[x] >> 8 & channels) + (far[x] >> 8 & channels);
            }
            for (std::uint32_t* const sum : {red, green}) {
                sum[-1] = sum[0];
                sum[count] = sum[count - 1];
            }
            const auto between = [=](int x, int other) __attribute__((always_inline)) {
                const std::uint32_t r = 3 * red[x] + red[other] + half,
                                    g = 3 * green[x] + green[other] + half;
                return (r >> 4 & channels) | (g >> 4 & channels) << 8;
            };
            PackedColour* const out = to.data() + 2 * pixels * static_cast<std::size_t>(y);
            for (int x = 0; x < count; ++x) {
                out[2 * x] = between(x, x - 1);
                out[2 * x + 1] = between(x, x + 1);
            }
        }
    };
    run_vectors(usable_vector_units().front(), stretch);
}

bool DentPatches::shape(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera) {
    shape_dents(fingers, sizes, dents_);
    seen_.clear();
    for (const SurfaceDent& dent : dents_)
        if (const auto bounds = bounds_in_sight(camera, dent.centre, dent.reach)) seen_.push_back(*bounds);
    const glm::dmat4 from_pixel = clip_from_pixel(camera);
    world_from_pixel_ = glm::inverse(camera.clip_from_world) * from_pixel;
    pixel_from_world_ = glm::inverse(from_pixel) * camera.clip_from_world;
    return !seen_.empty() && camera.width > 1 && camera.height > 1;
}

void DentPatches::draw(const FlatPicture& flat, std::span<PackedColour> to) {
    for (const PixelBounds& bounds : seen_) {
        find_nodes(flat, bounds);
        draw(flat, bounds, to.data());
    }
}

void DentPatches::find_nodes(const FlatPicture& flat, const PixelBounds& bounds) {
    constexpr int steps = 20;  // across a dent; one is a tenth of its reach
    const int width = bounds.x1 - bounds.x0, height = bounds.y1 - bounds.y0;
    step_ = std::max(2, std::max(width, height) / steps);
    across_ = width / step_ + 2;
    nodes_.assign(static_cast<std::size_t>(across_) * static_cast<std::size_t>(height / step_ + 2), {});
    auto node = nodes_.begin();
    for (int down = 0; down < height / step_ + 2; ++down)
        for (int right = 0; right < across_; ++right, ++node) {
            const int x = std::min(bounds.x0 + right * step_, flat.width - 1),
                      y = std::min(bounds.y0 + down * step_, flat.height - 1);
            const float z = flat.z[static_cast<std::size_t>(y * flat.width + x)];
            if (!(z > 0)) continue;
            const glm::dvec4 at =
                world_from_pixel_ * glm::dvec4(x + 0.5, y + 0.5, static_cast<double>(z), 1);
            const glm::dvec3 place = glm::dvec3(at) / at.w;
            const auto dent = dented(dents_, place);
            if (!dent) continue;
            const glm::dvec4 there = pixel_from_world_ * glm::dvec4(place + glm::dvec3(dent->moved), 1);
            if (!(there.z <= there.w)) continue;  // before the near plane
            const DentLight light = dent_light(dent->normal_before, dent->normal);
            const auto shift = [](double pixels) {
                return static_cast<float>(std::clamp(pixels, -4096.0, 4096.0));
            };
            *node = {shift(x + 0.5 - there.x / there.w), shift(y + 0.5 - there.y / there.w), light.factor,
                     255 * light.gloss};
        }
}

void DentPatches::draw(const FlatPicture& flat, const PixelBounds& bounds, PackedColour* to) const {
    const int width = bounds.x1 - bounds.x0;
    const float per_step = 1 / static_cast<float>(step_);
    const int most_x = 256 * (flat.width - 1) - 1, most_y = 256 * (flat.height - 1) - 1;
    const auto mix = [](const Node& a, const Node& b, float share) {
        return Node{a.right + share * (b.right - a.right), a.down + share * (b.down - a.down),
                    a.light + share * (b.light - a.light), a.gloss + share * (b.gloss - a.gloss)};
    };
    for (int y = bounds.y0; y < bounds.y1; ++y) {
        const int row = (y - bounds.y0) / step_;
        const float down = static_cast<float>((y - bounds.y0) % step_) * per_step;
        const Node* const above = nodes_.data() + std::ptrdiff_t{row} * across_;
        const std::ptrdiff_t start = std::ptrdiff_t{y} * flat.width;
        PackedColour* const out = to + start + bounds.x0;
        Node left = mix(above[0], above[across_], down);
        for (int first = 0, column = 1; first < width; first += step_, ++column) {
            const Node right = mix(above[column], above[across_ + column], down);
            const Node from = std::exchange(left, right);
            const bool is_flat = from.light == 1 && right.light == 1 && from.right == 0 && right.right == 0 &&
                                 from.down == 0 && right.down == 0;
            if (is_flat) continue;
            const auto begin = static_cast<float>(bounds.x0 + first);
            Steadily across(begin + from.right, begin + static_cast<float>(step_) + right.right, per_step),
                along(static_cast<float>(y) + from.down, static_cast<float>(y) + right.down, per_step),
                light(from.light, right.light, per_step, 64), gloss(from.gloss, right.gloss, per_step);
            for (int k = first; k < std::min(first + step_, width); ++k) {
                int column_of = std::clamp(across.now >> 8, 0, most_x),
                    row_of = std::clamp(along.now >> 8, 0, most_y);
                const int more = light.whole(), shine = gloss.whole();
                for (Steadily* each : {&across, &along, &light, &gloss}) each->go_on();
                const int x = bounds.x0 + k;
                const float z = flat.z[static_cast<std::size_t>(start + x)];
                if (!(z > 0)) continue;
                const std::ptrdiff_t source =
                    std::ptrdiff_t{(row_of + 128) >> 8} * flat.width + ((column_of + 128) >> 8);
                // Objects in front of the pixel's own surface are not displaced.
                if (flat.z[static_cast<std::size_t>(source)] > z * CUT_RULE_RATIO) {
                    column_of = std::min(256 * x, most_x);
                    row_of = std::min(256 * y, most_y);
                }
                out[k] = lit(colour_around(flat, column_of, row_of), more, shine);
            }
        }
    }
}

struct CpuDrawing::Parts {
    CpuSurface surface;
    LightPicture bare;                  // the surface on its background, without fingers
    std::optional<glm::dmat4> painted;  // clip_from_lattice of `bare`
    Image picture;
};

CpuDrawing::CpuDrawing() : parts_(std::make_unique<Parts>()) {}
CpuDrawing::~CpuDrawing() = default;

void CpuDrawing::show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting) {
    parts_->painted.reset();
    parts_->surface.show(field, pair, colour, lighting, 1);
}

Result<const Image*> CpuDrawing::draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                                      const MarkSizes& sizes, int samples) {
    auto& [surface, bare, painted, picture] = *parts_;
    if (painted != camera.clip_from_lattice || bare.width != camera.width || bare.height != camera.height) {
        const std::size_t pixels = pixel_count(camera.width, camera.height);
        PicturePlanes planes{camera.width, camera.height, std::vector<float>(pixels),
                             std::vector<PackedColour>(pixels)};
        surface.paint(camera, planes.colours, planes.z);
        bare = on_background(std::move(planes));
        painted = camera.clip_from_lattice;
    }
    LightPicture touched = bare;
    draw_fingers(fingers, sizes, camera, touched);
    picture = developed(touched, samples);
    return &picture;
}

}  // namespace touchable
