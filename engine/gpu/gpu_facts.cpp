#include "engine/gpu/gpu_facts.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

namespace touchable {
namespace {

char lower(char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

bool contains(std::string_view name, std::string_view part) {
    const auto same = [](char a, char b) { return lower(a) == lower(b); };
    return std::search(name.begin(), name.end(), part.begin(), part.end(), same) != name.end();
}

bool is_same(std::string_view name, std::string_view other) {
    return name.size() == other.size() && contains(name, other);
}

bool answers_to(const GpuFacts& gpu, std::string_view word) {
    return contains(gpu.name, word) || contains(nickname_of(gpu.name), word) ||
           is_same(name_of(gpu.kind), word) || (gpu.kind == GpuKind::software && is_same("cpu", word));
}

std::string joined(const std::vector<std::string>& words) {
    std::string all;
    for (const std::string& word : words) all.append(all.empty() ? "" : ", ").append(word);
    return all;
}

std::string described(std::span<const GpuFacts> gpus) {
    std::string all = "devices here: ";
    for (std::size_t i = 0; i < gpus.size(); ++i) {
        const GpuFacts& gpu = gpus[i];
        if (i > 0) all += "; ";
        all.append(std::to_string(i)).append(" ").append(gpu.name);
        all.append(" (").append(name_of(gpu.kind));
        if (const auto nickname = nickname_of(gpu.name); !nickname.empty()) all.append(", ").append(nickname);
        all.append(")");
        if (!gpu.usable()) all.append(" lacks ").append(joined(gpu.missing));
    }
    return all;
}

Error refusal(std::string why, std::span<const GpuFacts> gpus) {
    return {ErrorKind::gpu, std::move(why) + "; " + described(gpus)};
}

Result<std::size_t> only_if_usable(std::span<const GpuFacts> gpus, std::size_t index) {
    const GpuFacts& gpu = gpus[index];
    if (gpu.usable()) return index;
    return refusal("GPU " + std::to_string(index) + " " + gpu.name + " cannot be used", gpus);
}

Result<std::size_t> best(std::span<const GpuFacts> gpus) {
    std::optional<std::size_t> chosen;
    for (std::size_t i = 0; i < gpus.size(); ++i)
        if (gpus[i].usable() && (!chosen || gpus[i].kind < gpus[*chosen].kind)) chosen = i;
    if (chosen) return *chosen;
    return refusal("no usable GPU", gpus);
}

Result<std::size_t> by_name(std::span<const GpuFacts> gpus, std::string_view part) {
    std::vector<std::size_t> named, usable;
    for (std::size_t i = 0; i < gpus.size(); ++i)
        if (answers_to(gpus[i], part)) {
            named.push_back(i);
            if (gpus[i].usable()) usable.push_back(i);
        }
    const std::string quoted = std::string("'").append(part).append("'");
    if (usable.size() == 1) return usable.front();
    if (usable.size() > 1) return refusal("several GPUs are called " + quoted + ", give an index", gpus);
    if (named.empty()) return refusal("no GPU is called " + quoted, gpus);
    return refusal("no GPU called " + quoted + " can be used", gpus);
}

}  // namespace

std::string_view name_of(GpuKind kind) {
    switch (kind) {
        case GpuKind::discrete:
            return "discrete";
        case GpuKind::integrated:
            return "integrated";
        case GpuKind::virtualised:
            return "virtual";
        case GpuKind::software:
            return "software";
        case GpuKind::other:
            break;
    }
    return "other";
}

std::string_view nickname_of(std::string_view device_name) {
    return contains(device_name, "llvmpipe") ? "lavapipe" : "";
}

Result<std::size_t> choose_gpu(std::span<const GpuFacts> gpus, std::string_view request) {
    if (gpus.empty())
        return Error{
            ErrorKind::gpu,
            "Vulkan finds no device here; install a driver (Debian's mesa-vulkan-drivers can do it all on "
            "the CPU)"};
    if (request.empty())
        return refusal("the GPU asked for has no name, use auto, an index or a part of a name", gpus);
    if (request == "auto") return best(gpus);

    std::size_t index = 0;
    const auto [end, fault] = std::from_chars(request.data(), request.data() + request.size(), index);
    const bool is_index = end == request.data() + request.size();
    if (!is_index) return by_name(gpus, request);
    if (fault == std::errc{} && index < gpus.size()) return only_if_usable(gpus, index);
    return refusal("there is no GPU " + std::string(request), gpus);
}

}  // namespace touchable
