#include "player/outputs_apart.hpp"

#include <system_error>

namespace touchable {

namespace {

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
    if (a.empty() || b.empty()) return false;
    std::error_code failure;
    if (std::filesystem::equivalent(a, b, failure)) return true;
    const auto whole_a = std::filesystem::weakly_canonical(a, failure);
    if (failure) return false;
    const auto whole_b = std::filesystem::weakly_canonical(b, failure);
    return !failure && whole_a == whole_b;
}

}  // namespace

Result<void> keep_outputs_apart(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
    for (std::size_t k = 0; k < outputs.size(); ++k) {
        const auto refuse = [&](const NamedFile& other) -> Error {
            return usage_error(outputs[k].name + " " + outputs[k].path.string() + " is also " + other.name +
                               ", which it would replace; give it a name of its own");
        };
        for (const NamedFile& input : inputs)
            if (same_file(outputs[k].path, input.path)) return refuse(input);
        for (std::size_t j = 0; j < k; ++j)
            if (same_file(outputs[k].path, outputs[j].path)) return refuse(outputs[j]);
    }
    return {};
}

}  // namespace touchable
