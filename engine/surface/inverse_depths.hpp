// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Reads rows of a built frame as inverse planar depths q: in (x, y, q) a flat surface is flat. One thread
/// at a time.
class InverseDepths {
public:
    InverseDepths(const Camera& camera, int width);
    /// Of the first `width` pixels of a row, 1 / scene units; 0: invalid.
    void read_row(const SurfaceFrame& frame, int y, std::vector<float>& q);

private:
    void know_codes(const DepthCoding& coding);

    Camera camera_;
    std::vector<float> u_;  // of each column's rays
    DepthCoding coding_;
    std::vector<float> of_code_;
};

}  // namespace touchable
