// A software GPU on a busy machine is slow, not lost: where a wait for it would be given up after the 10 s
// that a picture has, or later, it lasts up to 5 minutes. Linked into each test, and loaded before each run
// of the program. Shorter limits, which tests of a GPU that hangs set, stay as they are.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdint>

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info,
                                                           std::uint64_t timeout) {
    constexpr std::uint64_t ns_per_s = 1'000'000'000, picture = 10 * ns_per_s, patient = 300 * ns_per_s;
    static const auto wait = reinterpret_cast<PFN_vkWaitSemaphores>(dlsym(RTLD_NEXT, "vkWaitSemaphores"));
    return wait(device, info, timeout < picture ? timeout : std::max(timeout, patient));
}
