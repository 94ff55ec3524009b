#pragma once

#include <algorithm>
#include <cstddef>
#include <stop_token>

#include "engine/base/result.hpp"

namespace touchable {

/// Asks this program to stop. For signal handlers too.
void request_stop();

/// Whether somebody did, or gave up what this thread works for (WorkUntil). Work that takes long looks here
/// between its steps, and gives up with an error.
bool stop_requested();

/// Calls `work(first, last)` for 0 to `count` - 1, piece by piece, each a few milliseconds of a loop over
/// pixels. False where it was asked to stop: then the rest is left out.
template <class Work>
bool until_stopped(std::size_t count, Work&& work) {
    constexpr std::size_t piece = std::size_t{1} << 18;
    for (std::size_t first = 0; first < count; first += piece) {
        if (stop_requested()) return false;
        work(first, std::min(count, first + piece));
    }
    return true;
}

/// What work that stopped for that reason returns.
Error interrupted_error();

/// As long as it lives, its thread works for somebody who may give that up, such as whoever opens a clip:
/// once they do, `stop_requested` says so to this thread, and with it every read and every wait. Scopes may
/// lie within each other, and each counts.
class WorkUntil {
public:
    explicit WorkUntil(std::stop_token given_up);
    ~WorkUntil();
    WorkUntil(const WorkUntil&) = delete;
    WorkUntil& operator=(const WorkUntil&) = delete;

private:
    friend bool stop_requested();
    const std::stop_token given_up_;
    const WorkUntil* const around_;
};

/// As long as it lives, its thread does what others wait for, too: giving up its own work does not end that.
class WorkForAll {
public:
    WorkForAll();
    ~WorkForAll();
    WorkForAll(const WorkForAll&) = delete;
    WorkForAll& operator=(const WorkForAll&) = delete;

private:
    const WorkUntil* const around_;
};

/// As long as it lives, its thread does a part of what another one does meanwhile: `stop_requested` says
/// there what it says to that one, which waits for it.
class WorkAlongside {
public:
    /// What `stop_requested` goes by in a thread.
    struct Whom {
        const WorkUntil* until = nullptr;
        bool goes_on = false;
    };
    static Whom this_thread();

    explicit WorkAlongside(const Whom& whom);
    ~WorkAlongside();
    WorkAlongside(const WorkAlongside&) = delete;
    WorkAlongside& operator=(const WorkAlongside&) = delete;

private:
    const Whom before_;
};

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
