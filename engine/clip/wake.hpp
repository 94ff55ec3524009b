#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

namespace touchable {

/// What ends a wait by poll, from any thread; -1 as its descriptor where the system has none left.
class Wake {
public:
    Wake() : descriptor_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
    ~Wake() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    Wake(const Wake&) = delete;
    Wake& operator=(const Wake&) = delete;
    int descriptor() const { return descriptor_; }
    void forget() const {
        eventfd_t ignored = 0;
        (void)!::eventfd_read(descriptor_, &ignored);
    }
    void wake() const { (void)!::eventfd_write(descriptor_, 1); }

private:
    int descriptor_;
};

}  // namespace touchable
