#pragma once

#include <memory>

#include "engine/gpu/gpu_commands.hpp"

namespace touchable {

/// What is made on a device once and then serves again: there for what the commands that make it do
/// afterwards, and for other commands from when these were submitted. Of commands that were recorded and
/// forgotten nothing is there. What the CPU makes is there at once.
class GpuMade {
public:
    void by(const GpuCommands& commands) { submitted_ = commands.submitted(); }
    void by_cpu() { submitted_ = std::make_shared<const bool>(true); }
    void reset() { submitted_.reset(); }
    bool is_there_for(const GpuCommands& commands) const {
        return submitted_ && (*submitted_ || submitted_ == commands.submitted());
    }

private:
    std::shared_ptr<const bool> submitted_;
};

}  // namespace touchable
