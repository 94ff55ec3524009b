#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/formats/bag_file.hpp"

namespace touchable {

/// A recording in SQLite (.db3), as ROS 2 writes it: tables topics and messages, messages in CDR. They are
/// given as ROS 1 serialises them (cdr_message.hpp). What is in a write-ahead log beside it is left out.
Result<std::unique_ptr<BagFile>> open_db3_file(const SourceFile& file);

}  // namespace touchable
