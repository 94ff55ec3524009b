#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// What the records of a recording of ROS 1 are.
enum class BagOp : std::uint8_t {
    message = 2,
    bag_header = 3,
    index = 4,
    chunk = 5,
    chunk_info = 6,
    connection = 7
};

/// Fields "name=value" of a record, whose values are bytes.
class BagFields {
public:
    /// Nothing where they do not fill the bytes.
    static std::optional<BagFields> of(std::string bytes);

    std::optional<std::string_view> text(std::string_view name) const;
    /// An unsigned number, low byte first, of exactly its type's size.
    template <class Number>
    std::optional<Number> number(std::string_view name) const {
        const auto value = text(name);
        if (!value || value->size() != sizeof(Number)) return {};
        Number number;
        std::memcpy(&number, value->data(), sizeof number);
        return number;
    }

private:
    std::string bytes_;
};

/// A record's fields, and where its data are.
struct BagRecord {
    BagFields fields;
    std::uint64_t data_at = 0;
    std::uint32_t size = 0;  ///< of its data

    std::uint64_t end() const { return data_at + size; }
    bool is(BagOp op) const { return fields.number<std::uint8_t>("op") == static_cast<std::uint8_t>(op); }
};

/// The record that begins at `at` and ends by `end`. An error says what is wrong, but not in which file.
Result<BagRecord> read_bag_record(ByteSource& bytes, std::uint64_t at, std::uint64_t end);

}  // namespace touchable
