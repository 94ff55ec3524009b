#pragma once

#include <memory>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/bag_file.hpp"

namespace touchable {

/// A recording in MCAP, as ROS 2 writes it; its chunks plain or packed by LZ4 or zstd. Its messages are given
/// as ROS 1 serialises them (cdr_message.hpp). Of one that was cut, what is there.
Result<std::unique_ptr<BagFile>> open_mcap_file(const SourceFile& file);

/// Whether a file's first bytes are those of MCAP.
bool is_mcap(std::string_view begin);

}  // namespace touchable
