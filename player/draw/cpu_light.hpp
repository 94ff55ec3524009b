#pragma once

#include <vector>

#include "engine/base/vector_unit.hpp"
#include "engine/scene/camera.hpp"
#include "engine/scene/plane_view.hpp"
#include "player/draw/surface_light.hpp"
#include "shaders/cut_rule.h"

namespace touchable {

/// What is to be lit: q as ViewSurface has it, and a colour at each vertex.
struct LightTerms {
    Camera camera;
    float farthest = 1;        ///< a depth as large as any, scene units
    const float* q = nullptr;  ///< rows of `pitch`
    int width = 0, height = 0, pitch = 0;
    PlaneView colour;  ///< RGB of 8 bits, of that size; or empty: clay
    UsualQ usual{};    ///< of clay: where it is cool and where it is warm
    float cut_ratio = CUT_RULE_RATIO;
};

/// Lights rows of vertices by the CPU's vectors, with the arithmetic of shaders/light.h: the twin of
/// `lit_colours`, to 2 of 255. A row has the same bits whichever rows are lit with it, and by any vectors.
class LightRows {
public:
    /// Colours of the vertices of rows [first, end), in rows of `terms.pitch`; `colours` is that of row 0.
    void light(const LightTerms& terms, int first, int end, VectorUnit unit, PackedColour* colours);

private:
    /// A vector at each vertex, or each cell, of a row; some columns beyond both ends are there and 0.
    struct Row {
        float *x, *y, *z;
    };
    Row row(int n);

    std::vector<float> floats_;
    std::size_t stride_ = 0;
};

}  // namespace touchable
