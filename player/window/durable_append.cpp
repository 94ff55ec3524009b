#include "player/window/durable_append.hpp"

#include <unistd.h>

#include <cerrno>

namespace touchable {
namespace {

int write_all(int out, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(out, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return errno;
        if (count == 0) return ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return 0;
}

}  // namespace

/// A sync that failed is not tried again: Linux tells of a row that it could not write once, and then forgets
/// it.
int append_durably(int out, std::string_view rows) {
    const off_t before = lseek(out, 0, SEEK_END);
    int why = write_all(out, rows);
    if (why == 0 && fdatasync(out) != 0) why = errno;
    if (why != 0 && before >= 0) (void)!ftruncate(out, before);
    return why;
}

}  // namespace touchable
