#include "engine/scene/colour_camera.hpp"

#include <cstddef>

namespace touchable {

CameraPose CameraPose::inverse() const {
    CameraPose back;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
            back.rotation[3 * row + column] = rotation[3 * column + row];
            back.translation[row] -= rotation[3 * column + row] * translation[column];
        }
    }
    return back;
}

CameraPose CameraPose::after(const CameraPose& first) const {
    CameraPose both;
    both.rotation = {};
    both.translation = translation;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t k = 0; k < 3; ++k) {
            const double turn = rotation[3 * row + k];
            both.translation[row] += turn * first.translation[k];
            for (std::size_t column = 0; column < 3; ++column)
                both.rotation[3 * row + column] += turn * first.rotation[3 * k + column];
        }
    return both;
}

}  // namespace touchable
