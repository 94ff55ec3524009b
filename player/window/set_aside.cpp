#include "player/window/set_aside.hpp"

#include <cerrno>
#include <string>
#include <system_error>

#include "engine/base/new_file.hpp"

namespace touchable {

Result<std::filesystem::path> set_aside(const std::filesystem::path& file) {
    constexpr int most_set_aside = 100;
    int failed = EEXIST;
    for (int k = 1; k <= most_set_aside && failed == EEXIST; ++k) {
        std::filesystem::path aside = file;
        aside += k == 1 ? ".broken" : ".broken" + std::to_string(k);
        failed = move_to_free_name(file, aside);
        if (failed == 0) return aside;
    }
    return input_error("it cannot be set aside (" + std::generic_category().message(failed) + ")");
}

}  // namespace touchable
