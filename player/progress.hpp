#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace touchable {

/// One line on the terminal's error stream that counts up while long work runs; silent where that is no
/// terminal.
class Progress {
public:
    /// `what`: "making frame". `total` <= 0: the end is not known.
    Progress(std::string what, std::int64_t total);
    ~Progress();  ///< clears the line
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Redraws at most ten times a second.
    void at(std::int64_t done);

private:
    std::string what_;
    std::int64_t total_;
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace touchable
