// The room of a run links into any program (touch_a_clip.cpp), which feels what `touchable touch` does.
#include <elf.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(LinkedRun, GivesTheForcesOfTheProgram) {
    const TemporaryFolder folder;
    const auto clip = folder / "clip.mkv", report = folder / "report.json", hash = folder / "hash";
    ASSERT_EQ(run_touchable({"make", "bumps", clip, "--frames", "2"}).code, 0);
    ASSERT_EQ(run_touchable({"touch", clip, "--hand", "press", "--builder", "cpu", "--json", report}).code,
              0);
    const std::string command =
        std::string("'" TOUCHABLE_LINKED_RUN "' '") + clip.string() + "' > '" + hash.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(text_of(hash),
              nlohmann::json::parse(text_of(report)).at("force_hash").get<std::string>() + "\n");
}

/// What a program tells the loader by name: a sanitized one has hundreds of megabytes besides.
std::string loaded_names(const char* program) {
    std::ifstream file(program, std::ios::binary);
    Elf64_Ehdr header{};
    file.read(reinterpret_cast<char*>(&header), sizeof header);
    std::string names;
    for (int n = 0; n < header.e_shnum && file; ++n) {
        Elf64_Shdr section{};
        file.seekg(
            static_cast<std::streamoff>(header.e_shoff + static_cast<std::size_t>(n) * sizeof section));
        file.read(reinterpret_cast<char*>(&section), sizeof section);
        if (section.sh_type != SHT_STRTAB || (section.sh_flags & SHF_ALLOC) == 0) continue;
        names.resize(section.sh_size);
        file.seekg(static_cast<std::streamoff>(section.sh_offset));
        file.read(names.data(), static_cast<std::streamsize>(names.size()));
    }
    return names;
}

// A library that a program needs is named in it.
TEST(LinkedRun, NeedsNoWindowAndNoVulkan) {
    const std::string program = loaded_names(TOUCHABLE_LINKED_RUN);
    ASSERT_NE(program.find("libavformat.so"), std::string::npos);
    for (const char* library :
         {"libvulkan.so", "libglfw.so", "libX11.so", "libasound.so", "libcairo.so", "libusb"})
        EXPECT_EQ(program.find(library), std::string::npos) << library;
}

}  // namespace
}  // namespace touchable::test
