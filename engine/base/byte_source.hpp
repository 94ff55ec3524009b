#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Bytes of a file, of a part of one, or in memory. Cheapest to read in order.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::uint64_t size() const = 0;
    /// All of `count` bytes from `at` on, or what went wrong, after a colon behind the name (error_at).
    virtual Result<void> read(std::uint64_t at, char* to, std::size_t count) = 0;
};

/// Bytes that outlive it.
std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes);
/// Of an ordinary file, as long as it was when it was opened (GivenFile).
Result<std::unique_ptr<ByteSource>> bytes_of_file(const SourceFile& file);

/// What a source begins with, `count` bytes or all that there are; nothing where it cannot be read.
std::string first_bytes(ByteSource& bytes, std::size_t count);
std::string first_bytes(const SourceFile& file, std::size_t count);

}  // namespace touchable
