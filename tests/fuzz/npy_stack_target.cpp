#include "engine/picture/image.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// The first picture, one of the middle and the last.
bool is_stack(ImageStack& stack) {
    require(stack.count() > 0, "a stack has no picture");
    for (const std::int64_t number : {std::int64_t{0}, stack.count() / 2, stack.count() - 1}) {
        const auto picture = stack.image(number);
        if (!is_picture(picture)) return false;
        require(picture->image.width == stack.width() && picture->image.height == stack.height(),
                "a picture is not of the stack's size");
    }
    return true;
}

/// `.npz` where it begins as one.
bool parse_npy_stack(std::string_view bytes) {
    auto stack = open_npy_stack(file_of(bytes, "stack.npy"));
    return is_taken(stack) && is_stack(**stack);
}

/// A TIFF with a single page is no stack, and not taken.
bool parse_tiff_stack(std::string_view bytes) {
    auto stack = open_tiff_stack(file_of(bytes, "stack.tif"));
    return is_taken(stack) && *stack && is_stack(**stack);
}

const Registered npy_stack_target{{.name = "npy_stack", .parse = parse_npy_stack, .cuts_are_refused = true}};
const Registered tiff_stack_target{
    {.name = "tiff_stack", .parse = parse_tiff_stack, .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
