#pragma once

// Page-aligned memory for planes, which a GPU can read where it is, from one pool of the process.
//
//     const std::shared_ptr<std::uint8_t> memory = take_plane_memory(stride * height);  // a lease
//     ... a decoder writes there; RawFrame::storage holds `memory` ...
//     const auto block = plane_block_of(plane.data, bytes);  // a builder: to import the block, once
//
// A PlaneBlock is whole pages. take_plane_memory leases a block, which returns to the pool when the last copy
// of the pointer goes, and the next lease of this size gets it: fresh pages would cost a page fault each. So
// the planes of a clip lie in a few blocks, in turn. A GPU builder imports each block once, by its id, copies
// from it without the CPU, and holds the PlaneBlock as long as the import exists.
//
// Any thread may call these functions; they hold a lock for some table look-ups. Under AddressSanitizer
// memory that is not leased must not be touched.

#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"

namespace touchable {

/// Planes start at multiples of `plane_alignment` bytes, their rows at multiples of `plane_row_alignment`.
inline constexpr std::size_t plane_alignment = 4096, plane_row_alignment = 64;

/// The next multiple of an alignment, or `bytes` itself.
constexpr std::size_t aligned_bytes(std::size_t bytes, std::size_t alignment) {
    return (bytes + alignment - 1) / alignment * alignment;
}

/// Whole pages of memory, unmapped when the last owner goes.
class PlaneBlock : NonCopyable {
public:
    std::uint8_t* data() const { return data_; }  ///< the start of a page
    std::size_t bytes() const { return bytes_; }  ///< of whole pages
    std::uint64_t id() const { return id_; }      ///< never used twice in a process

protected:
    PlaneBlock(std::uint8_t* data, std::size_t bytes, std::uint64_t id)
        : data_(data), bytes_(bytes), id_(id) {}
    ~PlaneBlock() = default;

private:
    std::uint8_t* const data_;
    const std::size_t bytes_;
    const std::uint64_t id_;
};

/// What leased memory holds at first: anything, or zeros. Zeros cost nothing where the pages are fresh, and
/// fresh pages are not touched.
enum class PlaneContent { any, zero };

/// Leases memory of at least `bytes` bytes, from the start of a page on, in a block that has no other lease.
/// Null where there is no memory.
std::shared_ptr<std::uint8_t> take_plane_memory(std::size_t bytes, PlaneContent content = PlaneContent::any);

/// Takes the bytes of each lease, and the same as a negative number at its end. False: the lease is refused.
/// Only tests define it, which count what an input makes the program take: malloc knows nothing of these
/// pages.
[[gnu::weak]] bool count_planes(std::int64_t bytes);

/// The leased block that all these bytes lie in; null for other memory. Holding the block keeps its pages
/// mapped; only the plane's own storage keeps the samples.
std::shared_ptr<const PlaneBlock> plane_block_of(const void* data, std::size_t bytes);

}  // namespace touchable
