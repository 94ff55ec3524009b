// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts shared by both C libraries (libtouchable: touch_api.cpp, libtouchable-media: clip_api.cpp).
//
// - A HandleTable maps the numbers that a program holds to the objects of one kind, and tells why a number
//   has no object. Each library has its own tables; give_handle adds to one, and end removes from it.
// - fail and fail_without write a touch_error and return the status. without_exceptions wraps every function
//   that allocates: no exception enters a C program.
// - has_known_size, over_defaults, give_defaults and hand_out read and write structs of a program that was
//   compiled with another version of touchable.h.
// - raw_frame reads a program's planes, scene_of_text a scene. A scene is passed between the libraries as
//   text.
//
// All functions may be called from any thread. An object for one thread at a time has an atomic_flag for
// TryLock; a second thread gets TOUCH_BUSY.

#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string_view>

#include "capi/touchable.h"
#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::capi {

/// Result of destroying an object.
enum class Removal { removed, stale, busy };

/// Whether a forked process may use its parent's objects. Threads and connections are not inherited, and a
/// file's position is shared, so objects with those are refused.
enum class Forked { usable, refused };

/// Guards all tables of a library. A fork takes it, so that it is free in the child.
inline std::mutex tables_mutex;
/// The number of forks between the first process and this one.
inline std::atomic<unsigned> forks{0};

inline void watch_forks() {
    [[maybe_unused]] static const int watched =
        pthread_atfork([] { tables_mutex.lock(); }, [] { tables_mutex.unlock(); },
                       [] {
                           tables_mutex.unlock();
                           forks.fetch_add(1);
                       });
}

/// Objects by number, which consists of kind, generation and place. A number of another kind, or of a removed
/// object, finds nothing. `find` is wait-free, from any thread; an object in use is not removed.
template <class T, std::size_t most = 1024>
class HandleTable {
    struct Slot;

public:
    static constexpr std::size_t capacity = most;

    /// `kind`: 1 to 15, unique to each table.
    HandleTable(std::uint64_t kind, Forked forked) : kind_(kind << 60), forked_(forked) { watch_forks(); }

    /// While it exists, the object cannot be removed. Empty: no such object, or it is the parent process's.
    class Use {
    public:
        Use() = default;
        explicit Use(Slot& slot) : slot_(&slot) {}
        static Use of_parent() {
            Use use;
            use.is_of_parent_ = true;
            return use;
        }
        Use(Use&& other) noexcept
            : slot_(std::exchange(other.slot_, nullptr)), is_of_parent_(other.is_of_parent_) {}
        Use& operator=(Use&&) = delete;
        ~Use() {
            if (slot_) slot_->users.fetch_sub(1, std::memory_order_release);
        }
        explicit operator bool() const { return slot_ != nullptr; }
        bool is_of_parent() const { return is_of_parent_; }
        T& operator*() const { return *slot_->object; }
        T* operator->() const { return slot_->object.get(); }
        const std::shared_ptr<T>& shared() const { return slot_->object; }

    private:
        Slot* slot_ = nullptr;
        bool is_of_parent_ = false;
    };

    /// Nothing if the table is full.
    std::optional<std::uint64_t> insert(std::shared_ptr<T> object) {
        const std::lock_guard lock(tables_mutex);
        for (std::size_t tried = 0; tried < capacity; ++tried) {
            const std::size_t k = next_;
            next_ = (next_ + 1) % capacity;
            Slot& slot = slots_[k];
            if (slot.object) continue;
            slot.object = std::move(object);
            slot.made_in.store(forks.load(std::memory_order_relaxed), std::memory_order_relaxed);
            slot.generation = (slot.generation + 1) & 0x0fffffffU;
            const std::uint64_t id = kind_ | std::uint64_t{slot.generation} << 32 | k;
            slot.id.store(id, std::memory_order_release);
            return id;
        }
        return std::nullopt;
    }

    Use find(std::uint64_t id) {
        const std::size_t place = id & 0xffffffffU;
        if (place >= capacity || id == 0) return {};
        Slot& slot = slots_[place];
        if (slot.id.load(std::memory_order_acquire) != id) return {};
        if (forked_ == Forked::refused && is_of_parent(slot)) return Use::of_parent();
        if (slot.users.fetch_add(1, std::memory_order_acq_rel) >= 0 &&
            slot.id.load(std::memory_order_acquire) == id)
            return Use(slot);
        slot.users.fetch_sub(1, std::memory_order_release);
        return {};
    }

    /// Returns busy while the object is used. The parent process's object is forgotten, not destroyed: its
    /// threads do not exist here, and its locks may be held for ever.
    Removal remove(std::uint64_t id) {
        std::shared_ptr<T> last;  // destroyed after the lock
        const std::lock_guard lock(tables_mutex);
        const std::size_t place = id & 0xffffffffU;
        if (place >= capacity || id == 0) return Removal::stale;
        Slot& slot = slots_[place];
        if (slot.id.load(std::memory_order_relaxed) != id) return Removal::stale;
        const bool of_parent = is_of_parent(slot);
        if (of_parent) parents_.reserve(parents_.size() + 1);
        int unused = 0;
        if (of_parent)
            slot.users.store(gone, std::memory_order_relaxed);  // threads of the parent may have used it
        else if (!slot.users.compare_exchange_strong(unused, gone, std::memory_order_acq_rel))
            return Removal::busy;
        slot.id.store(0, std::memory_order_release);
        last = std::move(slot.object);
        slot.object = nullptr;
        slot.users.fetch_sub(gone, std::memory_order_release);
        if (of_parent) parents_.push_back(std::move(last));
        return Removal::removed;
    }

    /// Calls `look` for each present object, outside the lock.
    void for_each(const std::function<void(const T&)>& look) {
        std::vector<std::shared_ptr<T>> all;
        {
            const std::lock_guard lock(tables_mutex);
            for (const Slot& slot : slots_)
                if (slot.object) all.push_back(slot.object);
        }
        for (const auto& object : all) look(*object);
    }

private:
    static constexpr int gone = -(1 << 30);
    struct Slot {
        std::atomic<std::uint64_t> id{0};
        std::atomic<int> users{0};
        std::atomic<unsigned> made_in{0};  // value of `forks`
        std::shared_ptr<T> object;
        std::uint32_t generation = 0;
    };

    static bool is_of_parent(const Slot& slot) {
        return slot.made_in.load(std::memory_order_relaxed) != forks.load(std::memory_order_relaxed);
    }

    const std::uint64_t kind_;
    const Forked forked_;
    std::vector<std::shared_ptr<T>> parents_;  // forgotten objects, never destroyed
    std::size_t next_ = 0;  // where the search for a free place begins: skips places found full before
    std::array<Slot, capacity> slots_;
};

/// The handles of one kind of object: made at the first use, and never destroyed, as threads of the program
/// may outlive the library's static objects.
template <class T, std::uint64_t kind, Forked forked, std::size_t most = 1024>
HandleTable<T, most>& handles() {
    static auto& table = *new HandleTable<T, most>(kind, forked);
    return table;
}

/// A non-blocking lock: a second thread does not get it.
class TryLock : NonCopyable {
public:
    explicit TryLock(std::atomic_flag& flag)
        : flag_(flag), mine_(!flag.test_and_set(std::memory_order_acquire)) {}
    ~TryLock() {
        if (mine_) flag_.clear(std::memory_order_release);
    }
    explicit operator bool() const { return mine_; }

private:
    std::atomic_flag& flag_;
    const bool mine_;
};

/// Writes status and line to `error`, if not null, and returns the status.
touch_status fail(touch_error* error, touch_status status, std::string_view line) noexcept;
touch_status fail(touch_error* error, const Error& what) noexcept;
/// Fails with TOUCH_STALE; `kind`: the handle's kind, such as "surface".
touch_status fail_stale(touch_error* error, const char* kind);

/// The status for an empty HandleTable::Use.
template <class Use>
touch_status status_without(const Use& use) noexcept {
    return use.is_of_parent() ? TOUCH_FORKED : TOUCH_STALE;
}
template <class Use>
touch_status fail_without(const Use& use, touch_error* error, const char* kind) {
    if (!use.is_of_parent()) return fail_stale(error, kind);
    return fail(
        error, TOUCH_FORKED,
        "the " + std::string(kind) + " belongs to the parent process; open or make another one after fork()");
}

/// Calls `use` with a handle's object; the status tells if there is none.
template <class Object, std::size_t most, class Handle, class Function>
touch_status with_object(HandleTable<Object, most>& table, Handle handle, Function&& use) {
    const auto object = table.find(handle.id);
    if (!object) return status_without(object);
    use(*object);
    return TOUCH_OK;
}
/// The same with an object for one thread at a time, whose `flag` tells a second thread so.
template <class Object, std::size_t most, class Handle, class Function>
touch_status with_object(HandleTable<Object, most>& table, Handle handle, std::atomic_flag Object::*flag,
                         Function&& use) {
    const auto object = table.find(handle.id);
    if (!object) return status_without(object);
    const TryLock lock((*object).*flag);
    if (!lock) return TOUCH_BUSY;
    use(*object);
    return TOUCH_OK;
}

/// Size of a struct in its first version, the smallest that a program may state. A struct that grows gets a
/// specialisation with its first size.
template <class T>
inline constexpr std::size_t first_size = sizeof(T);
template <>
inline constexpr std::size_t first_size<touch_frame> = offsetof(touch_frame, lost_pixels);
template <>
inline constexpr std::size_t first_size<touch_contact> = offsetof(touch_contact, error_degrees);
template <>
inline constexpr std::size_t first_size<touch_clip_settings> = offsetof(touch_clip_settings, near_m);

/// Whether a program's struct has a size known to this library.
template <class T>
bool has_known_size(const T* given) {
    return given && given->struct_size >= first_size<T> && given->struct_size <= sizeof(T);
}

/// Whether a tick or time is far from overflow.
constexpr bool is_countable(std::int64_t value) {
    constexpr std::int64_t farthest = std::int64_t{1} << 60;
    return value >= -farthest && value <= farthest;
}

/// `defaults`, overwritten by the program's struct; null: not overwritten.
template <class T>
T over_defaults(const T* given, T defaults) {
    if (given) std::memcpy(&defaults, given, given->struct_size);
    return defaults;
}

/// Writes `struct_size` bytes of the defaults, and the size. TOUCH_USAGE: NULL or an unknown size.
template <class T>
touch_status give_defaults(const T& defaults, T* to, std::uint32_t struct_size) noexcept {
    if (!to || struct_size < first_size<T> || struct_size > sizeof(T)) return TOUCH_USAGE;
    std::memcpy(to, &defaults, struct_size);
    to->struct_size = struct_size;
    return TOUCH_OK;
}

/// Writes as many bytes as the program's struct has.
template <class T>
void hand_out(const T& from, T& to) {
    const std::uint32_t size = to.struct_size;
    std::memcpy(&to, &from, size);
    to.struct_size = size;
}

/// Writes at most `capacity` bytes of a text, zero-terminated if there is room; `length`: that of the whole
/// text.
inline void write_text(std::string_view from, char* text, std::size_t capacity, std::size_t& length) {
    length = from.size();
    if (capacity == 0) return;
    std::memcpy(text, from.data(), std::min(capacity, from.size()));
    if (capacity > from.size()) text[from.size()] = 0;
}

/// Runs a function that returns a status, or the error to report. Catches all exceptions: missing memory
/// becomes TOUCH_NO_MEMORY, anything else an internal fault.
template <class Function>
touch_status without_exceptions(touch_error* error, Function&& function) noexcept {
    try {
        const Result<touch_status> done = function();
        return done ? *done : fail(error, done.error());
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

/// Puts an object into its table and its number into `handle`.
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

/// Removes a handle's object.
template <class Object, std::size_t most, class Handle>
touch_status end(HandleTable<Object, most>& table, Handle handle) noexcept {
    return without_exceptions(nullptr, [&]() -> touch_status {
        const Removal removal = table.remove(handle.id);
        if (removal == Removal::busy) return TOUCH_BUSY;
        return removal == Removal::removed ? TOUCH_OK : TOUCH_STALE;
    });
}

/// Copies of planes that modules cannot read in place: floats, bottom-up rows, misaligned samples.
struct FrameScratch {
    std::vector<std::uint16_t> codes;
    std::vector<std::uint8_t> planes[4];
    /// Of uint16 depth, once floats have settled the scene: they are lengths in these steps, scene units; 0:
    /// they are codes.
    double integer_scale = 0;
};

/// A program's frame as a RawFrame without `storage`: valid as long as the program's memory and `scratch`.
/// Refused: a struct of unknown size, invalid planes, floats if depth has no code for "no surface".
Result<RawFrame> raw_frame(const touch_frame& frame, const Scene& scene, FrameScratch& scratch);
/// The scene that depth of this kind (TOUCH_U16, ...) settles, where Scene::float_scale leaves it open.
Scene scene_of_depth(Scene scene, std::int32_t sample);
/// FrameScratch::integer_scale after a first frame of that kind.
inline double integer_scale_after(const Scene& scene, std::int32_t sample) {
    return scene.float_scale > 0 && sample == TOUCH_F32 ? scene.depth.scale : 0;
}
/// Reads a depth plane of codes, without the rest of a frame.
Result<PlaneView> depth_codes(const touch_plane& depth, const Scene& scene, FrameScratch& scratch);
/// A module's plane as a program's touch_plane.
touch_plane plane_for_program(const PlaneView& view);

/// The scene of a scene file's text, settled; `unstated` lists the filters that the text leaves open.
Result<SceneDescription> scene_of_text(std::string_view text);

}  // namespace touchable::capi
