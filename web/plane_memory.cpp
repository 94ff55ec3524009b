// SPDX-License-Identifier: Apache-2.0
// Memory of planes in a page, for engine.cpp and lab.cpp: without a GPU, and none is given back to the system.

#include "engine/scene/plane_memory.hpp"

namespace touchable {

std::shared_ptr<std::uint8_t> take_plane_memory(std::size_t bytes, PlaneContent) {
    return {new std::uint8_t[bytes](), std::default_delete<std::uint8_t[]>()};
}
void give_back(void*, std::size_t) {}

}  // namespace touchable
