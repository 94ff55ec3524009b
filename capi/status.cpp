#include "capi/status.hpp"

namespace touchable::capi {

namespace {

touch_status status_of(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage:
            return TOUCH_USAGE;
        case ErrorKind::input:
            return TOUCH_INPUT;
        case ErrorKind::interrupted:
            return TOUCH_INTERRUPTED;
        default:
            return TOUCH_INTERNAL;
    }
}

/// As many bytes as there is room for, cut between characters.
std::size_t whole_characters(std::string_view line, std::size_t room) {
    if (line.size() <= room) return line.size();
    while (room > 0 && (static_cast<unsigned char>(line[room]) & 0xc0U) == 0x80U) --room;
    return room;
}

}  // namespace

touch_status fail(touch_error* error, touch_status status, std::string_view line) noexcept {
    constexpr std::size_t before = offsetof(touch_error, line);
    if (!error || error->struct_size <= before) return status;
    error->status = status;
    const std::size_t room = std::min<std::size_t>(error->struct_size, sizeof(touch_error)) - before - 1;
    const std::size_t length = whole_characters(line, room);
    std::replace_copy(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(length), error->line, '\n',
                      ' ');
    error->line[length] = 0;
    return status;
}

touch_status fail(touch_error* error, const Error& what) noexcept {
    return fail(error, status_of(what.kind), what.message);
}

touch_status status_of(Removal removal) noexcept {
    switch (removal) {
        case Removal::removed:
            return TOUCH_OK;
        case Removal::busy:
            return TOUCH_BUSY;
        default:
            return TOUCH_STALE;
    }
}

touch_status fail_stale(touch_error* error, const char* kind) {
    return fail(error, TOUCH_STALE,
                std::string(kind) + ": this handle was destroyed, or never was one of this kind");
}

touch_status fail_forked(touch_error* error, const char* kind) {
    return fail(
        error, TOUCH_FORKED,
        "the " + std::string(kind) +
            " belongs to the parent process; right would be to open or make another one after fork()");
}

}  // namespace touchable::capi
