// What a real-time thread asks of its machine. Each test asks in a process of its own, for what is granted
// stays.
#include "haptics_cpu/haptic_loop.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

constexpr int right = 0, wrong = 1, not_here = 2;

/// What a child that does `work` says.
template <class Work>
int in_a_child(Work work) {
    const pid_t child = fork();
    if (child == 0) _exit(work());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

long locked_kib() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmLck:")) return std::stol(line.substr(6));
    return -1;
}

/// New memory, its first page touched; false where there is none.
bool take_memory(std::size_t bytes) {
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return false;
    *static_cast<volatile char*>(memory) = 1;
    return true;
}

TEST(Realtime, MemoryThatComesLaterIsLockedToo) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take every call that locks memory for themselves";
#endif
    const int said = in_a_child([] {
        const RealtimeGrant grant = become_realtime();
        if (grant.memory != RealtimeGrant::Memory::all) return not_here;
        const long before = locked_kib();
        if (!take_memory(std::size_t{64} << 20)) return wrong;
        const bool named = grant.in_words().find(", memory locked,") != std::string::npos;
        return named && locked_kib() - before >= 64 * 1024 ? right : wrong;
    });
    if (said == not_here) GTEST_SKIP() << "this machine does not let all memory be locked";
    EXPECT_EQ(said, right);
}

TEST(Realtime, BelowALimitWhatComesLaterIsNotRefusedAndTheLimitIsNamed) {
    const int said = in_a_child([] {
        rlimit limit{};
        getrlimit(RLIMIT_MEMLOCK, &limit);
        limit.rlim_cur = limit.rlim_max = std::min(limit.rlim_max, rlim_t{1} << 30);
        if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0) return not_here;
        if (geteuid() == 0 && setuid(65534) != 0) return not_here;  // root is above limits
        const RealtimeGrant grant = become_realtime();
        if (grant.memory == RealtimeGrant::Memory::all || grant.memory_limit != limit.rlim_cur) return wrong;
        const std::string named = "RLIMIT_MEMLOCK is " + std::to_string(limit.rlim_cur / 1024) + " KiB";
        if (grant.in_words().find(named) == std::string::npos) return wrong;
        return take_memory(std::size_t{3} << 29) ? right : wrong;
    });
    if (said == not_here) GTEST_SKIP() << "this machine does not let the limit be set";
    EXPECT_EQ(said, right);
}

}  // namespace
}  // namespace touchable::test
