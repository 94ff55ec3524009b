// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a test runs under: sanitizers, a disk that is full, memory that is short or gone; and the memory that
// it takes.

#include <sys/resource.h>

#include <csignal>
#include <cstddef>
#include <fstream>
#include <string>

// TOUCHABLE_SANITIZED: by AddressSanitizer or ThreadSanitizer. GCC says so by macros, Clang by features.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TOUCHABLE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define TOUCHABLE_SANITIZED
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define TOUCHABLE_THREAD_SANITIZED
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TOUCHABLE_THREAD_SANITIZED
#endif
#endif

/// Skips a test that cannot pass under ThreadSanitizer, for a reason of the test's own.
#ifdef TOUCHABLE_THREAD_SANITIZED
#define TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(reason) GTEST_SKIP() << (reason)
#else
#define TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(reason) static_assert(true)
#endif

namespace touchable::test {

/// While it lives no file grows beyond so many bytes: a full disk.
class FullDisk {
public:
    explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FullDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }

    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;

private:
    rlimit before_{};
    decltype(SIG_IGN) handler_;
};

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

// Of frame/allocations.cpp, whose operators new and delete stand in for everybody's.

/// Calls of operator new by this thread so far, in this whole program.
std::size_t allocations();
/// From here on each of them by this thread throws, as where memory is gone; under Clang's ThreadSanitizer
/// none does.
void refuse_allocations();

}  // namespace touchable::test
