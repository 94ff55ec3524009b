// SPDX-License-Identifier: Apache-2.0
// Loaded before a program: the first wait for its GPU is in vain, and while it ends it is kept from going on
// for a moment, as on a machine that is busy with others.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <atomic>
#include <chrono>
#include <thread>

extern "C" int __cxa_atexit(void (*function)(void*), void* argument, void* library);

namespace {

/// The handler belongs to no library and is the first: it is called after every other one.
[[gnu::constructor]] void begin() {
    __cxa_atexit([](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(600)); }, nullptr,
                 nullptr);
}

}  // namespace

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info,
                                                           std::uint64_t timeout) {
    static std::atomic<bool> waited = false;
    if (!waited.exchange(true)) return VK_TIMEOUT;
    static const auto wait = reinterpret_cast<PFN_vkWaitSemaphores>(dlsym(RTLD_NEXT, "vkWaitSemaphores"));
    return wait(device, info, timeout);
}
