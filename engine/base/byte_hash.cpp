#include "engine/base/byte_hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <new>

#include "engine/base/number_words.hpp"

namespace touchable {

struct ByteHash::State {
    XXH64_state_t* xxh = XXH64_createState();
    ~State() { XXH64_freeState(xxh); }
};

ByteHash::ByteHash() : state_(std::make_unique<State>()) {
    if (!state_->xxh) throw std::bad_alloc();
    XXH64_reset(state_->xxh, 0);
}
ByteHash::~ByteHash() = default;

void ByteHash::add(const void* bytes, std::size_t size) {
    XXH64_update(state_->xxh, bytes, size);
}

std::uint64_t ByteHash::value() const {
    return XXH64_digest(state_->xxh);
}

std::string ByteHash::hex() const {
    return formatted("%016llx", static_cast<unsigned long long>(value()));
}

}  // namespace touchable
