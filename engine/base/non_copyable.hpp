#pragma once

// A base for classes of which there must be no copies.
//
//     class Wake : NonCopyable { ... };
//
// Of these kinds are: what holds a thing that the machine has once, such as a descriptor, a thread or a
// device, and lets go of it at its end; what other objects point at, since a copy lies elsewhere; and
// interfaces, of which a copy would be a part of an object. None of them can be moved either: what is to be
// handed on is held by a std::unique_ptr.
//
// It has no members, and costs nothing.

namespace touchable {

class NonCopyable {
protected:
    NonCopyable() = default;
    ~NonCopyable() = default;
    NonCopyable(const NonCopyable&) = delete;
    NonCopyable& operator=(const NonCopyable&) = delete;
};

}  // namespace touchable
