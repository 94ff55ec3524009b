#pragma once

#include <pthread.h>

#include <cstddef>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/base/result.hpp"

namespace touchable {

/// Starts a thread that does `work`, which throws nothing; an error where the machine has none left. `name`
/// is what debuggers, `top` and `ps` show of it, at most 15 bytes; `what` says in the error what the thread
/// is for: "that decodes".
template <std::size_t bytes, class Work>
Result<void> start_thread(std::thread& thread, const char (&name)[bytes], const char* what, Work&& work) {
    static_assert(bytes <= 16, "Linux keeps 15 bytes of a thread's name");
    try {
        thread = std::thread([name = &name[0], work = std::forward<Work>(work)]() mutable {
            pthread_setname_np(pthread_self(), name);
            work();
        });
    } catch (const std::system_error& refused) {
        return Error{ErrorKind::internal,
                     std::string("the thread ") + what + " cannot be started (" + refused.code().message() +
                         "); is there memory for it, and room below the limit of threads?"};
    }
    return {};
}

}  // namespace touchable
