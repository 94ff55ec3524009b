// SPDX-License-Identifier: Apache-2.0
#include "player/draw/overlay_rows.hpp"

#include <bit>

#include "player/view/drawn_surface.hpp"
#include "shaders/blend_rule.h"
#include "shaders/cut_rule.h"

// Compiled without errno and floating-point traps: loops below without table look-ups are auto-vectorised.

namespace touchable {
namespace {

constexpr float no_value = std::numeric_limits<float>::quiet_NaN();

/// The byte of a haptic pixel.
int channel_of(Scalar scalar) {
    return scalar == Scalar::stiffness ? 0 : scalar == Scalar::static_friction ? 1 : 2;
}

// A bin's key is the leading bits of a positive float, twelve of them of its fraction: they grow with its
// value, so bins have the same relative width at every depth, without computing a logarithm.
constexpr int fraction_bits_left = 23 - 12;

std::uint32_t key_of(float depth) {
    return std::bit_cast<std::uint32_t>(depth) >> fraction_bits_left;
}

/// Change of q per pixel, from those of the two neighbours that belong to the same surface.
[[gnu::always_inline]] inline float slope(float before, float here, float after) {
    const auto joined = [here](float other) __attribute__((always_inline)) {
        const float least = other < here ? other : here, greatest = other < here ? here : other;
        return least > 0.0F && greatest <= CUT_RULE_RATIO * least ? 1.0F : 0.0F;
    };
    const float with_before = joined(before), with_after = joined(after), count = with_before + with_after;
    const float sum = with_before * (here - before) + with_after * (after - here);
    return count > 1.5F ? 0.5F * sum : sum;
}

}  // namespace

PackedColour hole_colour(int x, int y) {
    return ((x + y) & 7) < 4 ? pack_colour(112, 112, 112) : pack_colour(150, 150, 150);
}

void ScalarRows::begin(Scalar scalar, const HeightField& field, const FramePair& pair) {
    scalar_ = scalar;
    field_ = &field;
    blend_ = static_cast<float>(field.blend());
    height_per_code_ = static_cast<float>(height_per_code(field.scene()));
    reach_ = blend_reach(field);
    begin_frame(prev_, pair.prev.frame);
    begin_frame(next_, blend_ > 0 && pair.next.frame != pair.prev.frame ? pair.next.frame : nullptr);
}

void ScalarRows::begin_frame(Frame& frame, const SurfaceFrame* of) {
    frame.frame = of;
    if (!of) return;
    const auto columns = static_cast<std::size_t>(field_->width());
    frame.lengths.resize(columns);
    frame.values.resize(columns);
    frame.valid.resize(columns);
    frame.codes = of->vertices->read_from();
    if (scalar_ == Scalar::errors) return;
    if (scalar_ != Scalar::depth && scalar_ != Scalar::height) return make_properties(frame);
    if (!frame.codes) return;
    const DepthCoding& coding = frame.codes->coding;
    if (!frame.depths.empty() && coding == frame.coding) return;
    frame.coding = coding;
    frame.depths.resize(65536);
    const std::size_t last = std::max(coding.valid_max, coding.code_max);
    for (std::size_t code = 0; code < frame.depths.size(); ++code)
        frame.depths[code] =
            code <= last ? static_cast<float>(coding.depth(static_cast<std::uint16_t>(code))) : no_value;
}

void ScalarRows::make_properties(Frame& frame) const {
    const Scene& scene = field_->scene();
    for (std::size_t p = 0; p < 256; ++p) {
        const auto byte = static_cast<std::uint8_t>(p);
        const HapticProperties felt =
            frame.frame->haptic.empty() ? scene.default_properties : scene.haptic.at(byte, byte, byte);
        const double of[] = {felt.stiffness, felt.static_friction, felt.dynamic_friction};
        frame.property[p] = static_cast<float>(of[channel_of(scalar_)]);
        frame.static_friction[p] = static_cast<float>(felt.static_friction);
    }
}

void ScalarRows::read_validity(Frame& frame, int y) const {
    const int width = field_->width();
    std::uint8_t* valid = frame.valid.data();
    if (frame.codes) {
        const std::uint32_t* bits = frame.codes->validity_row(y);
        for (int x = 0; x < width; ++x) valid[x] = static_cast<std::uint8_t>(bits[x >> 5] >> (x & 31) & 1U);
    } else {
        for (int x = 0; x < width; ++x) valid[x] = frame.frame->vertices->at(x, y).valid ? 1 : 0;
    }
}

void ScalarRows::read_depths(Frame& frame, int y, std::vector<float>& to) const {
    const int width = field_->width();
    float* values = to.data();
    if (frame.codes) {
        const std::uint16_t* codes = frame.codes->codes.data() + frame.codes->index(0, y);
        const float* depths = frame.depths.data();
        for (int x = 0; x < width; ++x) values[x] = depths[codes[x]];
    } else {
        for (int x = 0; x < width; ++x) values[x] = static_cast<float>(frame.frame->vertices->at(x, y).depth);
    }
    if (frame.frame->heights.empty()) return;
    const std::uint16_t* heights = frame.frame->heights.data() + frame.frame->index(0, y);
    const float per_code = height_per_code_;
    for (int x = 0; x < width; ++x) values[x] -= per_code * static_cast<float>(heights[x]);
}

void ScalarRows::read_properties(Frame& frame, int y) const {
    const int width = field_->width(), channel = channel_of(reading_);
    const float* of_byte =
        (reading_ == Scalar::static_friction ? frame.static_friction : frame.property).data();
    float* values = frame.values.data();
    if (frame.frame->haptic.empty()) {
        std::fill_n(values, width, of_byte[0]);
        return;
    }
    const std::uint8_t* bytes = frame.frame->haptic.data() + 3 * frame.frame->index(0, y) + channel;
    for (int x = 0; x < width; ++x) values[x] = of_byte[bytes[3 * x]];
}

void ScalarRows::read_heights(Frame& frame, int y) const {
    const int width = field_->width();
    float* values = frame.values.data();
    if (frame.frame->heights.empty()) {
        std::fill_n(values, width, 0.0F);
        return;
    }
    const std::uint16_t* heights = frame.frame->heights.data() + frame.frame->index(0, y);
    const float per_code = height_per_code_;
    for (int x = 0; x < width; ++x) values[x] = per_code * static_cast<float>(heights[x]);
}

void ScalarRows::read_errors(Frame& frame, int y) const {
    const int width = field_->width();
    for (int x = 0; x < width; x += ErrorSigns::side)
        std::fill_n(frame.values.data() + x, std::min(ErrorSigns::side, width - x),
                    static_cast<float>(field_->error_bar(x, y).degrees));
}

void ScalarRows::read_frame(Frame& frame, int y) const {
    read_validity(frame, y);
    if (reading_ == Scalar::errors) return read_errors(frame, y);
    if (reading_ == Scalar::depth) return read_depths(frame, y, frame.values);
    if (reading_ != Scalar::height) return read_properties(frame, y);
    read_heights(frame, y);
    if (next_.frame) read_depths(frame, y, frame.lengths);
}

/// Depth and height use the nearer frame's value if only one frame is valid at a pixel or the surface is not
/// interpolated there; the nearer frame decides validity. Other properties are always interpolated.
void ScalarRows::mix(float* values) const {
    const int width = field_->width();
    const bool of_valid = reading_ == Scalar::depth || reading_ == Scalar::height;
    const float blend = blend_;
    const Frame& nearer = blend >= 0.5F ? next_ : prev_;
    const float *from = prev_.values.data(), *to = next_.values.data(), *near = nearer.values.data();
    const std::uint8_t *before = prev_.valid.data(), *after = next_.valid.data(),
                       *valid = nearer.valid.data();
    const bool of_depth = reading_ == Scalar::depth;
    const float *one = of_depth ? from : prev_.lengths.data(), *other = of_depth ? to : next_.lengths.data();
    for (int x = 0; x < width; ++x) {
        const float mixed = from[x] + (to[x] - from[x]) * blend;
        const bool mixes = before[x] == after[x] && depths_mix(one[x], other[x], reach_);
        const float value = of_valid && !mixes ? near[x] : mixed;
        values[x] = valid[x] != 0 ? value : no_value;
    }
}

/// Sets the bits of pixels that have depth, with all neighbours, in both frames: no hole affects their
/// stiffness. False if a frame has no validity bits.
bool ScalarRows::find_whole(int y) {
    if (!prev_.codes || (next_.frame && !next_.codes)) return false;
    const int words = prev_.codes->validity_words_per_row();
    whole_.assign(static_cast<std::size_t>(words), y > 0 && y + 1 < field_->height() ? ~0U : 0U);
    if (whole_[0] == 0) return true;
    for (const SurfaceFrame* frame : {prev_.codes, next_.frame ? next_.codes : prev_.codes})
        for (int row = y - 1; row <= y + 1; ++row)
            for (int k = 0; k < words; ++k)
                whole_[static_cast<std::size_t>(k)] &= frame->validity_row(row)[k];
    std::uint32_t left = 0;  // beyond the picture nothing has depth
    for (std::size_t k = 0; k < whole_.size(); ++k) {
        const std::uint32_t here = whole_[k], right = k + 1 < whole_.size() ? whole_[k + 1] : 0;
        whole_[k] = here & (here << 1 | left >> 31) & (here >> 1 | right << 31);
        left = here;
    }
    const int last = field_->width() - 1;
    whole_[static_cast<std::size_t>(last >> 5)] &= ~(1U << (last & 31));
    return true;
}

/// Stiffness at and beside holes, in a scene that defines hole stiffness.
void ScalarRows::stiffen_holes(int y, float* values) {
    const bool known = find_whole(y);
    for (int x = 0; x < field_->width(); ++x) {
        if (known && (whole_[static_cast<std::size_t>(x >> 5)] >> (x & 31) & 1U) != 0) continue;
        if (values[x] == values[x]) values[x] = static_cast<float>(field_->stiffness(x, y, 0, 0));
    }
}

void ScalarRows::read_moment(Scalar scalar, int y, float* values) {
    reading_ = scalar;
    read_frame(prev_, y);
    if (next_.frame) {
        read_frame(next_, y);
        return mix(values);
    }
    const float* of_prev = prev_.values.data();
    const std::uint8_t* valid = prev_.valid.data();
    for (int x = 0; x < field_->width(); ++x) values[x] = valid[x] != 0 ? of_prev[x] : no_value;
}

void ScalarRows::mark_filled(const Frame& frame, int y, std::uint8_t* states) const {
    if (!frame.frame->filled) return;
    const int words = frame.frame->validity_words_per_row();
    const std::uint32_t* bits = frame.frame->filled->data() + std::ptrdiff_t{y} * words;
    for (int x = 0; x < field_->width(); ++x)
        if (states[x] != 0 && frame.valid[static_cast<std::size_t>(x)] != 0 &&
            (bits[x >> 5] >> (x & 31) & 1U) != 0)
            states[x] = 3;
}

void ScalarRows::read_validity(int y, std::uint8_t* states) {
    read_validity(prev_, y);
    const std::uint8_t* before = prev_.valid.data();
    const int width = field_->width();
    if (!next_.frame) {
        std::copy_n(before, width, states);
        return mark_filled(prev_, y, states);
    }
    read_validity(next_, y);
    const std::uint8_t *after = next_.valid.data(), *now = blend_ >= 0.5F ? after : before;
    for (int x = 0; x < width; ++x)
        states[x] = static_cast<std::uint8_t>(now[x] + (now[x] & (before[x] ^ after[x])));
    mark_filled(prev_, y, states);
    mark_filled(next_, y, states);
}

void ScalarRows::read(int y, float* values) {
    read_moment(scalar_, y, values);
    if (scalar_ == Scalar::stiffness && field_->scene().hole_stiffness) stiffen_holes(y, values);
    if (scalar_ != Scalar::dynamic_friction) return;
    static_frictions_.resize(static_cast<std::size_t>(field_->width()));
    read_moment(Scalar::static_friction, y, static_frictions_.data());
    for (std::size_t x = 0; x < static_frictions_.size(); ++x)
        values[x] = std::min(values[x], static_frictions_[x]);
}

const Overlays::Range& SteadyRange::update(const Overlays::Range& seen, const HeightField& field) {
    const double passed_s = 1e-9 * (field.moment_ns() - moment_ns_);
    const double share = std::clamp(passed_s / narrowing_s, 0.0, 1.0);
    if (!range_ || field.epoch() != epoch_ || passed_s < 0) range_ = seen;
    range_->least = std::min(seen.least, range_->least + share * (seen.least - range_->least));
    range_->greatest = std::max(seen.greatest, range_->greatest + share * (seen.greatest - range_->greatest));
    moment_ns_ = field.moment_ns();
    epoch_ = field.epoch();
    return *range_;
}

void EqualisedDepth::update(std::span<const float> depths, const HeightField& field) {
    const std::uint32_t first = key_of(static_cast<float>(field.nearest_depth_anywhere())),
                        last = key_of(static_cast<float>(field.scene().depth.far));
    const std::size_t bins = std::max(first, last) - first + 1;
    const double passed_s = 1e-9 * (field.moment_ns() - moment_ns_);
    const bool is_new = bins != weights_.size() || first != first_ || field.epoch() != epoch_ || passed_s < 0;
    if (is_new) weights_.assign(bins, 0);
    first_ = first;
    moment_ns_ = field.moment_ns();
    epoch_ = field.epoch();
    const double share = is_new ? 1 : std::clamp(passed_s / adapting_s, 0.0, 1.0);
    if (!depths.empty() && share > 0) {
        const auto kept = static_cast<float>(1 - share), each = static_cast<float>(share) / depths.size();
        for (float& weight : weights_) weight *= kept;
        for (const float depth : depths)
            weights_[std::clamp(key_of(depth), first, first + static_cast<std::uint32_t>(bins) - 1) -
                     first] += each;
    }
    shares_.resize(bins);
    double nearer = 0;
    for (std::size_t k = 0; k < bins; ++k) {
        const auto weight = static_cast<double>(weights_[k]);
        shares_[k] = std::min(nearer + weight / 2, 1.0);
        nearer += weight;
    }
}

void EqualisedDepth::find_bins(const float* depths, int width, std::uint32_t* bins) const {
    const std::uint32_t first = first_, last = static_cast<std::uint32_t>(shares_.size()) - 1;
    for (int x = 0; x < width; ++x) {
        const std::uint32_t key = key_of(depths[x]), offset = key > first ? key - first : 0;
        bins[x] = depths[x] == depths[x] ? (offset < last ? offset : last) : last + 1;
    }
}

double EqualisedDepth::depth_at(double share) const {
    const auto at = std::ranges::lower_bound(shares_, share);
    const auto k =
        static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(at - shares_.begin(), std::ssize(shares_) - 1));
    const auto begin_of = [this](std::uint32_t bin) {
        return static_cast<double>(std::bit_cast<float>((first_ + bin) << fraction_bits_left));
    };
    return 0.5 * (begin_of(k) + begin_of(k + 1));
}

NormalRows::NormalRows(const Camera& camera, int width, int height, const float* q)
    : camera_(camera), width_(width), height_(height), q_(q) {
    const auto columns = static_cast<std::size_t>(width);
    u_.resize(columns);
    along_x_.resize(columns);
    along_y_.resize(columns);
    for (int x = 0; x < width; ++x) u_[static_cast<std::size_t>(x)] = static_cast<float>(camera.u(x));
}

void NormalRows::paint(int y, std::uint8_t* rgb) {
    const float* here = q_ + std::ptrdiff_t{y} * width_;
    const float* above = y > 0 ? here - width_ : here;
    const float* below = y + 1 < height_ ? here + width_ : here;
    float *along_x = along_x_.data(), *along_y = along_y_.data();
    const float* u = u_.data();
    // At the picture's edge the only neighbour counts fully, not half.
    const float edge = above == here || below == here ? 2.0F : 1.0F;
    for (int x = 0; x < width_; ++x) along_y[x] = edge * slope(above[x], here[x], below[x]);
    for (int x = 1; x < width_ - 1; ++x) along_x[x] = slope(here[x - 1], here[x], here[x + 1]);
    along_x[0] = width_ > 1 ? slope(0.0F, here[0], here[1]) : 0.0F;
    along_x[width_ - 1] = width_ > 1 ? slope(here[width_ - 2], here[width_ - 1], 0.0F) : 0.0F;
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const auto v = static_cast<float>(camera_.v(y));
    for (int x = 0; x < width_; ++x) {
        // Points P of a plane satisfy n P = 1; q = n (u, v, -1). The normal towards the camera is -n.
        const float nx = -fx * along_x[x], ny = fy * along_y[x], nz = here[x] + nx * u[x] + ny * v;
        const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
        const float scale = 127.5F / (length > 1e-30F ? length : 1e-30F);
        rgb[3 * x] = static_cast<std::uint8_t>(static_cast<int>(nx * scale + 128.0F));
        rgb[3 * x + 1] = static_cast<std::uint8_t>(static_cast<int>(ny * scale + 128.0F));
        rgb[3 * x + 2] = static_cast<std::uint8_t>(static_cast<int>(nz * scale + 128.0F));
    }
}

}  // namespace touchable
