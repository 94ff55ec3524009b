// SPDX-License-Identifier: Apache-2.0
// A software GPU on a busy machine is slow, not lost: where a wait for it would be given up after the 10 s
// that a picture has, or later, it lasts up to 5 minutes. Linked into each test, and loaded before each run
// of the program. Shorter limits, which tests of a GPU that hangs set, stay as they are. And its memory,
// which is a file of the kernel's since Mesa 24, grows where a limit on files stands in for a full disk: Mesa
// writes to what it was refused, which ends a program by SIGBUS.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info,
                                                           std::uint64_t timeout) {
    constexpr std::uint64_t ns_per_s = 1'000'000'000, picture = 10 * ns_per_s, patient = 300 * ns_per_s;
    static const auto wait = reinterpret_cast<PFN_vkWaitSemaphores>(dlsym(RTLD_NEXT, "vkWaitSemaphores"));
    return wait(device, info, timeout < picture ? timeout : std::max(timeout, patient));
}

namespace {

/// A child has limits of its own, and the file in common.
int grow(int file, off64_t bytes) {
    const pid_t child = fork();
    if (child == 0) {
        rlimit limit{};
        getrlimit(RLIMIT_FSIZE, &limit);
        limit.rlim_cur = limit.rlim_max;
        setrlimit(RLIMIT_FSIZE, &limit);
        _exit(syscall(SYS_ftruncate, file, bytes) == 0 ? 0 : 1);
    }
    int status = -1;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    if (status == 0) return 0;
    errno = EFBIG;
    return -1;
}

}  // namespace

extern "C" int ftruncate64(int file, off64_t bytes) noexcept {
    rlimit limit{};
    const bool is_memory = fcntl(file, F_GET_SEALS) >= 0;
    if (is_memory && getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < limit.rlim_max)
        return grow(file, bytes);
    return static_cast<int>(syscall(SYS_ftruncate, file, bytes));
}

extern "C" int ftruncate(int file, off_t bytes) noexcept {
    return ftruncate64(file, bytes);
}
