#pragma once

#include <new>
#include <string>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// "frames of 720x480 pixels": what most of the memory is for.
inline std::string frames_in_words(const Scene& scene) {
    return "frames of " + std::to_string(scene.width) + "x" + std::to_string(scene.height) + " pixels";
}

inline Error too_large(const std::string& what) {
    return input_error("memory does not suffice for " + what);
}

/// Does the work; where memory does not suffice, says what is too large. `what` is looked at only then, so
/// that the work may make it more precise as it learns of sizes.
template <class Work>
Result<void> within_memory(const std::string& what, Work&& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return too_large(what);
    }
}

}  // namespace touchable
