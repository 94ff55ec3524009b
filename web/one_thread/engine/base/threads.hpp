// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stands before engine/base/threads.hpp on the include path of WebAssembly, which has one thread here: what
// the engine uses of it, without threads. The worker of a page is never asked to stop: the page ends it.

#include <cstddef>
#include <cstdint>

#include "engine/base/result.hpp"

namespace touchable {

inline bool stop_requested() {
    return false;
}
inline Error interrupted_error() {
    return Error{ErrorKind::interrupted, "stopped"};
}
bool until_stopped(std::size_t count, auto&& work) {
    work(std::size_t{0}, count);
    return true;
}

struct RowBand {
    int first, last, thread;
};
inline int threads_for(long, long, int = 1) {
    return 1;
}
/// All rows are one band of the only thread.
class RowBands : NonCopyable {
public:
    explicit RowBands(int, bool = false) {}
    int threads() const { return 1; }
    template <class Work>
    void for_each_band(int rows, int, Work&& work) {
        if (rows > 0) work(RowBand{0, rows, 0});
    }
};

}  // namespace touchable
