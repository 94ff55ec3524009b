#pragma once

#include <vector>

#include "bench/media/plane_codec.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Bytes of a packet, the mean over the planes.
Result<double> bytes_per_frame(const CodecChoice& choice, const std::vector<PlaneView>& planes);

/// Has a codec store the planes and read them again, `rounds` times, and appends its figures
/// (bench/README.md, "Suite media"). An error of kind check where a lossless one does not give back what went
/// in.
Result<void> measure_codec(const CodecChoice& choice, const std::vector<PlaneView>& planes, double ffv1_bytes,
                           int rounds, Figures& figures);

}  // namespace touchable
