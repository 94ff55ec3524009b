#pragma once

#include <sys/resource.h>

#include <fstream>

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

}  // namespace touchable::test
