#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "capi/handle_table.hpp"
#include "capi/touchable.h"
#include "engine/base/result.hpp"

namespace touchable::capi {

/// Writes status and line where there is an error to write to, and gives the status.
touch_status fail(touch_error* error, touch_status status, std::string_view line) noexcept;
touch_status fail(touch_error* error, const Error& what) noexcept;
/// Of a handle of this kind, such as "surface".
touch_status fail_stale(touch_error* error, const char* kind);
touch_status fail_forked(touch_error* error, const char* kind);

/// Why a table gives no object (HandleTable::Use).
template <class Use>
touch_status status_without(const Use& use) noexcept {
    return use.is_of_parent() ? TOUCH_FORKED : TOUCH_STALE;
}
template <class Use>
touch_status fail_without(const Use& use, touch_error* error, const char* kind) {
    return use.is_of_parent() ? fail_forked(error, kind) : fail_stale(error, kind);
}

/// Of an object that was to be destroyed.
touch_status status_of(Removal removal) noexcept;

/// Size of a struct in the first version that had it, the least that a program may say. A struct that grows
/// gets a specialisation with the size that it had.
template <class T>
inline constexpr std::size_t first_size = sizeof(T);
template <>
inline constexpr std::size_t first_size<touch_frame> = offsetof(touch_frame, lost_pixels);

/// Whether a struct that a program hands over has a size that this library knows.
template <class T>
bool has_known_size(const T* given) {
    return given && given->struct_size >= first_size<T> && given->struct_size <= sizeof(T);
}

/// Ticks and times that are far from where a count would run over.
constexpr bool is_countable(std::int64_t value) {
    constexpr std::int64_t farthest = std::int64_t{1} << 60;
    return value >= -farthest && value <= farthest;
}

/// `defaults`, with what the program's struct has of it in their place.
template <class T>
T over_defaults(const T& given, T defaults) {
    std::memcpy(&defaults, &given, given.struct_size);
    return defaults;
}

/// Writes as much as a struct of this size has room for, and the size. TOUCH_USAGE: it is one that this
/// library does not know.
template <class T>
touch_status give_defaults(const T& defaults, T* to, std::uint32_t struct_size) noexcept {
    if (!to || struct_size < first_size<T> || struct_size > sizeof(T)) return TOUCH_USAGE;
    std::memcpy(to, &defaults, struct_size);
    to->struct_size = struct_size;
    return TOUCH_OK;
}

/// Writes as much as the program's struct has room for.
template <class T>
void hand_out(const T& from, T& to) {
    const std::uint32_t size = to.struct_size;
    std::memcpy(&to, &from, size);
    to.struct_size = size;
}

/// At most `capacity` bytes of a text, with a zero at the end where there is room; the length of all of it.
inline void write_text(std::string_view from, char* text, std::size_t capacity, std::size_t& length) {
    length = from.size();
    if (capacity == 0) return;
    std::memcpy(text, from.data(), std::min(capacity, from.size()));
    if (capacity > from.size()) text[from.size()] = 0;
}

/// Nothing that is thrown comes out: memory that is missing is a status, anything else an internal fault.
template <class Function>
touch_status without_exceptions(touch_error* error, Function&& function) noexcept {
    try {
        return function();
    } catch (const std::bad_alloc&) {
        return fail(error, TOUCH_NO_MEMORY, "there is not enough memory");
    } catch (const std::length_error&) {
        return fail(error, TOUCH_NO_MEMORY, "there is not enough memory");
    } catch (const std::exception& fault) {
        return fail(error, TOUCH_INTERNAL, fault.what());
    } catch (...) {
        return fail(error, TOUCH_INTERNAL, "an unknown fault inside the library");
    }
}

/// Puts an object into its table, and its number where the caller wants it.
template <class Object, std::size_t most, class Handle>
touch_status give_handle(HandleTable<Object, most>& table, std::shared_ptr<Object> object, Handle& handle,
                         touch_error* error) {
    const auto id = table.insert(std::move(object));
    if (!id)
        return fail(error, TOUCH_NO_MEMORY,
                    "there are " + std::to_string(most) + " of these already; end one first");
    handle.id = *id;
    return TOUCH_OK;
}

/// Ends the object of a handle.
template <class Object, std::size_t most, class Handle>
touch_status end(HandleTable<Object, most>& table, Handle handle) noexcept {
    return without_exceptions(nullptr, [&]() -> touch_status { return status_of(table.remove(handle.id)); });
}

}  // namespace touchable::capi
