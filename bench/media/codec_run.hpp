#pragma once

#include <vector>

#include "bench/media/plane_codec.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Mean bytes per packet.
Result<double> bytes_per_frame(const CodecChoice& choice, const std::vector<PlaneView>& planes);

/// Encodes and decodes the planes with a codec, `rounds` times, and appends its figures (bench/README.md,
/// "Suite media"). An error of kind check if a lossless codec changes a value.
Result<void> measure_codec(const CodecChoice& choice, const std::vector<PlaneView>& planes, double ffv1_bytes,
                           int rounds, Figures& figures);

}  // namespace touchable
