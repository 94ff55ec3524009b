// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <limits>

#include "engine/authoring/regions.hpp"
#include "engine/authoring/segmentation.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

namespace {

constexpr int window = 3, window_pixels = window * window;
/// Hue is divided by brightness plus this: in the dark it is mostly noise.
constexpr int dark = 96;
/// A level of hue weighs as much as one of colour in a pixel of middle brightness.
constexpr int hue_weight = 4 * (128 + dark), share_bits = 14;
constexpr int brightness_weight = 2;

constexpr int per_quantum = PixelFeatures::depth_per_octave / 8;
constexpr std::size_t quanta = 32 * 8;

/// A distance of a cell's side counts like 25 levels of colour.
constexpr std::int32_t place_weight = 100 * 100, place_bits = 4;
/// A depth this far from the plane is another surface; how far does not matter.
constexpr std::int32_t most_depth = 400;
constexpr int first_rounds = 5, later_rounds = 2;
/// 256 per pixel is more than any surface that a camera sees.
constexpr std::int64_t steepest = 1 << 16;

std::vector<int> even_cells(int length, int side, int& cells) {
    cells = std::max(1, (length + side / 2) / side);
    std::vector<int> ends;
    for (int k = 0; k <= cells; ++k) ends.push_back(static_cast<int>(std::int64_t{length} * k / cells));
    return ends;
}

/// 4096 log2(number), for 1 and up to 2^31, rounded down.
std::int32_t fixed_log2(double number) {
    const auto fixed = static_cast<std::uint64_t>(number * 4294967296.0);
    const int octave = std::bit_width(fixed) - 1;
    std::uint64_t mantissa = octave >= 31 ? fixed >> (octave - 31) : fixed << (31 - octave);
    std::int32_t log = (octave - 32) * PixelFeatures::depth_per_octave;
    for (int bit = PixelFeatures::depth_per_octave / 2; bit > 0; bit /= 2) {
        mantissa = (mantissa * mantissa) >> 31;
        if (mantissa >> 32) {
            log += bit;
            mantissa >>= 1;
        }
    }
    return log;
}

}  // namespace

FeatureReader::FeatureReader(const Scene& scene)
    : width_(scene.width), height_(scene.height), coding_(scene.depth) {
    quanta_.assign(quanta, 0);
    depth_of_code_.assign(std::size_t{1} << 16, PixelFeatures::no_surface);
    if (coding_.valid_min <= coding_.valid_max) {
        const double nearest = coding_.nearest_depth();
        for (int code = coding_.valid_min; code <= coding_.valid_max; ++code) {
            const auto valid = static_cast<std::uint16_t>(code);
            if (!coding_.is_valid(valid)) continue;
            const std::int32_t depth = fixed_log2(std::clamp(coding_.depth(valid) / nearest, 1.0, 2e9));
            depth_of_code_[valid] = depth;
            const std::int32_t before = code > coding_.valid_min ? depth_of_code_[valid - 1U] : depth;
            if (before == PixelFeatures::no_surface) continue;
            std::int32_t& quantum = quanta_[static_cast<std::size_t>(depth / per_quantum)];
            quantum = std::max(quantum, std::abs(depth - before));
        }
    }
    if (coding_.semantics == DepthSemantics::range)
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                ray_.push_back(fixed_log2(std::min(scene.camera.ray_length(x, y), 2e9)));
    for (int level = 0; level <= 255 * window_pixels; ++level)
        shares_.push_back((hue_weight << share_bits) / (level + dark * window_pixels));
}

std::int32_t FeatureReader::quantum(std::int32_t depth) const {
    return quanta_[std::min(static_cast<std::size_t>(std::max(depth, 0) / per_quantum), quanta - 1)];
}

void FeatureReader::read(const RawFrame& frame, PixelFeatures& features, RowBands& bands) const {
    const std::size_t pixels = pixel_count(width_, height_);
    features.width = width_;
    features.height = height_;
    for (auto* plane : {&features.brightness, &features.red_green, &features.yellow_blue})
        plane->resize(pixels);
    features.depth.resize(pixels);
    bands.for_each_band(height_, 1, [&](const RowBand& band) {
        read_depth(frame.depth, features, band);
        if (!frame.colour.empty())
            read_colour(frame.colour, features, band);
        else
            for (auto* plane : {&features.brightness, &features.red_green, &features.yellow_blue})
                std::fill(plane->begin() + static_cast<std::ptrdiff_t>(features.place(0, band.first)),
                          plane->begin() + static_cast<std::ptrdiff_t>(features.place(0, band.last)),
                          std::int16_t{0});
    });
}

void FeatureReader::read_depth(const PlaneView& depth, PixelFeatures& features, const RowBand& band) const {
    for (int y = band.first; y < band.last; ++y) {
        const std::size_t row = features.place(0, y);
        for (int x = 0; x < width_; ++x)
            features.depth[row + static_cast<std::size_t>(x)] =
                depth_of_code_[stored_code(depth, coding_, x, y)];
        if (ray_.empty()) continue;
        for (std::size_t k = row; k < row + static_cast<std::size_t>(width_); ++k)
            if (features.has_surface(k)) features.depth[k] -= ray_[k];
    }
}

void FeatureReader::read_colour(const PlaneView& colour, PixelFeatures& features, const RowBand& band) const {
    /// Red, green and blue of three rows, added up by column.
    std::vector<std::array<std::int32_t, 3>> columns(static_cast<std::size_t>(width_));
    for (int y = band.first; y < band.last; ++y) {
        std::fill(columns.begin(), columns.end(), std::array<std::int32_t, 3>{});
        for (int dy = -1; dy <= 1; ++dy) {
            const int from = std::clamp(y + dy, 0, height_ - 1);
            for (int x = 0; x < width_; ++x) {
                const std::uint8_t* rgb = colour_at(colour, x, from, width_, height_);
                for (std::size_t c = 0; c < 3; ++c) columns[static_cast<std::size_t>(x)][c] += rgb[c];
            }
        }
        for (int x = 0; x < width_; ++x) {
            const auto& left = columns[static_cast<std::size_t>(std::max(x - 1, 0))];
            const auto& here = columns[static_cast<std::size_t>(x)];
            const auto& right = columns[static_cast<std::size_t>(std::min(x + 1, width_ - 1))];
            const std::int32_t red = left[0] + here[0] + right[0], green = left[1] + here[1] + right[1],
                               blue = left[2] + here[2] + right[2];
            const std::int32_t level = (77 * red + 150 * green + 29 * blue) / 256;
            const std::int32_t share = shares_[static_cast<std::size_t>(level)];
            const std::size_t k = features.place(x, y);
            features.brightness[k] = static_cast<std::int16_t>(level * brightness_weight / window_pixels);
            features.red_green[k] = static_cast<std::int16_t>(((red - green) * share) >> share_bits);
            features.yellow_blue[k] =
                static_cast<std::int16_t>((((red + green) / 2 - blue) * share) >> share_bits);
        }
    }
}

void Superpixels::Sums::operator+=(const Sums& other) {
    pixels += other.pixels, x += other.x, y += other.y;
    brightness += other.brightness, red_green += other.red_green, yellow_blue += other.yellow_blue;
    z += other.z, xx += other.xx, xy += other.xy, yy += other.yy;
    xz += other.xz, yz += other.yz, zz += other.zz;
}

Superpixels::Superpixels(int width, int height, int side) : width_(width), height_(height), side_(side) {
    column_ends_ = even_cells(width, side, columns_);
    row_ends_ = even_cells(height, side, rows_);
    for (int row = 0; row < rows_; ++row)
        for (int y = row_ends_[static_cast<std::size_t>(row)];
             y < row_ends_[static_cast<std::size_t>(row) + 1]; ++y)
            row_of_y_.push_back(row);
    all_.resize(pixel_count(columns_, rows_));
    of_pixels_.resize(pixel_count(width, height));
}

void Superpixels::forget() {
    is_new_ = true;
    std::fill(all_.begin(), all_.end(), Superpixel{});
}

void Superpixels::divide(const PixelFeatures& features, const std::vector<std::uint16_t>& known,
                         RowBands& bands) {
    seed(features, known);
    sums_.resize(static_cast<std::size_t>(bands.threads()));
    const int rounds = is_new_ ? first_rounds : later_rounds;
    for (int round = 0; round < rounds; ++round) {
        for (auto& sums : sums_) sums.assign(all_.size(), Sums{});
        bands.for_each_band(height_, 1, [&](const RowBand& band) {
            assign(features, known, band);
            add_up(features, band);
        });
        for (std::size_t k = 0; k < all_.size(); ++k) update(k);
    }
    is_new_ = false;
}

/// A superpixel without pixels, or out of its cell, begins at the surface pixel next to the cell's middle.
void Superpixels::seed(const PixelFeatures& features, const std::vector<std::uint16_t>& known) {
    for (int row = 0; row < rows_; ++row)
        for (int column = 0; column < columns_; ++column) {
            Superpixel& one = all_[static_cast<std::size_t>(row * columns_ + column)];
            const int x0 = column_ends_[static_cast<std::size_t>(column)],
                      x1 = column_ends_[static_cast<std::size_t>(column) + 1],
                      y0 = row_ends_[static_cast<std::size_t>(row)],
                      y1 = row_ends_[static_cast<std::size_t>(row) + 1];
            const int middle_x = (x0 + x1) / 2, middle_y = (y0 + y1) / 2, reach = side_ * 3 / 4 + 1;
            if (one.pixels > 0 && std::abs(one.x - middle_x) <= reach && std::abs(one.y - middle_y) <= reach)
                continue;
            one = {};
            int nearest = std::numeric_limits<int>::max();
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x) {
                    const int dx = x - middle_x, dy = y - middle_y, distance = dx * dx + dy * dy;
                    const std::size_t k = features.place(x, y);
                    if (distance >= nearest || !features.has_surface(k)) continue;
                    nearest = distance;
                    one = {x,
                           y,
                           1,
                           features.brightness[k],
                           features.red_green[k],
                           features.yellow_blue[k],
                           features.depth[k]};
                    one.label = known[k];
                }
        }
}

/// Works cell by cell of a row: all pixels of a cell have the same superpixels to choose from.
void Superpixels::assign(const PixelFeatures& features, const std::vector<std::uint16_t>& known,
                         const RowBand& band) {
    const std::int32_t per_place = std::max(1, (place_weight << place_bits) / (side_ * side_));
    std::vector<std::int32_t> nearest(static_cast<std::size_t>(width_));
    for (int y = band.first; y < band.last; ++y) {
        const int row = row_of_y_[static_cast<std::size_t>(y)];
        const std::size_t begin = features.place(0, y);
        std::fill(nearest.begin(), nearest.end(), std::numeric_limits<std::int32_t>::max());
        std::uint16_t* chosen = &of_pixels_[begin];
        std::fill(chosen, chosen + width_, none);
        const std::int16_t *brightness = &features.brightness[begin], *red_green = &features.red_green[begin],
                           *yellow_blue = &features.yellow_blue[begin];
        const std::int32_t* depth = &features.depth[begin];
        const std::uint16_t* labels = &known[begin];
        for (int column = 0; column < columns_; ++column)
            for (int other_row = std::max(0, row - 1); other_row <= std::min(rows_ - 1, row + 1); ++other_row)
                for (int other = std::max(0, column - 1); other <= std::min(columns_ - 1, column + 1);
                     ++other) {
                    const auto k = static_cast<std::uint16_t>(other_row * columns_ + other);
                    const Superpixel& one = all_[k];
                    if (one.pixels == 0) continue;
                    const std::int32_t dy = y - one.y, row_place = dy * dy,
                                       row_depth = (one.depth << 8) + one.slope_y * dy;
                    const std::uint16_t own = one.label == 0 ? std::uint16_t{0xFFFF} : one.label;
                    const int end = column_ends_[static_cast<std::size_t>(column) + 1];
                    for (int x = column_ends_[static_cast<std::size_t>(column)]; x < end; ++x) {
                        const std::int32_t dx = x - one.x, db = brightness[x] - one.brightness,
                                           dr = red_green[x] - one.red_green,
                                           dq = yellow_blue[x] - one.yellow_blue;
                        const std::int32_t dz = std::clamp(depth[x] - ((row_depth + one.slope_x * dx) >> 8),
                                                           -most_depth, most_depth);
                        std::int32_t distance = db * db + dr * dr + dq * dq + dz * dz +
                                                ((per_place * (dx * dx + row_place)) >> place_bits);
                        distance -= labels[x] == own ? distance >> 2 : 0;
                        const bool is_nearer = distance < nearest[static_cast<std::size_t>(x)];
                        nearest[static_cast<std::size_t>(x)] =
                            is_nearer ? distance : nearest[static_cast<std::size_t>(x)];
                        chosen[x] = is_nearer ? k : chosen[x];
                    }
                }
        for (int x = 0; x < width_; ++x)
            if (depth[x] == PixelFeatures::no_surface) chosen[x] = none;
    }
}

void Superpixels::add_up(const PixelFeatures& features, const RowBand& band) {
    std::vector<Sums>& sums = sums_[static_cast<std::size_t>(band.thread)];
    for (int y = band.first; y < band.last; ++y)
        for (int x = 0; x < width_; ++x) {
            const std::size_t k = features.place(x, y);
            const std::uint16_t one = of_pixels_[k];
            if (one == none) continue;
            const int row = one / columns_, column = one % columns_;
            const std::int64_t dx = x - column_ends_[static_cast<std::size_t>(column)],
                               dy = y - row_ends_[static_cast<std::size_t>(row)], z = features.depth[k];
            sums[one] += {1,
                          dx,
                          dy,
                          features.brightness[k],
                          features.red_green[k],
                          features.yellow_blue[k],
                          z,
                          dx * dx,
                          dx * dy,
                          dy * dy,
                          dx * z,
                          dy * z,
                          z * z};
        }
}

/// Finds means, and the plane of least squares, a little flatter if there are few pixels.
void Superpixels::update(std::size_t k) {
    Sums sums{};
    for (const auto& of_thread : sums_) sums += of_thread[k];
    Superpixel& one = all_[k];
    one.pixels = static_cast<std::int32_t>(sums.pixels);
    if (sums.pixels == 0) return;
    const std::int64_t n = sums.pixels;
    const auto mean = [n](std::int64_t sum) { return static_cast<std::int32_t>(sum / n); };
    one.brightness = mean(sums.brightness);
    one.red_green = mean(sums.red_green);
    one.yellow_blue = mean(sums.yellow_blue);
    const std::int32_t dx = mean(sums.x), dy = mean(sums.y);
    one.x = dx + column_ends_[k % static_cast<std::size_t>(columns_)];
    one.y = dy + row_ends_[k / static_cast<std::size_t>(columns_)];
    /// 16 times the covariance; the mean of z, which is large, is subtracted first.
    const std::int64_t z = sums.z / n;
    const auto covariance = [n](std::int64_t sum, std::int64_t a, std::int64_t b) {
        return 16 * (sum - a * b / n) / n;
    };
    const std::int64_t rest = sums.z - z * n, xz = covariance(sums.xz - z * sums.x, sums.x, rest),
                       yz = covariance(sums.yz - z * sums.y, sums.y, rest),
                       zz = covariance(sums.zz - 2 * z * sums.z + z * z * n, rest, rest);
    const std::int64_t firm = 1 + side_ * side_ / 50;
    const std::int64_t xx = covariance(sums.xx, sums.x, sums.x) + firm,
                       yy = covariance(sums.yy, sums.y, sums.y) + firm,
                       xy = covariance(sums.xy, sums.x, sums.y);
    const std::int64_t determinant = std::max<std::int64_t>(1, xx * yy - xy * xy);
    const auto slope = [&](std::int64_t number) {
        return static_cast<std::int32_t>(std::clamp(256 * number / determinant, -steepest, steepest));
    };
    one.slope_x = slope(xz * yy - yz * xy);
    one.slope_y = slope(yz * xx - xz * xy);
    const std::int64_t explained = (one.slope_x * xz + one.slope_y * yz) / 256;
    one.noise = static_cast<std::int32_t>(std::clamp<std::int64_t>((zz - explained) / 16, 0, 1 << 20));
    one.spread = static_cast<std::int32_t>(std::max<std::int64_t>(1, std::min(xx, yy) / 16));
    // Depth at the integer pixel of the middle.
    one.depth = static_cast<std::int32_t>(
        z + rest / n + ((one.slope_x * (dx * n - sums.x) + one.slope_y * (dy * n - sums.y)) / (n * 256)));
}

}  // namespace touchable
