#pragma once

#include "engine/result.hpp"

namespace touchable {

/// Asks this program to stop. For signal handlers too.
void request_stop();

/// Whether somebody did. Work that takes long looks here between its steps, and gives up with an error.
bool stop_requested();

/// What work that stopped for that reason returns.
Error interrupted_error();

/// As long as it lives, its thread does what is left to do once a person has ended a run, such as reading the
/// frame that is to be drawn: for this thread nobody asked it to stop. (Who asks again ends the program.)
class WorkAfterStop {
public:
    WorkAfterStop();
    ~WorkAfterStop();
    WorkAfterStop(const WorkAfterStop&) = delete;
    WorkAfterStop& operator=(const WorkAfterStop&) = delete;

private:
    bool before_;
};

}  // namespace touchable
