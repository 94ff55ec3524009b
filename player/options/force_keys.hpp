#pragma once

#include <atomic>
#include <thread>

#include "device/hand_control.hpp"

namespace touchable {

/// Lines that a person types while a device is held: Enter turns forces on and off, c and Enter recentres.
/// Listens only where standard input is a terminal.
class ForceKeys {
public:
    /// `control` outlives it.
    explicit ForceKeys(HandControl& control);
    ~ForceKeys();
    ForceKeys(const ForceKeys&) = delete;
    ForceKeys& operator=(const ForceKeys&) = delete;

    bool listens() const { return thread_.joinable(); }

private:
    void listen();

    HandControl& control_;
    std::atomic<bool> over_{false};
    std::thread thread_;
};

}  // namespace touchable
