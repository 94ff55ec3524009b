#pragma once

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/result.hpp"

namespace touchable {

/// Starts a thread that does `work`, which throws nothing; an error where the machine has none left. `what`
/// it is for: "that decodes".
template <class Work>
Result<void> start_thread(std::thread& thread, const char* what, Work&& work) {
    try {
        thread = std::thread(std::forward<Work>(work));
    } catch (const std::system_error& refused) {
        return Error{ErrorKind::internal,
                     std::string("the thread ") + what + " cannot be started (" + refused.code().message() +
                         "); is there memory for it, and room below the limit of threads?"};
    }
    return {};
}

}  // namespace touchable
