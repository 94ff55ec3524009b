#pragma once

namespace touchable {

/// Asks this program to stop. For signal handlers too.
void request_stop();

/// Whether somebody did. Work that takes long looks here between its steps, and gives up with an error.
bool stop_requested();

}  // namespace touchable
