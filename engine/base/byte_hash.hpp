#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace touchable {

/// XXH64 (seed 0) of bytes as they come.
class ByteHash {
public:
    ByteHash();
    ~ByteHash();
    ByteHash(const ByteHash&) = delete;
    ByteHash& operator=(const ByteHash&) = delete;

    void add(const void* bytes, std::size_t size);
    std::uint64_t value() const;
    std::string hex() const;  ///< 16 digits

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace touchable
