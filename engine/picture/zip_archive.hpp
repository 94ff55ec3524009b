// SPDX-License-Identifier: Apache-2.0
#pragma once

// ZIP archives, read by libzip: their members, and the bytes of each, unpacked as they are read.
//
// What an archive states is not trusted: its directory is read up to a bound, and a member gives no more
// bytes than it states. Errors are lines about the file.
// Threads: one uses an archive and its members.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

struct zip;  // libzip's zip_t

namespace touchable {

using ZipArchive = std::shared_ptr<zip>;

/// Refused if it is damaged, or has more than `most_members` members. Messages begin with `where`.
Result<ZipArchive> open_zip(std::unique_ptr<ByteSource> bytes, std::uint64_t most_members,
                            const std::string& where);

struct ZipMember {
    std::string name;  ///< as stored: it may lead anywhere
    std::uint64_t index = 0;
    std::uint64_t size = 0, packed = 0;  ///< bytes, as stated
    bool is_file = true;                 ///< neither a folder nor a link nor a device
    bool is_encrypted = false;

    /// Whether `packed` bytes can unpack to `size`: deflate makes at most 1032 bytes of one.
    bool is_possible() const { return size / 1032 <= packed; }
};
/// Members that state a name and a size.
std::vector<ZipMember> zip_members(const ZipArchive& archive);

/// A member's unpacked bytes. Errors do not name it. Reading backward unpacks from the beginning again. The
/// checksum is verified after the last byte.
std::unique_ptr<ByteSource> unpacked_member(const ZipArchive& archive, const ZipMember& member);

}  // namespace touchable
