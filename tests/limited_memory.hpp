#pragma once

#include <sys/resource.h>

#include <fstream>
#include <string>

#include "tests/sanitizers.hpp"

namespace touchable::test {

/// As long as it lives, this process may take only so much more memory; what asks for more gets
/// std::bad_alloc. (Sanitizers map terabytes of their own: with them nothing is limited.)
class LimitedMemory {
public:
    explicit LimitedMemory(rlim_t mebibytes) {
#ifndef TOUCHABLE_SANITIZED
        rlim_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        getrlimit(RLIMIT_AS, &before_);
        rlimit limit = before_;
        limit.rlim_cur = pages * 4096 + (mebibytes << 20U);
        setrlimit(RLIMIT_AS, &limit);
        limited_ = true;
#else
        (void)mebibytes;
#endif
    }
    ~LimitedMemory() {
        if (limited_) setrlimit(RLIMIT_AS, &before_);
    }
    LimitedMemory(const LimitedMemory&) = delete;
    LimitedMemory& operator=(const LimitedMemory&) = delete;

private:
    rlimit before_{};
    bool limited_ = false;
};

/// The most memory that this process had since this was made, beyond what it had then. (With sanitizers
/// nothing is measured.)
class PeakMemory {
public:
    PeakMemory() {
        std::ofstream("/proc/self/clear_refs") << 5;
        before_ = mebibytes_of("VmRSS:");
    }
    double mebibytes() const {
#ifdef TOUCHABLE_SANITIZED
        return 0;
#else
        return mebibytes_of("VmHWM:") - before_;
#endif
    }

private:
    static double mebibytes_of(const std::string& name) {
        std::ifstream status("/proc/self/status");
        double kibibytes = 0;
        for (std::string word; status >> word;)
            if (word == name) status >> kibibytes;
        return kibibytes / 1024;
    }
    double before_ = 0;
};

}  // namespace touchable::test
