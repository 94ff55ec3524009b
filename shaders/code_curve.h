// SPDX-License-Identifier: Apache-2.0
// CodeCurve::at of engine/scene/scene.hpp; include after shaders/surface_codes.h.

/// At most 32767. `code` must not be beyond `curve.last`, or the result means nothing.
uint curve_at(CurvePush curve, uint code) {
    const uint n = (curve.from_last != 0u ? curve.last - code : code) << curve.shift;
    const uint sum = curve.constant + (curve.quadratic * (n * n >> 16) >> 16),
               sloped = curve.linear * n >> 16;
    return min(curve.falls != 0u ? sum - min(sum, sloped) : sum + sloped, 32767u);
}
