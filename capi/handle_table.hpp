#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace touchable::capi {

/// What became of an object that was to be destroyed.
enum class Removal { removed, stale, busy };

/// Objects by number: kind, generation and place. A number of another kind, or of an object that is gone,
/// finds nothing. Finding is wait-free, from any thread; an object that somebody is using is not removed.
template <class T, std::size_t most = 1024>
class HandleTable {
    struct Slot;

public:
    static constexpr std::size_t capacity = most;

    /// `kind`: 1 to 15, another one for each table.
    explicit HandleTable(std::uint64_t kind) : kind_(kind << 60) {}

    /// Keeps the object from being removed while it lives. Empty: there is no such object.
    class Use {
    public:
        Use() = default;
        explicit Use(Slot& slot) : slot_(&slot) {}
        Use(Use&& other) noexcept : slot_(std::exchange(other.slot_, nullptr)) {}
        Use& operator=(Use&&) = delete;
        ~Use() {
            if (slot_) slot_->users.fetch_sub(1, std::memory_order_release);
        }
        explicit operator bool() const { return slot_ != nullptr; }
        T& operator*() const { return *slot_->object; }
        T* operator->() const { return slot_->object.get(); }
        const std::shared_ptr<T>& shared() const { return slot_->object; }

    private:
        Slot* slot_ = nullptr;
    };

    /// Nothing where the table is full.
    std::optional<std::uint64_t> insert(std::shared_ptr<T> object) {
        const std::lock_guard lock(mutex_);
        for (std::size_t tried = 0; tried < capacity; ++tried) {
            const std::size_t k = next_;
            next_ = (next_ + 1) % capacity;
            Slot& slot = slots_[k];
            if (slot.object) continue;
            slot.object = std::move(object);
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
        if (slot.users.fetch_add(1, std::memory_order_acq_rel) >= 0 &&
            slot.id.load(std::memory_order_acquire) == id)
            return Use(slot);
        slot.users.fetch_sub(1, std::memory_order_release);
        return {};
    }

    /// Busy where somebody uses it.
    Removal remove(std::uint64_t id) {
        std::shared_ptr<T> last;  // ends after the lock
        const std::lock_guard lock(mutex_);
        const std::size_t place = id & 0xffffffffU;
        if (place >= capacity || id == 0) return Removal::stale;
        Slot& slot = slots_[place];
        if (slot.id.load(std::memory_order_relaxed) != id) return Removal::stale;
        int nobody = 0;
        if (!slot.users.compare_exchange_strong(nobody, gone, std::memory_order_acq_rel))
            return Removal::busy;
        slot.id.store(0, std::memory_order_release);
        last = std::move(slot.object);
        slot.object = nullptr;
        slot.users.fetch_sub(gone, std::memory_order_release);
        return Removal::removed;
    }

    /// Looks at all of them, of which none is removed meanwhile.
    void for_each(const std::function<void(const T&)>& look) {
        const std::lock_guard lock(mutex_);
        for (const Slot& slot : slots_)
            if (slot.object) look(*slot.object);
    }

private:
    static constexpr int gone = -(1 << 30);
    struct Slot {
        std::atomic<std::uint64_t> id{0};
        std::atomic<int> users{0};
        std::shared_ptr<T> object;
        std::uint32_t generation = 0;
    };

    const std::uint64_t kind_;
    std::mutex mutex_;
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
