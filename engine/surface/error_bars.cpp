// SPDX-License-Identifier: Apache-2.0
// How wrong the direction and the size of a force on a frame's surface may be: 95 of 100 are not more wrong.
//
// A camera's errors show on its filtered surface. Noise scatters the faces of a block of 5x5; where filters
// smoothed it, whole blocks lean against the 3x3 around them; and errors that are wide and stay, of a lens or
// an unwrapped phase, bend 25 pixels against 85. A scene bends, too, but not everywhere: so the bend that 15
// of 100 places stay below is taken for the camera's. It grows with depth and with the slope of the surface,
// as an error along a ray turns a face. ErrorSigns::weights are fitted to cameras with known errors
// (docs/measurements.md, Error bars; bench/real/error_bars.cpp).
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <queue>
#include <utility>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/vectors.hpp"
#include "engine/surface/inverse_depths.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

constexpr int side = ErrorSigns::side;
/// Reach of means over 5x5 and 17x17 blocks, blocks.
constexpr int bend_reach = 2, wide_reach = 8;
/// Blocks that tell a camera's bend: whole enough, and not seen from the side.
constexpr float whole_enough = 15;
constexpr double least_cosine = 0.2;
constexpr double share_of_scene = 0.15;
constexpr std::size_t least_blocks = 100;
constexpr double enough_bends = 3000;
/// Of larger pictures, every second row of blocks is measured, or every third, ..., and stands for those
/// around it: 5 % of a core.
constexpr int enough_pixels = 2 * 720 * 480;
/// Strips lie farther apart than blocks: fitted so that bars hold as often on the same cameras.
constexpr float strip_weight = 4;
constexpr std::size_t drift_step = 3;
constexpr double most_drift = 0.02;  // more is a cut

/// Rows of sums over faces: of unit normals, inverse planar depths, and their number.
struct Sums {
    std::vector<float> x, y, z, q, faces;
    void assign(std::size_t count) {
        for (auto* sums : {&x, &y, &z, &q, &faces}) sums->assign(count, 0.0F);
    }
};

struct Lens {
    float fx, fy, cx, up;  // up: from the row to cy
};

/// Adds the unit normals of the faces between two rows of inverse depths (0: invalid). (x, y, q) of a flat
/// surface is flat, too: its normal is linear in q and its slopes.
[[gnu::always_inline]] inline void add_faces(int width, const Lens& lens, const float* __restrict upper,
                                             const float* __restrict lower, float* __restrict x_sum,
                                             float* __restrict y_sum, float* __restrict z_sum,
                                             float* __restrict q_sum, float* __restrict faces) {
    for (int x = 0; x < width; ++x) {
        const float q = upper[x], right = upper[x + 1], down = lower[x];
        const float least = std::min(q, std::min(right, down));
        const float nx = (q - right) * lens.fx, ny = (down - q) * lens.fy;
        const float nz = q + (right - q) * (lens.cx - static_cast<float>(x)) + (down - q) * lens.up;
        const float face = least > 0 ? 1.0F : 0.0F;
        const float scale = face / std::sqrt(nx * nx + ny * ny + nz * nz + (1 - face));
        x_sum[x] += nx * scale;
        y_sum[x] += ny * scale;
        z_sum[x] += nz * scale;
        q_sum[x] += q * face;
        faces[x] += face;
    }
}

/// A row of blocks, and the blocks around it: `pitch` floats to the row below. `weight`: of its own blocks
/// beside a block, over those above and below.
struct BlockRow {
    const float *x, *y, *z, *q, *faces;
    std::ptrdiff_t pitch;
    float weight;
};

[[gnu::always_inline]] inline float sum_around(const float* at, const BlockRow& row) {
    const float *above = at - row.pitch, *below = at + row.pitch;
    return (above[-1] + above[0] + above[1]) + row.weight * (at[-1] + at[0] + at[1]) +
           (below[-1] + below[0] + below[1]);
}

/// `u`, `v`: of the rays through the blocks' middles.
[[gnu::always_inline]] inline void tell_blocks(int columns, const BlockRow& row, const float* __restrict u,
                                               float v, float fx, ErrorSigns::Block* __restrict out) {
    for (int c = 0; c < columns; ++c) {
        const float x = row.x[c], y = row.y[c], z = row.z[c], faces = row.faces[c];
        const float some = faces > 0 ? 1.0F : 0.0F, none = 1 - some;
        const float length = std::sqrt(x * x + y * y + z * z + none), count = faces + none;
        const float q = row.q[c] + none;
        const float around_x = sum_around(row.x + c, row), around_y = sum_around(row.y + c, row),
                    around_z = sum_around(row.z + c, row);
        const float around =
            std::sqrt(around_x * around_x + around_y * around_y + around_z * around_z + none);
        const float lean_x = x / length - around_x / around, lean_y = y / length - around_y / around,
                    lean_z = z / length - around_z / around;
        const float scatter = 2 - 2 * length / count, along = x * u[c] + y * v - z;
        out[c].depth = some * count / q;
        out[c].scatter = some * (scatter > 0 ? scatter : 0.0F);
        out[c].lean = std::sqrt(lean_x * lean_x + lean_y * lean_y + lean_z * lean_z);
        out[c].turn = along * along / (length * length * (1 + u[c] * u[c] + v * v)) * fx * q / count;
    }
}

class Ruler {
public:
    explicit Ruler(const Scene& scene)
        : camera_(scene.camera),
          columns_((scene.width - 1) / side),
          rows_((scene.height - 1) / side),
          width_(columns_ * side),
          row_step_(std::max(1, scene.width * scene.height / enough_pixels)),
          strips_((rows_ + row_step_ - 1) / row_step_),
          bend_step_(std::max(1, static_cast<int>(std::sqrt(columns_ * strips_ / enough_bends)))),
          depths_(camera_, width_ + 1) {
        for (int c = 0; c < columns_; ++c)
            u_of_blocks_.push_back(static_cast<float>(camera_.u(middle_of(c))));
    }

    void measure(SurfaceFrame& frame, const RawFrame::Place& place) {
        ErrorSigns& signs = frame.signs;
        if (frame.codes.empty()) return signs.blocks.clear();  // it is built when it is read
        add_up(frame);
        signs.columns = columns_;
        signs.focal_length = camera_.fx;
        signs.blocks.resize(pixel_place(0, rows_, columns_));
        for (int strip = 0; strip < strips_; ++strip) {
            const int first = strip * row_step_, end = std::min(first + row_step_, rows_);
            const std::size_t at = padded(0, strip);
            const BlockRow blocks{&blocks_.x[at],
                                  &blocks_.y[at],
                                  &blocks_.z[at],
                                  &blocks_.q[at],
                                  &blocks_.faces[at],
                                  columns_ + 2,
                                  row_step_ > 1 ? strip_weight : 1};
            ErrorSigns::Block* const out = signs.blocks.data() + pixel_place(0, first, columns_);
            run_vectors(
                usable_vector_units().front(), [&](auto) __attribute__((always_inline)) {
                    tell_blocks(columns_, blocks, u_of_blocks_.data(),
                                static_cast<float>(camera_.v(middle_of(row_of(strip)))),
                                static_cast<float>(camera_.fx), out);
                });
            for (int row = first + 1; row < end; ++row)
                std::copy_n(out, columns_, out + pixel_place(0, row - first, columns_));
        }
        signs.bend = camera_bend(signs.blocks);
        signs.drift = camera_drift(signs.blocks, place);
    }

private:
    /// The row of blocks that is measured for a strip of `row_step_` of them.
    int row_of(int strip) const { return std::min(strip * row_step_ + row_step_ / 2, rows_ - 1); }
    static double middle_of(int block) { return block * side + 0.5 * (side - 1); }
    /// Place in `blocks_`, which has a block without faces more at each end of rows and columns.
    std::size_t padded(int column, int strip) const {
        return pixel_place(column + 1, strip + 1, columns_ + 2);
    }

    void add_row(int y) {
        const Lens lens{static_cast<float>(camera_.fx), static_cast<float>(camera_.fy),
                        static_cast<float>(camera_.cx), static_cast<float>(camera_.cy - y)};
        run_vectors(
            usable_vector_units().front(), [&](auto) __attribute__((always_inline)) {
                add_faces(width_, lens, upper_.data(), lower_.data(), sums_.x.data(), sums_.y.data(),
                          sums_.z.data(), sums_.q.data(), sums_.faces.data());
            });
    }

    void add_up(const SurfaceFrame& frame) {
        blocks_.assign(pixel_place(0, strips_ + 2, columns_ + 2));
        for (int strip = 0; strip < strips_; ++strip) {
            const int row = row_of(strip);
            if (strip == 0 || row_step_ > 1) depths_.read_row(frame, row * side, lower_);
            sums_.assign(static_cast<std::size_t>(width_));
            for (int y = row * side; y < (row + 1) * side; ++y) {
                std::swap(upper_, lower_);
                depths_.read_row(frame, y + 1, lower_);
                add_row(y);
            }
            for (const auto& [from, to] : {std::pair{&sums_.x, &blocks_.x},
                                           {&sums_.y, &blocks_.y},
                                           {&sums_.z, &blocks_.z},
                                           {&sums_.q, &blocks_.q},
                                           {&sums_.faces, &blocks_.faces}}) {
                const float* at = from->data();
                float* const block = to->data() + padded(0, strip);
                for (int c = 0; c < columns_; ++c, at += side)
                    block[c] = (at[0] + at[1]) + (at[2] + at[3]) + at[4];
            }
        }
    }

    /// Scene units per pixel.
    double camera_bend(const std::vector<ErrorSigns::Block>& signs) {
        const auto pitch = static_cast<std::size_t>(columns_) + 1;
        normals_to_.resize(pitch * static_cast<std::size_t>(strips_));
        for (int strip = 0; strip < strips_; ++strip) {
            glm::dvec3 sum(0.0);
            const std::size_t from = padded(0, strip);
            glm::dvec3* const to = normals_to_.data() + pitch * static_cast<std::size_t>(strip);
            to[0] = sum;
            for (std::size_t c = 0; c + 1 < pitch; ++c)
                to[c + 1] = sum += glm::dvec3(blocks_.x[from + c], blocks_.y[from + c], blocks_.z[from + c]);
        }
        const auto mean_around = [&](int column, int strip, int reach) {
            const int far = (reach + row_step_ - 1) / row_step_;
            const auto left = static_cast<std::size_t>(std::max(column - reach, 0)),
                       right = static_cast<std::size_t>(std::min(column + reach + 1, columns_));
            glm::dvec3 sum(0.0);
            for (int s = std::max(strip - far, 0); s < std::min(strip + far + 1, strips_); ++s) {
                const glm::dvec3* const at = normals_to_.data() + pitch * static_cast<std::size_t>(s);
                sum += at[right] - at[left];
            }
            return glm::normalize(sum);
        };
        std::vector<double>& bends = scratch_;
        bends.clear();
        for (int strip = 0; strip < strips_; strip += bend_step_)
            for (int column = 0; column < columns_; column += bend_step_) {
                const ErrorSigns::Block& block = signs[pixel_place(column, strip * row_step_, columns_)];
                if (blocks_.faces[padded(column, strip)] < whole_enough) continue;
                const double turn = block.turn, pixel = block.depth / camera_.fx;
                if (turn * pixel < least_cosine * least_cosine) continue;
                bends.push_back(glm::distance(mean_around(column, strip, bend_reach),
                                              mean_around(column, strip, wide_reach)) /
                                turn);
            }
        if (bends.size() < least_blocks) return std::numeric_limits<double>::quiet_NaN();
        return sorted_element(bends,
                              static_cast<std::size_t>(share_of_scene * static_cast<double>(bends.size())));
    }

    /// By how much of their depth whole frames come nearer or go farther away by themselves. Motion does so,
    /// too, but steadily: the median ratio of a frame's depths to the last frame's is compared with the one
    /// before.
    double camera_drift(const std::vector<ErrorSigns::Block>& signs, const RawFrame::Place& place) {
        const auto last = std::exchange(last_, place);
        if (!last || last->epoch != place.epoch || last->number >= place.number) {
            before_.clear();
            drift_ = 0;
            ratios_ = 0;
        }
        std::vector<double>& ratios = scratch_;
        ratios.clear();
        before_.resize(signs.size());
        for (std::size_t k = 0; k < signs.size(); k += drift_step) {
            const float now = signs[k].depth;
            if (now > 0 && before_[k] > 0)
                ratios.push_back(static_cast<double>(now) / static_cast<double>(before_[k]));
            before_[k] = now;
        }
        if (ratios.size() < least_blocks) return 0;
        const double ratio = 1 + (sorted_element(ratios, ratios.size() / 2) - 1) /
                                     static_cast<double>(place.number - last->number);
        const double turn = ratio - std::exchange(ratio_, ratio);
        if (++ratios_ < 2 || std::abs(turn) > most_drift) return std::sqrt(drift_);
        drift_ += (turn * turn / 6 - drift_) / std::min(ratios_ - 1, 16);
        return std::sqrt(drift_);
    }

    Camera camera_;
    int columns_, rows_, width_, row_step_, strips_, bend_step_;
    InverseDepths depths_;
    std::vector<float> u_of_blocks_;  // of rays
    std::vector<float> upper_, lower_;
    Sums sums_, blocks_;                  // of columns of `side` faces; of blocks
    std::vector<glm::dvec3> normals_to_;  // of a row's blocks up to a column
    std::vector<double> scratch_;
    std::vector<float> before_;  // depths of the last frame's blocks
    std::optional<RawFrame::Place> last_;
    double ratio_ = 1, drift_ = 0;
    int ratios_ = 0;
};

class MeasuringBuilder final : public SurfaceBuilder {
public:
    MeasuringBuilder(std::unique_ptr<SurfaceBuilder> builder, const Scene& scene)
        : builder_(std::move(builder)), ruler_(scene) {}

    std::string_view name() const override { return builder_->name(); }
    int frames_in_flight() const override { return builder_->frames_in_flight(); }
    double built_share() const override { return builder_->built_share(); }
    Result<void> begin(const RawFrame& raw) override {
        TRY(builder_->begin(raw));
        begun_.emplace(raw);
        return {};
    }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        TRY(builder_->build(raw, out));
        ruler_.measure(out, RawFrame::Place(raw));
        return {};
    }
    Result<void> finish(SurfaceFrame& out) override {
        const RawFrame::Place place = begun_.front();
        begun_.pop();
        TRY(builder_->finish(out));
        ruler_.measure(out, place);
        return {};
    }

private:
    std::unique_ptr<SurfaceBuilder> builder_;
    std::queue<RawFrame::Place> begun_;
    Ruler ruler_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> with_error_bars(std::unique_ptr<SurfaceBuilder> builder, const Scene& scene) {
    return std::make_unique<MeasuringBuilder>(std::move(builder), scene);
}

}  // namespace touchable
