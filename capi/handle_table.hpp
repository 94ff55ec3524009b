#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace touchable::capi {

/// What became of an object that was to be destroyed.
enum class Removal { removed, stale, busy };

/// What a process that was forked may do with the objects of its parent. Threads and connections do not come
/// along, and a file's position is shared: what has those is refused.
enum class Forked { usable, refused };

/// For all tables of a library: a fork waits for it, so that a child finds it free.
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

/// Objects by number: kind, generation and place. A number of another kind, or of an object that is gone,
/// finds nothing. Finding is wait-free, from any thread; an object that somebody is using is not removed.
template <class T, std::size_t most = 1024>
class HandleTable {
    struct Slot;

public:
    static constexpr std::size_t capacity = most;

    /// `kind`: 1 to 15, another one for each table.
    HandleTable(std::uint64_t kind, Forked forked) : kind_(kind << 60), forked_(forked) { watch_forks(); }

    /// Keeps the object from being removed while it lives. Empty: there is no such object, or it is the
    /// parent process's.
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

    /// Nothing where the table is full.
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

    /// Busy while it is used. The parent process's object is forgotten and not ended: its threads are not
    /// here, and its locks may be held for ever.
    Removal remove(std::uint64_t id) {
        std::shared_ptr<T> last;  // ends after the lock
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

    /// Looks at all that there are now; nothing waits for it.
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
        std::atomic<unsigned> made_in{0};  // of `forks`
        std::shared_ptr<T> object;
        std::uint32_t generation = 0;
    };

    static bool is_of_parent(const Slot& slot) {
        return slot.made_in.load(std::memory_order_relaxed) != forks.load(std::memory_order_relaxed);
    }

    const std::uint64_t kind_;
    const Forked forked_;
    std::vector<std::shared_ptr<T>> parents_;  // forgotten here, and never ended
    std::size_t next_ = 0;  // where a free place is looked for first: of many none is looked at twice
    std::array<Slot, capacity> slots_;
};

/// One thread at a time: whoever comes second does not get it.
class TryLock {
public:
    explicit TryLock(std::atomic_flag& flag)
        : flag_(flag), mine_(!flag.test_and_set(std::memory_order_acquire)) {}
    ~TryLock() {
        if (mine_) flag_.clear(std::memory_order_release);
    }
    TryLock(const TryLock&) = delete;
    TryLock& operator=(const TryLock&) = delete;
    explicit operator bool() const { return mine_; }

private:
    std::atomic_flag& flag_;
    const bool mine_;
};

}  // namespace touchable::capi
