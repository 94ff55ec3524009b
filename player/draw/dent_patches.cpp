#include "player/draw/dent_patches.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/matrix.hpp>

#include "engine/base/try.hpp"
#include "shaders/cut_rule.h"

namespace touchable {

/// From pixels to places and back.
struct DentPatches::Sight {
    explicit Sight(const ViewCamera& camera)
        : world_from_pixel(glm::inverse(camera.clip_from_world) * clip_from_pixel(camera)),
          pixel_from_world(glm::inverse(clip_from_pixel(camera)) * camera.clip_from_world) {}
    glm::dmat4 world_from_pixel, pixel_from_world;
};

namespace {

/// The channels of two pixels beside each other, and of one.
using Pair = std::uint16_t __attribute__((vector_size(16)));
using Channels = std::uint16_t __attribute__((vector_size(8)));

Pair pair_at(const PackedColour* at) {
    using Bytes = std::uint8_t __attribute__((vector_size(8)));
    Bytes bytes;
    std::memcpy(&bytes, at, sizeof bytes);
    return __builtin_convertvector(bytes, Pair);
}

/// Between two colours, `share` of 256.
template <class Vector>
Vector between(Vector a, Vector b, int share) {
    const auto of_a = static_cast<std::uint16_t>(256 - share), of_b = static_cast<std::uint16_t>(share);
    return (a * of_a + b * of_b + std::uint16_t{128}) >> 8;
}

/// A number that changes by as much from pixel to pixel: 65536ths of `unit`s.
struct Steadily {
    std::int32_t now = 0, change = 0;

    Steadily(float first, float last, float per_step, float unit = 1)
        : now(static_cast<std::int32_t>(65536 * unit * first)),
          change(static_cast<std::int32_t>(65536 * unit * (last - first) * per_step)) {}
    int whole() const { return now >> 16; }
    void go_on() { now += change; }
};

/// `light`: 64ths, below 257 of them, as products have 16 bits (dent_light is below 3.2); `gloss`: of 255.
PackedColour lit(Channels colour, int light, int gloss) {
    Channels value = ((colour * static_cast<std::uint16_t>(light) + std::uint16_t{32}) >> 6) +
                     static_cast<std::uint16_t>(gloss);
    const Channels most = Channels{} + std::uint16_t{255};
    value = value > most ? most : value;
    using Bytes = std::uint8_t __attribute__((vector_size(4)));
    return std::bit_cast<PackedColour>(__builtin_convertvector(value, Bytes)) | 0xff000000U;
}

/// The colour around a place, which is in 256ths of a pixel from the middle of the first one, and before the
/// middle of the last one.
Channels colour_around(const FlatPicture& flat, int x, int y) {
    const PackedColour* const at = flat.colours.data() + std::ptrdiff_t{y >> 8} * flat.pitch + (x >> 8);
    const auto column =
        std::bit_cast<std::array<Channels, 2>>(between(pair_at(at), pair_at(at + flat.pitch), y & 255));
    return between(column[0], column[1], x & 255);
}

}  // namespace

void DentPatches::find_nodes(const Sight& sight, const FlatPicture& flat, const PixelBounds& bounds) {
    constexpr int steps = 20;  // across a dent, of which a tenth of its reach is one
    const int width = bounds.x1 - bounds.x0, height = bounds.y1 - bounds.y0;
    step_ = std::max(2, std::max(width, height) / steps);
    across_ = width / step_ + 2;
    nodes_.assign(static_cast<std::size_t>(across_) * static_cast<std::size_t>(height / step_ + 2), {});
    auto node = nodes_.begin();
    for (int down = 0; down < height / step_ + 2; ++down)
        for (int right = 0; right < across_; ++right, ++node) {
            const int x = std::min(bounds.x0 + right * step_, flat.width - 1),
                      y = std::min(bounds.y0 + down * step_, flat.height - 1);
            const float z = flat.z[static_cast<std::size_t>(y * flat.pitch + x)];
            if (!(z > 0)) continue;
            const glm::dvec4 at =
                sight.world_from_pixel * glm::dvec4(x + 0.5, y + 0.5, static_cast<double>(z), 1);
            const glm::dvec3 place = glm::dvec3(at) / at.w;
            const auto dent = dented(dents_, place);
            if (!dent) continue;
            const glm::dvec4 there = sight.pixel_from_world * glm::dvec4(place + glm::dvec3(dent->moved), 1);
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
    for (int y = bounds.y0; y < bounds.y1; ++y, to += width) {
        const int row = (y - bounds.y0) / step_;
        const float down = static_cast<float>((y - bounds.y0) % step_) * per_step;
        const Node* const above = nodes_.data() + std::ptrdiff_t{row} * across_;
        const std::ptrdiff_t start = std::ptrdiff_t{y} * flat.pitch;
        std::copy_n(flat.colours.data() + start + bounds.x0, width, to);
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
                    std::ptrdiff_t{(row_of + 128) >> 8} * flat.pitch + ((column_of + 128) >> 8);
                // What stands before the pixel's own surface is not on it.
                if (flat.z[static_cast<std::size_t>(source)] > z * CUT_RULE_RATIO) {
                    column_of = std::min(256 * x, most_x);
                    row_of = std::min(256 * y, most_y);
                }
                to[k] = lit(colour_around(flat, column_of, row_of), more, shine);
            }
        }
    }
}

Result<void> DentPatches::record(GpuCommands& commands, std::span<const FingerMark> fingers,
                                 const MarkSizes& sizes, const ViewCamera& camera, const FlatPicture& flat,
                                 const GpuImage& target) {
    shape_dents(fingers, sizes, dents_);
    std::vector<VkBufferImageCopy> regions;
    std::size_t pixels = 0;
    for (const SurfaceDent& dent : dents_) {
        const auto bounds = bounds_of_ball(camera, dent.centre, dent.reach);
        if (!bounds || bounds->x1 <= bounds->x0 || bounds->y1 <= bounds->y0) continue;
        VkBufferImageCopy region{};
        region.bufferOffset = 4 * pixels;
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageOffset = {bounds->x0, bounds->y0, 0};
        region.imageExtent = {static_cast<std::uint32_t>(bounds->x1 - bounds->x0),
                              static_cast<std::uint32_t>(bounds->y1 - bounds->y0), 1};
        pixels += std::size_t{region.imageExtent.width} * region.imageExtent.height;
        regions.push_back(region);
    }
    if (regions.empty() || flat.width < 2 || flat.height < 2) return {};
    TRY_ASSIGN(const auto buffer, uploads_.take("dents", 4 * pixels));
    const Sight sight(camera);
    for (const VkBufferImageCopy& region : regions) {
        const PixelBounds bounds{region.imageOffset.x, region.imageOffset.y,
                                 region.imageOffset.x + static_cast<int>(region.imageExtent.width),
                                 region.imageOffset.y + static_cast<int>(region.imageExtent.height)};
        find_nodes(sight, flat, bounds);
        PackedColour* const to = buffer.mapped<PackedColour>().data() + region.bufferOffset / 4;
        draw(flat, bounds, to);
    }
    constexpr VkImageLayout drawn = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    record_transition(commands, target, drawn, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands.handle(), buffer.handle(), target.handle(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(regions.size()),
                           regions.data());
    commands.keep(buffer.keep_alive());
    record_transition(commands, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, drawn);
    return {};
}

}  // namespace touchable
