#pragma once

#include <chrono>

#include "engine/base/stop_request.hpp"

namespace touchable {

/// Exit code of a program that was asked to stop (Ctrl-C) and did so cleanly.
inline constexpr int interrupted_exit_code = 130;

/// Signals that come so soon after the first say the same.
inline constexpr std::chrono::milliseconds same_wish{300};

/// From here on the first SIGINT, SIGTERM or SIGHUP only sets a flag; one that comes later than `same_wish`
/// after it ends the program at once.
/// Those that are ignored already, as under nohup, stay so. A file-size limit no longer ends it at all.
void catch_interrupts();

/// True once the person asked to stop. Long work looks here between frames.
bool interrupted();

/// From now on neither Ctrl-Z nor a terminal stops the program: it would stop with a force on.
void ignore_stop_keys();

}  // namespace touchable
