#include "engine/surface/code_picture.hpp"

#include "engine/scene/stored_code.hpp"

namespace touchable {

CodePicture code_picture(const PlaneView& depth, const DepthCoding& coding) {
    CodePicture picture{depth.width, depth.height, {}};
    picture.codes.reserve(static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) {
            const std::uint16_t code = stored_code(depth, coding, x, y);
            picture.codes.push_back(coding.is_valid(code) ? int{code} : CodePicture::invalid);
        }
    return picture;
}

}  // namespace touchable
