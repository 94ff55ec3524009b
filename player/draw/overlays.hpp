#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/plane_view.hpp"
#include "player/draw/cpu_lattice.hpp"
#include "player/draw/equalised_depth.hpp"
#include "player/draw/scalar_rows.hpp"
#include "player/draw/steady_range.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// What a surface is coloured by: its own colours, or one of the things it is made of.
enum class Overlay {
    colour,
    depth,         ///< in equally many pixels a step (EqualisedDepth)
    depth_linear,  ///< in equally many millimetres a step
    stiffness,
    static_friction,
    dynamic_friction,
    height,
    normals,
    tiles,    ///< which tiles are drawn whole, in part, not at all
    validity  ///< where there is no depth, what is next to that, and what other frames gave depth to
};

/// As options and scripts call it.
std::string name_of(Overlay overlay);
/// Of that name; after `now` where there is none, and from the last to the first. Refused (ErrorKind::usage)
/// with the right names.
Result<Overlay> overlay_after(Overlay now, const std::string& name);

/// What colours mean: a scale from `least` to `greatest` of colour_ramp, or a few classes.
struct OverlayScale {
    struct Class {
        PackedColour colour;
        std::string words;
    };
    std::string name{};    ///< "depth"
    std::string unit{};    ///< "mm"; may be empty
    std::string spread{};  ///< how values lie on the scale, where there are several ways; empty: evenly
    ValueRange range{};    ///< in that unit; two equal ends: it is the same everywhere
    /// Values at equal distances on the scale, from end to end; empty: values lie evenly.
    std::vector<double> levels{};
    bool least_is_light = false;
    std::vector<Class> classes{};           ///< where there are any there is no scale
    bool is_less = false, is_more = false;  ///< some of what is seen lies beyond that end, and has its colour
    bool has_map = true;                    ///< false: no plane of the clip tells it
    std::optional<double> at_holes{};       ///< what it is there, where the clip has no map and they differ

    /// Where a value is on the ramp, 0 to 1, where values lie evenly; of what is the same everywhere, the
    /// middle.
    double share_of(double value) const;
    /// "depth, mm: equalised", over the scale.
    std::string title() const;
    /// That it is the same everywhere, and whether the clip has a map of it; empty: it is not.
    std::string everywhere() const;
};

/// A colour for every pixel of a field.
struct OverlayPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< row-major
    OverlayScale scale;

    PlaneView view() const { return {rgb.data(), std::ptrdiff_t{3} * width, width, height, 1, 3}; }
};

/// Of pixels without depth: grey in stripes, like nothing else.
PackedColour hole_colour(int x, int y);

/// Makes overlays, frame after frame: what is on the scales is remembered, so that they do not flicker.
class Overlays {
public:
    /// `kind` is not `colour`; `pair` is what `field` was made of. A scale goes over what is seen, but for
    /// 1 % of the depths at either end and all at the far plane. What it gives stays as it is until the next
    /// call. Milliseconds, on this thread.
    const OverlayPicture& paint(Overlay kind, const HeightField& field, const FramePair& pair);

private:
    void paint_values(Overlay kind, const HeightField& field, const FramePair& pair);
    void make_equalised(const ValueRange& range, double factor);
    void paint_normals(const HeightField& field);
    void paint_tiles(const HeightField& field);
    void paint_validity(const HeightField& field, const FramePair& pair);
    void find_q(const HeightField& field, const FramePair& pair);
    std::uint8_t* row(int y) { return picture_.rgb.data() + std::ptrdiff_t{3} * y * picture_.width; }

    OverlayPicture picture_;
    ScalarRows rows_;
    std::array<SteadyRange, 10> ranges_;  // by kind
    EqualisedDepth equalised_;
    CpuLattices lattices_{1};
    std::vector<float> q_;
    std::vector<PackedColour> colours_;  // of values, by their place
};

/// Makes of a surface lit in the overlay's colours one in which they can be read: relief is left where the
/// overlay has none of its own, and weaker.
void quieten_light(Overlay kind, const OverlayPicture& overlay, ViewSurface& surface);

}  // namespace touchable
