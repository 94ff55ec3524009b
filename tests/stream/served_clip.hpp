// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable::test {

/// `touchable serve` as a process of its own, so that what it computes can be told from what others do.
class ServedClip {
public:
    /// Serves `clip` by the program's own options; back once it listens.
    static Result<std::unique_ptr<ServedClip>> start(const std::filesystem::path& clip,
                                                     std::vector<std::string> options,
                                                     std::filesystem::path report);
    ~ServedClip();  ///< ends it
    ServedClip(const ServedClip&) = delete;
    ServedClip& operator=(const ServedClip&) = delete;

    /// Where it listens, as it says: "tcp://127.0.0.1:41234".
    const std::string& address() const { return address_; }
    /// Asks it to end; its report.
    Result<nlohmann::ordered_json> end();
    /// CPU time that it has taken so far, ns.
    std::int64_t cpu_ns() const;

private:
    ServedClip(pid_t process, int says, std::filesystem::path report)
        : process_(process), says_(says), report_(std::move(report)) {}
    pid_t process_;  // 0: it has ended
    int says_;       // what it says comes out of this
    std::filesystem::path report_;
    std::string address_;
};

}  // namespace touchable::test
