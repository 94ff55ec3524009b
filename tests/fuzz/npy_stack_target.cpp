#include "engine/picture/image.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// Of a file, its first pictures and the last; `.npz` where it begins as one.
bool parse_npy_stack(std::string_view bytes) {
    auto stack = open_npy_stack(file_of(bytes, "stack.npy"));
    if (!is_taken(stack)) return false;
    require((*stack)->count() > 0, "a stack has no picture");
    for (const std::int64_t number : {std::int64_t{0}, (*stack)->count() / 2, (*stack)->count() - 1}) {
        const auto picture = (*stack)->image(number);
        if (!is_picture(picture)) return false;
        require(picture->image.width == (*stack)->width() && picture->image.height == (*stack)->height(),
                "a picture is not of the stack's size");
    }
    return true;
}

const Registered npy_stack_target{{.name = "npy_stack", .parse = parse_npy_stack, .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
