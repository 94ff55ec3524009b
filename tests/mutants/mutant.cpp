// SPDX-License-Identifier: Apache-2.0
// Linked into every program and library that mutants.py builds: the switch of mutant.hpp, and for each test
// of a GoogleTest program a line of what it reached, with what its child processes reached.

#include "mutant.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

// Null in programs without GoogleTest: mutants.py makes all symbols of this file weak.
extern "C" __attribute__((weak)) void touchable_has_googletest() __asm__(
    "_ZN7testing8UnitTest11GetInstanceEv");

namespace {
constexpr int most_mutants = 4096;  // as in mutants.py
TouchableReached without_a_file[most_mutants];
}  // namespace

extern "C" {
TouchableReached* touchable_reached_mutants = without_a_file;
int touchable_active_mutant = 0;

// Changed code must not end every process of this machine's user, as kill(-1, SIGKILL) does: the program ends
// instead.
int kill(pid_t process, int signal) {
    if (process == -1 || process == 1 || process == -getppid()) abort();
    return static_cast<int>(syscall(SYS_kill, process, signal));
}
}

namespace {

/// Before all other initialisers, which changed code may be part of.
__attribute__((constructor(101))) void read_environment() {
    if (const char* const active = std::getenv("TOUCHABLE_MUTANT"))
        touchable_active_mutant = std::atoi(active);
    const char* const file = std::getenv("TOUCHABLE_MUTANTS_REACHED");
    const int descriptor = file ? open(file, O_RDWR | O_CLOEXEC) : -1;
    if (descriptor < 0) return;
    void* const mapped =
        mmap(nullptr, sizeof without_a_file, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (mapped != MAP_FAILED) touchable_reached_mutants = static_cast<TouchableReached*>(mapped);
    close(descriptor);
}

std::set<int> taken_marks() {
    std::set<int> marks;
    for (int k = 0; k < most_mutants; ++k) {
        if (touchable_reached_mutants[k].yes != 0) marks.insert(k);
        touchable_reached_mutants[k].yes = 0;
    }
    return marks;
}

class Listener final : public testing::EmptyTestEventListener {
public:
    explicit Listener(std::FILE* report) : report_(report), process_(getpid()) {}
    void OnTestStart(const testing::TestInfo& test) override {
        if (getpid() != process_) return;
        // What is reached before the first test of a suite is its setup, which each of its tests needs.
        if (suite_ != test.test_suite_name()) before_.clear();
        suite_ = test.test_suite_name();
        before_.merge(taken_marks());
    }
    void OnTestEnd(const testing::TestInfo& test) override {
        if (getpid() != process_) return;
        std::set<int> marks = taken_marks();
        marks.insert(before_.begin(), before_.end());
        const bool passed = !test.result()->Failed() && !test.result()->Skipped();
        std::fprintf(report_, "%s.%s\t%lld\t%d\t", test.test_suite_name(), test.name(),
                     static_cast<long long>(test.result()->elapsed_time()), passed);
        for (const int k : marks) std::fprintf(report_, "%d ", k);
        std::fputs("\n", report_);
        std::fflush(report_);
    }

private:
    std::FILE* report_;
    pid_t process_;
    std::string suite_;
    std::set<int> before_;
};

/// After GoogleTest's own: it is asked for its listeners, which it makes then.
__attribute__((constructor(65535))) void listen() {
    const char* const path = std::getenv("TOUCHABLE_MUTANTS_REPORT");
    if (path == nullptr || touchable_has_googletest == nullptr) return;
    std::FILE* const report = std::fopen(path, "ae");
    unsetenv("TOUCHABLE_MUTANTS_REPORT");  // children only mark
    if (report != nullptr) testing::UnitTest::GetInstance()->listeners().Append(new Listener(report));
}
}  // namespace
