#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {

/// A moment's surface with every `step`th vertex across and down, for windows whose pixels do not tell more
/// of them apart: a level of detail. It serves the eye alone; what is touched has all vertices.
class Decimation {
public:
    /// The greatest power of two whose vertices lie at most 1.5 pixels apart; 1 where neighbours lie
    /// `pixels_per_vertex` > 0.75 apart already.
    static int step_for(double pixels_per_vertex);

    /// `pair`, whose frames have codes (SurfaceUnproject::has_codes), is what `field` was made of; `colour`:
    /// RGB of 8 bits, of the field's size, or empty. Reads them now and not later.
    void make(const HeightField& field, const FramePair& pair, const PlaneView& colour, int step);
    /// Of what was made last; until the next `make`.
    const HeightField& field() const { return *field_; }
    const FramePair& pair() const { return pair_; }
    /// Means of the pixels around each vertex; or empty.
    const PlaneView& colour() const { return colour_; }
    /// Nothing of the frames before serves: another clip.
    void forget() {
        for (Level& level : levels_) level.key = {};
    }

private:
    struct Key {
        const SurfaceFrame* frame = nullptr;
        std::int64_t number = -1;
        std::uint64_t epoch = 0;
        int step = 1;
        bool operator==(const Key&) const = default;
    };
    struct Level {
        Key key;
        std::array<std::unique_ptr<SurfaceFrame>, 2> halves{std::make_unique<SurfaceFrame>(),
                                                            std::make_unique<SurfaceFrame>()};
        const SurfaceFrame* made = nullptr;  // one of them
    };
    static const SurfaceFrame* decimated_frame(const TimedFrame& frame, std::uint64_t epoch, int step,
                                               Level& level);
    void halve_colour(const PlaneView& from, std::vector<std::uint8_t>& to);

    std::array<Level, 2> levels_;  // of the earlier and the later frame
    Scene scene_;
    FramePair pair_;
    std::optional<HeightField> field_;
    PlaneView colour_;
    std::vector<std::uint8_t> halves_[2];  // each made of the other
    std::vector<std::uint16_t> sums_;      // of three rows
};

/// The same view of a lattice that has every `step`th vertex of another.
ViewCamera decimated(ViewCamera camera, int step);

}  // namespace touchable
