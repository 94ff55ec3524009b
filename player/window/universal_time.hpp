#pragma once

#include <chrono>
#include <string>

namespace touchable {

/// "2026-11-24T10:00:00Z": universal time, to the second.
std::string in_universal_time(std::chrono::system_clock::time_point time);

}  // namespace touchable
