// SPDX-License-Identifier: Apache-2.0
#pragma once

// Overlays: a surface coloured by one of its properties, and the scale that explains the colours.
//
// An `Overlay` names the property (depth, stiffness, normals, ...); `overlay_after` parses its name, or steps
// to the next. `Overlays` paints it frame after frame into an `Overlays::Picture`, which is passed to a
// painter or a drawing as the surface's colour with Lighting::values, or in the light of `light_of`:
//
//     Overlays overlays;
//     const Overlays::Picture& painted = overlays.paint(Overlay::depth, field, pair);
//     drawing.show(field, pair, painted.view(), Lighting::values);
//     TRY(draw_scale_bar(painted.scale, image));
//
// A scale's ramp goes from dark blue through green to light yellow (`ramp_colour`).
// Threads: `Overlays`, which remembers its scales to avoid flicker, belongs to one at a time; any may call
// everything else.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/view/drawn_surface.hpp"

namespace touchable {

/// What colours a surface: its own colours, or one of its properties.
enum class Overlay {
    colour,
    depth,         ///< equally many pixels per step (EqualisedDepth)
    depth_linear,  ///< equally many millimetres per step
    stiffness,
    static_friction,
    dynamic_friction,
    height,
    normals,
    errors,   ///< bars of the force's direction (ErrorBar); needs frames built with_error_bars
    tiles,    ///< tiles drawn fully, partly, or not at all
    validity  ///< holes, their rims, and depth filled in from other frames
};

/// The overlay's name in options and scripts.
std::string name_of(Overlay overlay);
/// The names of all overlays.
std::vector<std::string> overlay_names();
/// The overlay named `name`; if `name` is empty, the one after `now`, cyclically, without
/// tiles. Fails (ErrorKind::usage) with the list of names.
Result<Overlay> overlay_after(Overlay now, const std::string& name);

inline constexpr std::array<const char*, 3> light_names{"off", "soft", "full"};

/// The lighting of that name, off, soft or full; the next one for an empty name.
Result<Lighting> light_after(Lighting now, std::string_view name);

/// Paints overlays, frame after frame; remembers scales to avoid flicker.
class Overlays {
public:
    /// The least and greatest value shown.
    struct Range {
        double least = 0, greatest = 0;
        bool operator==(const Range&) const = default;
    };

    /// The meaning of the colours: a scale from `least` to `greatest` of colour_ramp, or a few classes.
    struct Scale {
        struct Class {
            PackedColour colour;
            std::string words;
        };
        std::string name{};    ///< "depth"
        std::string unit{};    ///< "mm"; may be empty
        std::string spread{};  ///< distribution of values on the scale, if there are several; empty: linear
        Range range{};         ///< in that unit; equal ends: one value everywhere
        /// Values at equal distances on the scale, from end to end; empty: linear.
        std::vector<double> levels{};
        bool least_is_light = false;
        std::vector<Class> classes{};  ///< replace the scale if not empty
        bool is_less = false,
             is_more = false;              ///< some visible values lie beyond that end, and have its colour
        bool has_map = true;               ///< false: no plane of the clip holds the values
        std::optional<double> at_holes{};  ///< the value at holes, if the clip has no map and it differs

        /// A value's place on the ramp, 0 to 1, for linear scales; the middle if the value is the same
        /// everywhere.
        double share_of(double value) const;
        /// The scale's heading, such as "depth, mm: equalised".
        std::string title() const {
            return name + (unit.empty() ? "" : ", " + unit) + (spread.empty() ? "" : ": " + spread);
        }
        /// Text for one value everywhere, and whether the clip has a map of it; empty if the values differ.
        std::string everywhere() const;
    };

    /// A colour for every pixel of a field.
    struct Picture {
        int width = 0, height = 0;
        std::vector<std::uint8_t> rgb;  ///< row-major
        Scale scale;

        PlaneView view() const { return {rgb.data(), std::ptrdiff_t{3} * width, width, height, 1, 3}; }
    };

    Overlays();
    ~Overlays();

    /// `kind` is not `colour`; `field` was made from `pair`. The scale covers the visible values, except for
    /// 1 % of the depths at either end and all at the far plane. The result is valid until the next call.
    /// Takes milliseconds, on this thread.
    const Picture& paint(Overlay kind, const HeightField& field, const FramePair& pair);

private:
    class Painter;
    std::unique_ptr<Painter> painter_;
};

/// The light in which a single picture of an overlay stays readable: none if the overlay shows relief itself.
Lighting light_of(Overlay kind);

/// Draws the colours' meaning into the lower right of `image` (RGB, 8 bits; upper right of a narrow one).
/// Draws nothing below 480x270 pixels, where it would hide the scene.
Result<void> draw_scale_bar(const Overlays::Scale& scale, Image& image);

}  // namespace touchable
