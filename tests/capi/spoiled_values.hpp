#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "capi/touchable.h"

namespace touchable::test {

/// What a program passes that does everything wrong, sometimes.
class SpoiledValues {
protected:
    explicit SpoiledValues(unsigned seed) : random_(seed) {}

    std::size_t upto(std::size_t count) { return random_() % count; }
    bool rarely() { return upto(8) == 0; }
    template <class Number>
    Number spoilt(Number number) {
        if (!rarely()) return number;
        using Limits = std::numeric_limits<Number>;
        const Number spoils[] = {Number{},
                                 Limits::max(),
                                 Limits::lowest(),
                                 Number(-1),
                                 Limits::quiet_NaN(),
                                 Limits::infinity(),
                                 Limits::min(),
                                 static_cast<Number>(random_())};
        return spoils[upto(std::size(spoils))];
    }
    template <class T>
    T* or_null(T* pointer) {
        return rarely() ? nullptr : pointer;
    }
    touch_error* error() {
        error_ = {static_cast<std::uint32_t>(upto(sizeof error_ + 1)), 0, {}};
        return or_null(&error_);
    }
    template <class Handle>
    Handle one_of(const std::vector<Handle>& handles) {
        if (handles.empty() || rarely()) return {spoilt(random_())};
        return handles[upto(handles.size())];
    }

    std::mt19937_64 random_;
    touch_error error_{};
};

}  // namespace touchable::test
