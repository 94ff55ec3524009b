// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_target.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>

#include "engine/base/words.hpp"

namespace touchable::fuzz {
namespace {

std::vector<Target>& known_targets() {
    static std::vector<Target> targets;
    return targets;
}

/// Gone with the process; in memory where that is to be had.
class OwnFolder {
public:
    OwnFolder() {
        const std::filesystem::path memory = "/dev/shm";
        const auto place =
            access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
        std::string name = (place / "touchable-fuzz-XXXXXX").string();
        if (!mkdtemp(name.data())) throw Fault{"no temporary folder " + name};
        path_ = name;
    }
    ~OwnFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

void check_plane(const PlaneView& plane, const Scene& scene, int channels) {
    if (plane.empty()) return;
    require(plane.width == scene.width && plane.height == scene.height, "a plane is not of the scene's size");
    require(plane.channels == channels, "a plane has other channels than its role");
    // The last sample is there: AddressSanitizer looks.
    (void)plane.sample(plane.width - 1, plane.height - 1, channels - 1);
}

}  // namespace

Registered::Registered(const Target& target) {
    Target& known = known_targets().emplace_back(target);
    if (known.decodes_video) known.most_mebibytes = known.most_live_mebibytes = 2048;
}

const std::vector<Target>& all_targets() {
    static const std::vector<Target> sorted = [] {
        std::vector<Target> targets = known_targets();
        std::ranges::sort(targets, {}, [](const Target& target) { return std::string_view(target.name); });
        return targets;
    }();
    return sorted;
}

bool parse_in_memory(const Target& target, std::string_view bytes) {
    const std::size_t most = static_cast<std::size_t>(target.most_live_mebibytes) << 20U;
    count_live_memory(most);
    bool taken = false;
    std::exception_ptr escaped;
    try {
        taken = target.parse(bytes);
    } catch (...) {
        escaped = std::current_exception();
    }
    if (most_live_memory() > most)  // also where it went wrong because of that
        throw Fault{std::to_string(bytes.size()) + " bytes took more than " +
                    std::to_string(target.most_live_mebibytes) + " MiB of memory at a time"};
    if (escaped) std::rethrow_exception(escaped);
    return taken;
}

std::vector<Seed> seeds_of(const Target& target) {
    const auto folder =
        std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests" / "fuzz" / "seeds" / target.name;
    std::vector<Seed> seeds;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(folder, missing)) {
        std::ifstream in(entry.path(), std::ios::binary);
        seeds.push_back({entry.path().filename().string(), {std::istreambuf_iterator<char>(in), {}}});
    }
    if (seeds.empty()) throw Fault{"no seeds in " + folder.string()};
    std::sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.name < b.name; });
    return seeds;
}

void require(bool is_so, std::string_view what) {
    if (!is_so) throw Fault{std::string(what)};
}

void require_readable(const Error& error, Quotes quotes) {
    constexpr std::size_t longest = 2000;
    const std::string& message = error.message;
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == '\x7f'; };
    const bool is_clean = quotes == Quotes::typed || std::none_of(message.begin(), message.end(), is_control);
    if (is_clean && !message.empty() && message.size() < longest && error.kind != ErrorKind::internal) return;
    throw Fault{"an error is empty, long, internal or with control characters: " +
                printable(message, longest)};
}

bool is_picture(const Result<StoredImage>& picture) {
    if (!is_taken(picture)) return false;
    const Image& image = picture->image;
    require(image.width > 0 && image.height > 0 && image.width <= largest_picture_side &&
                image.height <= largest_picture_side,
            "a picture has an impossible size");
    const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (!picture->values.empty()) {
        require(picture->values.size() == pixels && image.samples.empty(), "values are not the picture's");
        return true;
    }
    require(image.channels == 1 || image.channels == 3, "a picture has neither 1 nor 3 channels");
    require(image.bytes_per_sample == 1 || image.bytes_per_sample == 2, "a sample has neither 1 nor 2 bytes");
    require(image.samples.size() == pixels * static_cast<std::size_t>(image.channels) *
                                        static_cast<std::size_t>(image.bytes_per_sample),
            "samples are not the picture's");
    require(picture->bits >= 1 && picture->bits <= 8 * image.bytes_per_sample,
            "a sample has impossible bits");
    return true;
}

bool is_clip(const Result<std::unique_ptr<ClipReader>>& clip) {
    constexpr std::int64_t frames = 3;
    if (!is_taken(clip)) return false;
    ClipReader& reader = **clip;
    for (const std::string& note : reader.notes()) require(!note.empty(), "a note says nothing");
    for (std::int64_t number = 0; number < frames; ++number) {
        const auto frame = reader.next();
        if (!is_taken(frame)) return false;
        if (!frame->has_value()) return number > 0;
        const RawFrame& raw = **frame;
        require(raw.number == number, "a frame has another number");
        require(bool(validate(reader.scene())), "a clip's scene cannot be");
        require(!raw.depth.empty(), "a frame has no depth");
        check_plane(raw.depth, reader.scene(), reader.scene().depth.kind == DepthCodingKind::hue ? 3 : 1);
        check_plane(raw.colour, reader.scene(), 3);
        check_plane(raw.haptic, reader.scene(), 3);
        check_plane(raw.height, reader.scene(), 1);
    }
    return true;
}

std::filesystem::path file_of(std::string_view bytes, const std::string& name) {
    static const OwnFolder folder;
    auto file = folder.path() / name;
    std::ofstream out(file, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Fault{"cannot write " + file.string()};
    return file;
}

unsigned Taken::byte() {
    if (rest_.empty()) return 0;
    const auto value = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return value;
}

double Taken::number() {
    double value = 0;
    const std::size_t size = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), size);
    rest_.remove_prefix(size);
    return value;
}

std::string_view Taken::line() {
    const std::string_view found = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(std::min(rest_.size(), found.size() + 1));
    return found;
}

}  // namespace touchable::fuzz
