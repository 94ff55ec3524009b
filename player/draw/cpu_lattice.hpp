#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "player/draw/cpu_light.hpp"
#include "player/draw/view_surface.hpp"
#include "shaders/cut_rule.h"

namespace touchable {

/// Makes q and tiles of lattices on the CPU, by its vectors and on threads: what GpuLattices does on a GPU,
/// with the arithmetic of shaders/unproject.h. The same bits with any number of threads and any vectors.
class CpuLattices {
public:
    /// A core each, as far as that pays.
    static int usual_threads();
    /// `threads` with the one that calls; the others start when first needed and sleep in between.
    explicit CpuLattices(int threads, VectorUnit vectors = usable_vector_units().front());

    /// The twin of `q_of`: the same pixels are 0, the others agree as SurfaceUnproject's. `pair`, whose
    /// frames have codes (SurfaceUnproject::has_codes), is what `field` was made of.
    void q_of(const HeightField& field, const FramePair& pair, std::vector<float>& q);
    /// The same in rows of `pitch` floats, 0 beyond the width.
    void q_of(const HeightField& field, const FramePair& pair, float* q, int pitch);
    /// Which tiles of a lattice of these q are worth drawing.
    ViewTiles tiles_of(int width, int height, const std::vector<float>& q);

    /// Colours of the vertices of `field`, whose q is there, as LightRows makes them; both in rows of
    /// `pitch`. `colour`: RGB of 8 bits, of the field's size, or empty for clay, which is always lit.
    void light(const HeightField& field, const float* q, int pitch, const PlaneView& colour,
               Lighting lighting, PackedColour* colours, float cut_ratio = CUT_RULE_RATIO);

    /// `make_view_surface`, with q and tiles as above; q by `touchable::q_of` where the frames have no codes.
    ViewSurface surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour);

private:
    const VectorUnit unit_;
    RowBands bands_;
    std::vector<std::vector<float>> scratch_;  // by thread
    std::vector<LightRows> light_rows_;        // likewise
    std::vector<float> u2_;                    // of the columns' rays, squared
    std::vector<std::uint8_t> classes_;        // of each tile
};

}  // namespace touchable
