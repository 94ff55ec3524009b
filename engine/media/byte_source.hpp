#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "engine/result.hpp"

namespace touchable {

/// Bytes of a file, of a part of one, or in memory. Cheapest to read in order.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::uint64_t size() const = 0;
    /// All of `count` bytes from `at` on, or what went wrong, after a colon behind the name.
    virtual Result<void> read(std::uint64_t at, char* to, std::size_t count) = 0;
};

/// Bytes that outlive it.
std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes);
Result<std::unique_ptr<ByteSource>> bytes_of_file(const std::filesystem::path& file);

}  // namespace touchable
