#include "engine/formats/ros2_folder.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/base/printable.hpp"

namespace touchable {

Result<std::optional<std::filesystem::path>> ros2_recording_in(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::path metadata = folder / "metadata.yaml";
    constexpr std::size_t beginning = 4096;
    if (!fs::is_regular_file(metadata, failure) ||
        first_bytes(metadata, beginning).find("rosbag2_bagfile_information") == std::string::npos)
        return std::optional<fs::path>();
    constexpr std::size_t most_entries = 10'000;
    std::vector<fs::path> files, packed;
    std::size_t entries = 0;
    for (auto each = fs::directory_iterator(folder, failure);
         !failure && each != fs::end(each) && entries < most_entries; each.increment(failure), ++entries) {
        const fs::path& file = each->path();
        const fs::path plain = file.extension() == ".zstd" ? file.stem() : file;
        if (plain.extension() == ".db3" || plain.extension() == ".mcap")
            (file.extension() == ".zstd" ? packed : files).push_back(file);
    }
    std::sort(files.begin(), files.end());
    if (files.size() == 1) return std::optional(files.front());
    if (!files.empty())
        return input_error(folder.string() + ": is a recording of ROS 2 in " + std::to_string(files.size()) +
                           " files, each a clip of its own: touchable play " +
                           shell_word(files.front().string()));
    if (!packed.empty())
        return input_error(folder.string() +
                           ": is a recording of ROS 2 that is packed as a whole: unpack it first: zstd -d " +
                           shell_word(packed.front().string()));
    return input_error(folder.string() +
                       ": has the metadata.yaml of a recording of ROS 2, but neither a .db3 nor "
                       "an .mcap beside it");
}

}  // namespace touchable
