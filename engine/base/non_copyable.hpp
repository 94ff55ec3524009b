#pragma once

// A base for what must not be copied, nor moved: what holds something that the machine has once (a
// descriptor, a thread, a device), what others point at, and interfaces, of which a copy would be a part.
//
//     class Wake : NonCopyable { ... };

namespace touchable {

class NonCopyable {
protected:
    NonCopyable() = default;
    ~NonCopyable() = default;
    NonCopyable(const NonCopyable&) = delete;
    NonCopyable& operator=(const NonCopyable&) = delete;
};

}  // namespace touchable
