// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a function reports that it failed.
//
// A function that can fail returns Result<T>: a value, or an Error with one line for a person (what is wrong,
// where, what would be right) and its kind, which exit_code turns into the program's exit code. Test it with
// `if (!result)`, then use `*result`; TRY and TRY_ASSIGN (engine/base/try.hpp) pass an error on. input_error,
// usage_error and the like make the errors, and error_at puts a place before the message: a function that
// does not know its file's name says what is wrong, and its caller says where. No exception crosses a
// module's border.
//
// An Error may hint at a Setting: the program, not the library, knows its name there, an option or a row of a
// panel.
// Threads: any; plain values.

#include <cassert>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace touchable {

/// Names of the settings of what is opened, touched, shown or written, as hints use them. Messages describe a
/// setting in plain words; a program maps its name to its own option, row of a panel or parameter.
struct Setting {
    using Name = std::string_view;
    static constexpr Name builder = "builder", camera = "camera", channel = "channel", clip = "clip",
                          damping = "damping", dataset = "dataset", depth_kind = "depth",
                          depth_unit = "depth_unit", device = "device", device_rules = "device_rules",
                          field_of_view = "fov", far = "far", fingers = "fingers", forces = "forces",
                          gpu = "gpu", hand = "hand", haptic_map = "haptic_map", headless = "headless",
                          height_map = "height_map", interpolation = "interpolation",
                          intrinsics = "intrinsics", live = "live", loop = "loop", max_force = "max_force",
                          max_stiffness = "max_stiffness", near = "near", painter = "painter",
                          passivity = "passivity", playback = "playback", preset = "preset", rate = "rate",
                          record = "record", scene_file = "scene_file", script = "script",
                          seconds = "seconds", stale_after = "stale_after", start = "start",
                          start_buried = "start_buried", stiffness_rise = "stiffness_rise",
                          stribeck = "stribeck", temporal = "temporal", view = "view";
};

/// A setting that a message is about, or that would help, and the value that would be right.
struct Hint {
    Setting::Name setting;
    std::string value{};  ///< empty: any, or what the message says
};
using Hints = std::vector<Hint>;

/// The kind of an error; each kind has its own exit code (see `exit_code`).
enum class ErrorKind { internal, usage, input, gpu, device, check, interrupted };

/// One line for a person: what is wrong, where (file, track, frame, setting, device), and what would be
/// right.
struct Error {
    /// What a caller may have to tell from other errors of their kind.
    enum class Cause {
        other,
        exists,      ///< a file of that name, which may not be replaced
        out_of_time  ///< a program used up its processor time (ChildLimits)
    };

    ErrorKind kind = ErrorKind::internal;
    std::string message;
    Hints hints{};  ///< the settings that the message mentions; the program has its own names for them
    Cause cause = Cause::other;
};

/// 1 internal fault, 2 bad usage, 3 bad input, 4 no usable GPU, 5 device fault, 6 a check failed, 130
/// interrupted.
constexpr int exit_code(ErrorKind kind) {
    return kind == ErrorKind::interrupted ? 130 : 1 + static_cast<int>(kind);
}

inline Error input_error(std::string message, Hints hints = {}) {
    return {ErrorKind::input, std::move(message), std::move(hints)};
}
inline Error usage_error(std::string message, Hints hints = {}) {
    return {ErrorKind::usage, std::move(message), std::move(hints)};
}
inline Error device_error(std::string message, Hints hints = {}) {
    return {ErrorKind::device, std::move(message), std::move(hints)};
}
inline Error gpu_error(std::string message, Hints hints = {}) {
    return {ErrorKind::gpu, std::move(message), std::move(hints)};
}
/// A fault of this program or of a library that it uses.
inline Error internal_error(std::string message) {
    return {ErrorKind::internal, std::move(message)};
}
/// Puts a place before the message: a file, a node, a device.
inline Error error_at(const std::string& where, Error error) {
    error.message = where + ": " + error.message;
    return error;
}

/// A value or an error. Accessing the one that it does not hold is a fault of the caller (asserted).
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    /// Converts a pointer to a derived class into one to its base.
    template <class Derived>
    requires std::is_convertible_v<std::unique_ptr<Derived>, T> Result(std::unique_ptr<Derived> made)
        : state_(std::in_place_index<0>, std::move(made)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }

    T& value() & {
        assert(*this);
        return std::get<0>(state_);
    }
    const T& value() const& {
        assert(*this);
        return std::get<0>(state_);
    }
    T&& value() && {
        assert(*this);
        return std::get<0>(std::move(state_));
    }
    const Error& error() const {
        assert(!*this);
        return std::get<1>(state_);
    }

    T& operator*() { return value(); }
    const T& operator*() const { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

private:
    std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}

    explicit operator bool() const { return !error_; }
    const Error& error() const {
        assert(!*this);
        return *error_;
    }

private:
    std::optional<Error> error_;
};

/// Puts a place before the message of a failed Result.
template <class T>
Result<T> error_at(const std::string& where, Result<T> result) {
    return result ? std::move(result) : error_at(where, result.error());
}

/// Gives a variable the value of a Result: TRY(assign(x, f())), one statement where TRY_ASSIGN is three.
Result<void> assign(auto& to, auto result) {
    if (!result) return result.error();
    to = std::move(*result);
    return {};
}

/// For std::unique_ptr: releases an object of a C library by its function.
template <auto release>
struct ReleasedBy {
    void operator()(auto* object) const { release(object); }
};

/// A base for classes that must not be copied or moved: owners of a unique resource (a descriptor, a thread,
/// a device), objects that others point at, and interfaces, of which a copy would be sliced.
class NonCopyable {
protected:
    NonCopyable() = default;
    ~NonCopyable() = default;
    NonCopyable(const NonCopyable&) = delete;
    NonCopyable& operator=(const NonCopyable&) = delete;
};

}  // namespace touchable
