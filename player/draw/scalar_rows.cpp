#include "player/draw/scalar_rows.hpp"

#include <algorithm>
#include <limits>

#include "player/draw/drawn_vertex.hpp"
#include "shaders/blend_rule.h"

// Compiled without errno and traps: the loops below become vectors where they look nothing up.

namespace touchable {
namespace {

constexpr float no_value = std::numeric_limits<float>::quiet_NaN();

/// Which byte of a haptic pixel.
int channel_of(Scalar scalar) {
    return scalar == Scalar::stiffness ? 0 : scalar == Scalar::static_friction ? 1 : 2;
}

}  // namespace

void ScalarRows::begin(Scalar scalar, const HeightField& field, const FramePair& pair) {
    const Scene& scene = field.scene();
    scalar_ = scalar;
    field_ = &field;
    blend_ = static_cast<float>(field.blend());
    height_per_code_ =
        static_cast<float>(largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max);
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

void ScalarRows::read_frame(Frame& frame, int y) const {
    read_validity(frame, y);
    if (reading_ == Scalar::depth) return read_depths(frame, y, frame.values);
    if (reading_ != Scalar::height) return read_properties(frame, y);
    read_heights(frame, y);
    if (next_.frame) read_depths(frame, y, frame.lengths);
}

/// Depth and height of a pixel are those of the nearer frame, which says whether it is valid, where it is
/// valid in one frame alone or there is nothing half-way; properties are of both.
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

/// Where every pixel has depth up to one away, in both frames: there no stiffness is that of a hole. False
/// where nothing quick tells.
bool ScalarRows::find_whole(int y) {
    if (!prev_.codes || (next_.frame && !next_.codes)) return false;
    const int words = prev_.codes->validity_words_per_row();
    whole_.assign(static_cast<std::size_t>(words), y > 0 && y + 1 < field_->height() ? ~0U : 0U);
    if (whole_[0] == 0) return true;
    for (const SurfaceFrame* frame : {prev_.codes, next_.frame ? next_.codes : prev_.codes})
        for (int row = y - 1; row <= y + 1; ++row)
            for (int k = 0; k < words; ++k)
                whole_[static_cast<std::size_t>(k)] &= frame->validity_row(row)[k];
    std::uint32_t left = 0;  // of what lies beyond the picture nothing has depth
    for (std::size_t k = 0; k < whole_.size(); ++k) {
        const std::uint32_t here = whole_[k], right = k + 1 < whole_.size() ? whole_[k + 1] : 0;
        whole_[k] = here & (here << 1 | left >> 31) & (here >> 1 | right << 31);
        left = here;
    }
    const int last = field_->width() - 1;
    whole_[static_cast<std::size_t>(last >> 5)] &= ~(1U << (last & 31));
    return true;
}

/// Stiffness at and beside what has no depth, in a scene that says how stiff holes are.
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

}  // namespace touchable
