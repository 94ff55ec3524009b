#include "device/given_file.hpp"

#include <system_error>

namespace touchable {

Result<void> check_given_file(const std::filesystem::path& file, const std::string& named,
                              const std::string& right) {
    std::error_code failure;
    const auto kind = std::filesystem::status(file, failure).type();
    if (kind == std::filesystem::file_type::regular) return {};
    const bool is_there =
        kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::none;
    const std::string why = kind == std::filesystem::file_type::directory ? ": is a folder"
                            : is_there                                    ? ": is no ordinary file"
                            : failure && kind == std::filesystem::file_type::none
                                ? ": cannot be read (" + failure.message() + ")"
                                : ": is not there";
    return input_error(named + why + "; right would be " + right);
}

}  // namespace touchable
