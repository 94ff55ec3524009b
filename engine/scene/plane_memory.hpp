// SPDX-License-Identifier: Apache-2.0
#pragma once

// Page-aligned memory for planes, which a GPU can read in place, from one pool of the process.
//
//     const std::shared_ptr<std::uint8_t> memory = take_plane_memory(stride * height);  // a lease
//     ... a decoder writes there; RawFrame::storage holds `memory` ...
//     const auto block = plane_block_of(plane.data, bytes);  // a builder: to import the block, once
//
// A PlaneBlock is whole pages. take_plane_memory leases a block, which returns to the pool with the last copy
// of the pointer, and is reused by the next lease of its size: fresh pages would cost a page fault each. So
// the planes of a clip take turns in a few blocks. A GPU builder imports each block once, by its id, copies
// from it without the CPU, and holds the PlaneBlock as long as the import exists.
//
// Threads: any may call these functions; they hold a lock for some table look-ups. Under AddressSanitizer
// memory that is not leased must not be touched.

#include <cstddef>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// Planes start at multiples of `plane_alignment` bytes, their rows at multiples of `plane_row_alignment`.
inline constexpr std::size_t plane_alignment = 4096, plane_row_alignment = 64;

/// `bytes`, rounded up to a multiple of an alignment.
constexpr std::size_t aligned_bytes(std::size_t bytes, std::size_t alignment) {
    return (bytes + alignment - 1) / alignment * alignment;
}

/// Whole pages of memory, unmapped when the last owner goes.
class PlaneBlock : NonCopyable {
public:
    std::uint8_t* data() const { return data_; }  ///< the start of a page
    std::size_t bytes() const { return bytes_; }  ///< a multiple of the page size
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

/// Initial content of leased memory: anything, or zeros. Zeros cost nothing if the pages are fresh, and do
/// not touch fresh pages.
enum class PlaneContent { any, zero };

/// Leases memory of at least `bytes` bytes, from the start of a page on, in a block that has no other lease.
/// Null if there is no memory.
std::shared_ptr<std::uint8_t> take_plane_memory(std::size_t bytes, PlaneContent content = PlaneContent::any);

/// Called with the bytes of each lease, and with their negative at its end. False: the lease is refused. Only
/// tests define it, to count the memory that an input takes: malloc knows nothing of these pages.
[[gnu::weak]] bool count_planes(std::int64_t bytes);

/// The leased block that all these bytes lie in; null for other memory. Holding the block keeps its pages
/// mapped; only the plane's own storage keeps the samples.
std::shared_ptr<const PlaneBlock> plane_block_of(const void* data, std::size_t bytes);

/// A frame that outlives the call that gave it: the same if its storage keeps its planes, otherwise a copy.
RawFrame kept_frame(const RawFrame& frame);

}  // namespace touchable
