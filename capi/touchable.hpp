// SPDX-License-Identifier: Apache-2.0
// touchable.hpp - touchable.h for C++17: owning objects, and errors as exceptions. Header only. touchable.h
// describes the functions' arguments, results, units and threads.
#ifndef TOUCHABLE_HPP
#define TOUCHABLE_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "touchable.h"

namespace touch {

/// An error of a function of touchable.h, in one line.
class Error : public std::runtime_error {
public:
    Error(touch_status status, const std::string& line) : std::runtime_error(line), status_(status) {}
    touch_status status() const noexcept { return status_; }

private:
    touch_status status_;
};

namespace detail {

/// Throws an Error unless the status is TOUCH_OK, TOUCH_FULL or TOUCH_END.
inline touch_status check(touch_status status, const touch_error& error = {}) {
    if (status == TOUCH_OK || status == TOUCH_FULL || status == TOUCH_END) return status;
    throw Error(status, error.line[0] ? error.line : touch_status_name(status));
}

/// Calls a function whose last argument is a touch_error, and throws its error.
template <class Function, class... Arguments>
touch_status call(Function function, Arguments... arguments) {
    touch_error error{sizeof(touch_error), TOUCH_OK, {}};
    return check(function(arguments..., &error), error);
}

/// The handle that a function writes to the argument before its touch_error.
template <class Handle, class Function, class... Arguments>
Handle made_by(Function function, Arguments... arguments) {
    Handle made{};
    call(function, arguments..., &made);
    return made;
}

/// An owning handle.
template <class Handle, touch_status (*destroy)(Handle)>
class Owner {
public:
    Owner() = default;
    explicit Owner(Handle handle) noexcept : handle_(handle) {}
    Owner(Owner&& other) noexcept : handle_(std::exchange(other.handle_, Handle{})) {}
    Owner& operator=(Owner&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owner() {
        if (handle_.id) destroy(handle_);
    }
    Handle get() const noexcept { return handle_; }

private:
    Handle handle_{};
};

/// A struct with its defaults.
template <class Struct, touch_status (*defaults)(Struct*, std::uint32_t)>
Struct made() {
    Struct made{};
    check(defaults(&made, sizeof made));
    return made;
}

}  // namespace detail

inline touch_camera camera() {
    return detail::made<touch_camera, touch_camera_defaults>();
}
inline touch_frame frame() {
    return detail::made<touch_frame, touch_frame_defaults>();
}
inline touch_surface_settings surface_settings() {
    return detail::made<touch_surface_settings, touch_surface_settings_defaults>();
}
inline touch_solver_settings solver_settings() {
    return detail::made<touch_solver_settings, touch_solver_settings_defaults>();
}
/// Tick number `tick`, at that many milliseconds of the frames' clock.
inline touch_tick tick_at(std::int64_t tick) noexcept {
    return {sizeof(touch_tick), 0, tick, tick * 1'000'000, 0, 0};
}

/// touch_scene.
class Scene : public detail::Owner<touch_scene, touch_scene_destroy> {
public:
    using Owner::Owner;
    explicit Scene(const touch_camera& camera)
        : Owner(detail::made_by<touch_scene>(touch_scene_from_camera, &camera)) {}
    explicit Scene(std::string_view text)
        : Owner(detail::made_by<touch_scene>(touch_scene_from_text, text.data(), text.size())) {}
    touch_scene_facts facts() const {
        touch_scene_facts facts{};
        facts.struct_size = sizeof facts;
        detail::check(touch_scene_describe(get(), &facts));
        return facts;
    }
    std::string text() const {
        std::size_t length = 0;
        detail::check(touch_scene_text(get(), nullptr, 0, &length));
        std::string text(length, '\0');
        detail::check(touch_scene_text(get(), text.data(), text.size(), &length));
        return text;
    }
    /// Depth in metres, row after row without gaps: the scene's width x height.
    void metres(const touch_plane& depth, float* metres) const {
        detail::call(touch_scene_metres, get(), &depth, metres, std::int64_t{4} * facts().width);
    }
    /// touch_scene_with_filters.
    Scene with_filters(const std::vector<touch_frame>& frames) const {
        return Scene(detail::made_by<touch_scene>(touch_scene_with_filters, get(), frames.data(),
                                                  sizeof(touch_frame), frames.size()));
    }
};

/// touch_surface.
class Surface : public detail::Owner<touch_surface, touch_surface_destroy> {
public:
    using Owner::Owner;
    explicit Surface(const Scene& scene, const touch_surface_settings& settings = surface_settings())
        : Owner(detail::made_by<touch_surface>(touch_surface_create, scene.get(), &settings)) {}
    /// False: no room yet (TOUCH_FULL).
    bool push(const touch_frame& frame) {
        return detail::call(touch_surface_push, get(), &frame) == TOUCH_OK;
    }
    void begin_epoch(std::uint64_t epoch) { detail::call(touch_surface_begin_epoch, get(), epoch); }
    void end_epoch() { detail::check(touch_surface_end_epoch(get())); }
    /// INT64_MIN before the first frame.
    std::int64_t newest_ns() const noexcept {
        std::int64_t newest = std::numeric_limits<std::int64_t>::min();
        touch_surface_newest_ns(get(), &newest);
        return newest;
    }
    double hand_scale() const {
        double scale = 0;
        detail::call(touch_surface_hand_scale, get(), &scale);
        return scale;
    }
    /// touch_surface_forces_at.
    std::vector<touch_contact> forces_at(const touch_tick& moment, const std::vector<touch_vec3>& points,
                                         std::int32_t friction = TOUCH_FRICTION_OFF,
                                         const touch_solver_settings& settings = solver_settings()) const {
        std::vector<touch_contact> contacts(points.size());
        detail::call(touch_surface_forces_at, get(), &settings, &moment, friction, points.data(),
                     points.size(), contacts.data(), sizeof(touch_contact));
        return contacts;
    }
};

/// touch_solver. Must be destroyed before its surface.
class Solver : public detail::Owner<touch_solver, touch_solver_destroy> {
public:
    using Owner::Owner;
    explicit Solver(const Surface& surface, const touch_solver_settings& settings = solver_settings())
        : Owner(detail::made_by<touch_solver>(touch_solver_create, surface.get(), &settings)) {}
    /// An element per finger in both. Real-time: it does not throw.
    touch_status tick(const touch_tick& tick, const touch_vec3* goals, touch_contact* contacts) noexcept {
        return touch_solver_tick(get(), &tick, goals, contacts, sizeof(touch_contact));
    }
    /// touch_solver_run.
    touch_status run(const touch_tick& first, std::size_t count, const touch_vec3* goals,
                     touch_contact* contacts) noexcept {
        return touch_solver_run(get(), &first, count, goals, contacts, sizeof(touch_contact));
    }
    touch_status come_back() noexcept { return touch_solver_come_back(get()); }
    std::uint64_t force_hash() const {
        std::uint64_t hash = 0;
        detail::check(touch_solver_force_hash(get(), &hash));
        return hash;
    }
    /// touch_solver_save.
    std::vector<std::uint8_t> save() const {
        std::size_t length = 0;
        detail::check(touch_solver_save(get(), nullptr, 0, &length));
        std::vector<std::uint8_t> state(length);
        detail::check(touch_solver_save(get(), state.data(), state.size(), &length));
        return state;
    }
    /// touch_solver_load.
    void load(const std::vector<std::uint8_t>& state) {
        detail::call(touch_solver_load, get(), state.data(), state.size());
    }
};

// The rest needs libtouchable-media.

inline touch_clip_settings clip_settings() {
    return detail::made<touch_clip_settings, touch_clip_settings_defaults>();
}
inline touch_writer_settings writer_settings() {
    return detail::made<touch_writer_settings, touch_writer_settings_defaults>();
}

/// touch_frameset: its pictures stay at their place until it is destroyed.
class Frameset : public detail::Owner<touch_frameset, touch_frameset_release> {
public:
    using Owner::Owner;
    touch_frame frame() const {
        touch_frame frame = touch::frame();
        detail::check(touch_frameset_frame(get(), &frame));
        return frame;
    }
};

/// touch_clip.
class Clip : public detail::Owner<touch_clip, touch_clip_close> {
public:
    using Owner::Owner;
    explicit Clip(const std::string& path, const touch_clip_settings& settings = clip_settings())
        : Owner(detail::made_by<touch_clip>(touch_clip_open, path.c_str(), &settings)) {}
    touch_clip_facts facts() const {
        touch_clip_facts facts{};
        facts.struct_size = sizeof facts;
        detail::check(touch_clip_describe(get(), &facts));
        return facts;
    }
    std::int64_t time_ns(std::int64_t frame) const {
        std::int64_t time = 0;
        detail::check(touch_clip_time(get(), frame, &time));
        return time;
    }
    /// All notes of touch_clip_note.
    std::vector<std::string> notes() const {
        std::vector<std::string> notes;
        std::size_t length = 0;
        for (std::int32_t index = 0; touch_clip_note(get(), index, nullptr, 0, &length) == TOUCH_OK;
             ++index) {
            notes.emplace_back(length, '\0');
            detail::check(touch_clip_note(get(), index, notes.back().data(), length, &length));
        }
        return notes;
    }
    /// `filters`: TOUCH_FILTERS_STATED or TOUCH_FILTERS_CHOSEN.
    Scene scene(std::int32_t filters = TOUCH_FILTERS_CHOSEN) {
        return Scene(detail::made_by<touch_scene>(touch_clip_scene, get(), filters));
    }
    /// Nothing: no more frames.
    std::optional<Frameset> next() {
        touch_frameset next{};
        if (detail::call(touch_clip_next, get(), &next) == TOUCH_END) return std::nullopt;
        return Frameset(next);
    }
    void seek(std::int64_t frame) { detail::call(touch_clip_seek, get(), frame); }
    /// Any thread.
    void interrupt() noexcept { touch_clip_interrupt(get()); }
};

/// touch_writer: without `finish` no file is left.
class Writer : public detail::Owner<touch_writer, touch_writer_abandon> {
public:
    using Owner::Owner;
    Writer(const std::string& path, const Scene& scene,
           const touch_writer_settings& settings = writer_settings())
        : Owner(detail::made_by<touch_writer>(touch_writer_create, path.c_str(), scene.get(), &settings)) {}
    void write(const touch_frame& frame) { detail::call(touch_writer_write, get(), &frame); }
    /// Once, after the last frame.
    void finish() { detail::call(touch_writer_finish, get()); }
};

}  // namespace touch

#endif
