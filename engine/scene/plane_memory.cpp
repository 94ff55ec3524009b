// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/plane_memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <deque>
#include <iterator>
#include <map>
#include <mutex>
#include <new>

#if defined(__SANITIZE_ADDRESS__)
#define TOUCHABLE_POISON_PLANES
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TOUCHABLE_POISON_PLANES
#endif
#endif
#ifdef TOUCHABLE_POISON_PLANES
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(data, bytes) static_cast<void>(data)
#define ASAN_UNPOISON_MEMORY_REGION(data, bytes) static_cast<void>(data)
#endif

namespace touchable {
namespace {

constexpr std::size_t most_free_bytes = std::size_t{256} << 20;
/// Free blocks of a size are unmapped after so many leases of other sizes. A frame takes a lease for each
/// plane and for each step of its decoding, so this is a few frames of the richest clip.
constexpr std::uint64_t recent_leases = 64;
/// A free block of a size in use is unmapped after so many leases without it, a few seconds of a clip: it is
/// left over from a moment when more frames than usual waited, such as after a stall of a stream.
constexpr std::uint64_t surplus_leases = 1024;

class MappedBlock final : public PlaneBlock {
public:
    MappedBlock(void* pages, std::size_t bytes, std::uint64_t id)
        : PlaneBlock(static_cast<std::uint8_t*>(pages), bytes, id) {}
    ~MappedBlock() {
        ASAN_UNPOISON_MEMORY_REGION(data(), bytes());
        munmap(data(), bytes());
    }
};
using BlockPtr = std::shared_ptr<MappedBlock>;

class PlanePool {
public:
    /// Null if there is no memory.
    std::uint8_t* take(std::size_t bytes, PlaneContent content) {
        static const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
        const std::size_t size = aligned_bytes(std::max<std::size_t>(bytes, 1), page);
        if (size < bytes) return nullptr;
        BlockPtr block = free_block(size);
        const bool is_used = block != nullptr;
        if (!block) {
            void* const pages =
                mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
            if (pages == MAP_FAILED) return nullptr;
            block = std::make_shared<MappedBlock>(pages, size, ++ids_);
        }
        std::uint8_t* const data = block->data();
        ASAN_POISON_MEMORY_REGION(data, size);
        ASAN_UNPOISON_MEMORY_REGION(data, bytes);
        if (is_used && content == PlaneContent::zero) std::memset(data, 0, bytes);
        const std::lock_guard lock(mutex_);
        leased_.emplace(data, std::move(block));
        return data;
    }

    void give_back(std::uint8_t* data) {
        BlockPtr block;  // declared first, so that it is unmapped after the lock
        const std::lock_guard lock(mutex_);
        const auto lease = leased_.find(data);
        block = std::move(lease->second);
        leased_.erase(lease);
        const auto shelf = shelves_.find(block->bytes());
        if (shelf == shelves_.end() || free_bytes_ + block->bytes() > most_free_bytes) return;
        try {
            shelf->second.free.push_back({block, leases_});
        } catch (const std::bad_alloc&) {
            return;  // the block is unmapped, which frees memory
        }
        ASAN_POISON_MEMORY_REGION(data, block->bytes());
        free_bytes_ += block->bytes();
    }

    BlockPtr leased_block(const std::uint8_t* data, std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        const auto after = leased_.upper_bound(data);
        if (after == leased_.begin()) return nullptr;
        const BlockPtr& block = std::prev(after)->second;
        const auto offset = static_cast<std::size_t>(data - block->data());
        return offset <= block->bytes() && bytes <= block->bytes() - offset ? block : nullptr;
    }

private:
    struct FreeBlock {
        BlockPtr block;
        std::uint64_t since;  ///< leases taken before
    };
    struct Shelf {
        std::deque<FreeBlock> free;  ///< the newest last: its samples may be in a cache
        std::uint64_t newest_lease = 0;
    };

    /// Null if no block of this size is free.
    BlockPtr free_block(std::size_t size) {
        std::vector<FreeBlock> old;  // declared first, so that they are unmapped after the lock
        const std::lock_guard lock(mutex_);
        Shelf& shelf = shelves_[size];
        shelf.newest_lease = ++leases_;
        const auto is_old = [this](const Shelf& each) { return leases_ - each.newest_lease > recent_leases; };
        for (auto& [bytes, other] : shelves_) {
            const std::uint64_t longest = is_old(other) ? 0 : surplus_leases;
            for (auto& free = other.free; !free.empty() && leases_ - free.front().since > longest;) {
                old.push_back(std::move(free.front()));
                free.pop_front();
                free_bytes_ -= bytes;
            }
        }
        std::erase_if(shelves_, [&](const auto& entry) { return is_old(entry.second); });
        if (shelf.free.empty()) return nullptr;
        BlockPtr block = std::move(shelf.free.back().block);
        shelf.free.pop_back();
        free_bytes_ -= size;
        return block;
    }

    std::atomic<std::uint64_t> ids_ = 0;
    std::mutex mutex_;
    std::map<const std::uint8_t*, BlockPtr, std::less<>> leased_;  // guarded by mutex_, as are all below
    std::map<std::size_t, Shelf> shelves_;                         // by size
    std::size_t free_bytes_ = 0;
    std::uint64_t leases_ = 0;
};

/// Never destroyed, because static objects may hold leases.
PlanePool& pool() {
    static auto* const pool = new PlanePool;
    return *pool;
}

}  // namespace

std::shared_ptr<std::uint8_t> take_plane_memory(std::size_t bytes, PlaneContent content) {
    const auto count = [](std::int64_t counted) { return !count_planes || count_planes(counted); };
    const auto size = static_cast<std::int64_t>(bytes);
    if (!count(size)) return nullptr;
    std::uint8_t* data = nullptr;
    try {
        data = pool().take(bytes, content);
    } catch (const std::bad_alloc&) {  // of the pool's own records
    }
    if (!data) {
        count(-size);
        return nullptr;
    }
    try {
        return {data, [=](std::uint8_t* leased) {
                    pool().give_back(leased);
                    count(-size);
                }};
    } catch (const std::bad_alloc&) {  // the deleter has run
        return nullptr;
    }
}

std::shared_ptr<const PlaneBlock> plane_block_of(const void* data, std::size_t bytes) {
    return pool().leased_block(static_cast<const std::uint8_t*>(data), bytes);
}

RawFrame kept_frame(const RawFrame& frame) {
    if (frame.storage) return frame;
    RawFrame kept = frame;
    std::size_t bytes = 0;
    PlaneView* const planes[] = {&kept.depth, &kept.colour, &kept.haptic, &kept.height};
    const auto stride = [](const PlaneView& plane) {
        return aligned_bytes(plane.row_bytes(), plane_row_alignment);
    };
    const auto room = [&](const PlaneView& plane) {
        return aligned_bytes(stride(plane) * static_cast<std::size_t>(plane.height), plane_alignment);
    };
    for (const PlaneView* plane : planes)
        if (!plane->empty()) bytes += room(*plane);
    const auto storage = take_plane_memory(bytes);
    if (!storage) throw std::bad_alloc();
    std::uint8_t* to = storage.get();
    for (PlaneView* plane : planes) {
        if (plane->empty()) continue;
        const PlaneView from = *plane;
        plane->data = to;
        plane->stride = static_cast<std::ptrdiff_t>(stride(from));
        from.copy_rows(to, stride(from));
        to += room(from);
    }
    kept.storage = storage;
    return kept;
}

}  // namespace touchable
