#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// A moment's surface with every `step`th vertex across and down, for windows whose pixels do not tell more
/// of them apart: a level of detail. It serves the eye alone; what is touched has all vertices.
class Decimation {
public:
    /// `threads` with the one that calls. The same with any number of them, and any vectors.
    explicit Decimation(int threads, VectorUnit vectors = usable_vector_units().front());

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

private:
    /// A frame's halves, and theirs.
    using Halves = std::array<SurfaceFrame, 2>;
    /// Of a row of colours, by thread.
    struct Scratch {
        std::vector<std::uint16_t> sums;
        std::vector<std::uint8_t> means;
    };
    const SurfaceFrame* decimated_frame(const SurfaceFrame& frame, int step, Halves& halves);
    void halve_frame(const SurfaceFrame& from, SurfaceFrame& to);
    void halve_colour(const PlaneView& from, std::vector<std::uint8_t>& to);
    void halve_colour_row(const PlaneView& from, int y, Scratch& scratch, std::uint8_t* out) const;

    const VectorUnit unit_;
    RowBands bands_;
    std::vector<Scratch> scratch_;
    Halves prev_, next_;
    Scene scene_;
    FramePair pair_;
    std::optional<HeightField> field_;
    PlaneView colour_;
    std::vector<std::uint8_t> halves_[2];  // each made of the other
};

/// In place of CUT_RULE_RATIO: neighbours that lie farther apart may differ more.
float cut_ratio(int step);

/// The same view of a lattice that has every `step`th vertex of another.
ViewCamera decimated(ViewCamera camera, int step);

}  // namespace touchable
