#pragma once

// Overlays: what a surface is made of, shown by colours, and the scale that says what the colours mean.
//
// An `Overlay` is what is shown (depth, stiffness, normals, ...); `overlay_after` reads its name, and steps
// from one to the next. `Overlays` paints it frame after frame into an `Overlays::Picture`, which is handed
// to a painter or a drawing as the surface's colour with Lighting::plain, or softened by `quieten_light`:
//
//     Overlays overlays;
//     const Overlays::Picture& painted = overlays.paint(Overlay::depth, field, pair);
//     drawing.show(field, pair, painted.view(), Lighting::plain);
//     TRY(draw_scale_bar(painted.scale, image));
//
// The ramp of a scale goes from dark blue by green to light yellow (`ramp_colour`). `Overlays` remembers its
// scales, so that they do not flicker, and belongs to one thread at a time; everything else any thread may
// call.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/view.hpp"

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

/// The name that options and scripts have for it.
std::string name_of(Overlay overlay);
/// All of them.
std::vector<std::string> overlay_names();
/// The overlay of that name; the one after `now` where the name is empty, and from the last to the first.
/// Refused (ErrorKind::usage) with the right names.
Result<Overlay> overlay_after(Overlay now, const std::string& name);

/// Makes overlays, frame after frame: what is on the scales is remembered, so that they do not flicker.
class Overlays {
public:
    /// From least to greatest of something that is shown.
    struct Range {
        double least = 0, greatest = 0;
        bool operator==(const Range&) const = default;
    };

    /// What colours mean: a scale from `least` to `greatest` of colour_ramp, or a few classes.
    struct Scale {
        struct Class {
            PackedColour colour;
            std::string words;
        };
        std::string name{};    ///< "depth"
        std::string unit{};    ///< "mm"; may be empty
        std::string spread{};  ///< how values lie on the scale, where there are several ways; empty: evenly
        Range range{};         ///< in that unit; two equal ends: it is the same everywhere
        /// Values at equal distances on the scale, from end to end; empty: values lie evenly.
        std::vector<double> levels{};
        bool least_is_light = false;
        std::vector<Class> classes{};  ///< where there are any there is no scale
        bool is_less = false,
             is_more = false;              ///< some of what is seen lies beyond that end, and has its colour
        bool has_map = true;               ///< false: no plane of the clip tells it
        std::optional<double> at_holes{};  ///< what it is there, where the clip has no map and they differ

        /// Where a value is on the ramp, 0 to 1, where values lie evenly; of what is the same everywhere, the
        /// middle.
        double share_of(double value) const;
        /// "depth, mm: equalised", over the scale.
        std::string title() const {
            return name + (unit.empty() ? "" : ", " + unit) + (spread.empty() ? "" : ": " + spread);
        }
        /// Says that it is the same everywhere, and whether the clip has a map of it; empty: it is not.
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

    /// `kind` is not `colour`; `pair` is what `field` was made of. A scale goes over what is seen, but for
    /// 1 % of the depths at either end and all at the far plane. What it gives stays as it is until the next
    /// call. Milliseconds, on this thread.
    const Picture& paint(Overlay kind, const HeightField& field, const FramePair& pair);

private:
    class Painter;
    std::unique_ptr<Painter> painter_;
};

struct ViewSurface;

/// Makes of a surface lit in the overlay's colours one in which they can be read: relief is left where the
/// overlay has none of its own, and weaker.
void quieten_light(Overlay kind, const Overlays::Picture& overlay, ViewSurface& surface);

/// Colours from dark blue by green to light yellow, lightness growing evenly as eyes see it (OKLab), none of
/// them grey: it is read without telling red from green, by its lightness and by blue and yellow.
const std::array<PackedColour, 256>& colour_ramp();

/// Its colour at 0 to 1; beyond that, the end's.
PackedColour ramp_colour(double share);

/// Draws into the lower right of `image` (RGB, 8 bits; upper right of a narrow one) what its colours mean.
/// Nothing below 480x270 pixels, where it would hide the scene.
Result<void> draw_scale_bar(const Overlays::Scale& scale, Image& image);

}  // namespace touchable
