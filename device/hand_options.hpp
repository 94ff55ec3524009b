#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// One key that a hand, a simulated device or a camera understands. Numbers have a range and a default; words
/// (names of columns) do not.
struct HandKey {
    enum class Kind { number, whole, words };
    std::string_view name;
    std::string_view unit;
    double least = 0;
    double greatest = 0;
    double standard = 0;
    Kind kind = Kind::number;
};

/// The key=value pairs of a description, checked against the keys that are understood.
class HandOptions {
public:
    /// `text` is "key=value,key=value" or empty; `keys` must outlive the options. Refuses (ErrorKind::usage)
    /// an unknown key, a key given twice, a value that is no number or out of range; names the legal ones,
    /// and whose they are: `of`, as "hand 'wander'".
    static Result<HandOptions> parse(std::string_view of, std::string_view text,
                                     std::span<const HandKey> keys);

    bool given(std::string_view name) const;
    double number(std::string_view name) const;      ///< as given, or the key's default
    std::string words(std::string_view name) const;  ///< as given, or empty

private:
    struct Entry {
        const HandKey* key;
        double number;
        std::string words;
    };
    Result<Entry> entry(std::string_view of, std::string_view item) const;
    const Entry* find(std::string_view name) const;

    std::span<const HandKey> keys_;
    std::vector<Entry> entries_;
};

}  // namespace touchable
