#include "haptics_cpu/force_hash.hpp"

#include <xxhash.h>

#include <array>
#include <bit>
#include <cstdio>

namespace touchable {

struct ForceHash::State {
    XXH64_state_t* xxh = XXH64_createState();
    ~State() { XXH64_freeState(xxh); }
};

ForceHash::ForceHash() : state_(std::make_unique<State>()) {
    XXH64_reset(state_->xxh, 0);
}
ForceHash::~ForceHash() = default;

void ForceHash::add(const glm::dvec3& force) {
    std::array<std::uint8_t, 24> bytes;
    std::size_t at = 0;
    for (const double component : {force.x, force.y, force.z}) {
        const auto bits = std::bit_cast<std::uint64_t>(component == 0 ? 0.0 : component);
        for (int shift = 0; shift < 64; shift += 8) bytes[at++] = static_cast<std::uint8_t>(bits >> shift);
    }
    XXH64_update(state_->xxh, bytes.data(), bytes.size());
}

std::uint64_t ForceHash::value() const {
    return XXH64_digest(state_->xxh);
}

std::string ForceHash::hex() const {
    std::array<char, 17> text;
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value()));
    return text.data();
}

}  // namespace touchable
