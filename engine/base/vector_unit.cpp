#include "engine/base/vector_unit.hpp"

namespace touchable {

std::span<const VectorUnit> usable_vector_units() {
    static constexpr VectorUnit all[] = {VectorUnit::avx512, VectorUnit::avx2, VectorUnit::sse4,
                                         VectorUnit::baseline};
    const std::span<const VectorUnit> units(all);
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512bw")) return units;
    if (__builtin_cpu_supports("avx2")) return units.subspan(1);
    if (__builtin_cpu_supports("sse4.1")) return units.subspan(2);
#endif
    return units.subspan(3);
}

}  // namespace touchable
