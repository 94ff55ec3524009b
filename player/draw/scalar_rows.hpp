#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// What a pixel has one number of.
enum class Scalar { depth, stiffness, static_friction, dynamic_friction, height };

/// Reads a field row by row: depth and height as they are drawn (`drawn_vertex`), other numbers as the hand
/// meets them at the pixels, to a float's precision, by tables of what the frames' codes mean.
class ScalarRows {
public:
    /// `pair` is what `field` was made of; both are referred to by `read`, until the next call.
    void begin(Scalar scalar, const HeightField& field, const FramePair& pair);
    /// The numbers of row y, `field.width()`; NaN where
    /// the surface has no depth. Depth as the coding has it (range or planar), height taken off, and height:
    /// scene units. Stiffness N/m.
    void read(int y, float* values);
    /// Of each pixel of row y: 0 where the surface has no depth, 1 where both frames have it, 2 where one
    /// has, 3 where one of those that have it was given it by another frame of the clip.
    void read_validity(int y, std::uint8_t* states);
    /// Whether a frame was given any by others.
    bool has_filled() const {
        return prev_.frame->filled != nullptr || (next_.frame != nullptr && next_.frame->filled != nullptr);
    }
    /// Whether there are two frames between which the field is.
    bool is_between() const { return next_.frame != nullptr; }

private:
    /// One of the pair's frames.
    struct Frame {
        const SurfaceFrame* frame = nullptr;
        const SurfaceFrame* codes = nullptr;       // null: none, or not alone what depth is made of
        DepthCoding coding;                        // of `depths`
        std::vector<float> depths;                 // of each code
        std::array<float, 256> property{};         // of each value of the channel
        std::array<float, 256> static_friction{};  // likewise, where dynamic friction is asked for
        std::vector<float> lengths;                // of a row, height taken off, where they are asked for
        std::vector<float> values;                 // of a row
        std::vector<std::uint8_t> valid;           // likewise, 0 or 1
    };
    void begin_frame(Frame& frame, const SurfaceFrame* of);
    void make_properties(Frame& frame) const;
    void read_validity(Frame& frame, int y) const;
    void mark_filled(const Frame& frame, int y, std::uint8_t* states) const;
    void read_frame(Frame& frame, int y) const;
    void read_depths(Frame& frame, int y, std::vector<float>& to) const;
    void read_heights(Frame& frame, int y) const;
    void read_properties(Frame& frame, int y) const;
    void mix(float* values) const;
    void read_moment(Scalar scalar, int y, float* values);
    bool find_whole(int y);
    void stiffen_holes(int y, float* values);

    Scalar scalar_ = Scalar::depth;
    Scalar reading_ = Scalar::depth;  // the same, or what that needs as well
    const HeightField* field_ = nullptr;
    float blend_ = 0, height_per_code_ = 0, reach_ = 0;
    Frame prev_, next_;
    std::vector<float> static_frictions_;  // of a row
    std::vector<std::uint32_t> whole_;     // likewise, by bits: there is depth all around
};

}  // namespace touchable
