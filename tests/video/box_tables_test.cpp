#include "engine/picture/ffmpeg.hpp"

#include <gtest/gtest.h>

#include <string>
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/quicktime.hpp"

namespace touchable::test {
namespace {

std::string word(std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
}

std::string in_box(const std::string& type, const std::string& content) {
    return word(static_cast<std::uint32_t>(content.size() + 8)) + type + content;
}

std::string tables_refused(const std::string& bytes) {
    return message(check_box_tables(*bytes_in_memory(bytes), bytes.size()));
}

std::string some_video(const TemporaryFolder& folder) {
    std::vector<Image> pictures;
    for (int k = 1; k <= 3; ++k) {  // each of another size in the file
        Image picture{16, 16, 1, 3, {}};
        for (int at = 0; at < 16 * 16 * 3; ++at)
            picture.samples.push_back(static_cast<std::uint8_t>(at < 200 * k ? at * at % 251 : 0));
        pictures.push_back(std::move(picture));
    }
    write_quicktime(folder / "video.mov", pictures, {30, 1});
    return read_bytes(folder / "video.mov");
}

TEST(BoxTables, OfAVideoHoldWhatTheyClaim) {
    const TemporaryFolder folder;
    const std::string video = some_video(folder);
    EXPECT_EQ(tables_refused(video), "");
    for (const char* table : {"stsz", "stco", "stsc"}) {
        std::string hostile = video;
        const std::size_t type = hostile.find(table);
        ASSERT_NE(type, std::string::npos) << table;
        const std::size_t count = type + (std::string(table) == "stsz" ? 12 : 8);
        hostile.replace(count, 4, word(300'000'000));
        EXPECT_NE(
            tables_refused(hostile).find("its table " + std::string(table) + " claims 300000000 entries in "),
            std::string::npos)
            << tables_refused(hostile);
        write_bytes(folder / "hostile.mov", hostile);
        const auto opened = Demuxer::open_quicktime(folder / "hostile.mov");
        EXPECT_EQ(message(opened), (folder / "hostile.mov").string() + ": " + tables_refused(hostile));
    }
}

TEST(BoxTables, AreFoundWhereverTheyAre) {
    const std::string zeros(4, '\0'), flags_of_sizes = word(0x200), none = word(0);
    const auto track = [](const std::string& table) {
        return in_box("moov", in_box("trak", in_box("mdia", in_box("minf", in_box("stbl", table)))));
    };
    const auto fragment = [](const std::string& run) { return in_box("moof", in_box("traf", run)); };
    EXPECT_EQ(tables_refused(track(in_box("stss", zeros + word(1) + word(1)))), "");
    EXPECT_NE(tables_refused(track(in_box("stss", zeros + word(2) + word(1)))), "");
    EXPECT_EQ(tables_refused(track(in_box("stz2", zeros + word(4) + word(3) + "xx"))), "");
    EXPECT_NE(tables_refused(track(in_box("stz2", zeros + word(4) + word(5) + "xx"))), "");
    const std::string keys = in_box("keys", zeros + word(1) + word(9) + "mdta"),
                      handler = in_box("hdlr", zeros);
    const std::string hostile_keys = in_box("keys", zeros + word(2) + word(9) + "mdta");
    EXPECT_EQ(tables_refused(in_box("moov", in_box("meta", handler + keys))), "");
    EXPECT_NE(tables_refused(in_box("moov", in_box("meta", handler + hostile_keys))), "");
    EXPECT_NE(tables_refused(in_box("moov", in_box("meta", zeros + handler + hostile_keys))), "");
    const std::string groups_of_two = zeros + "sync" + word(2);
    EXPECT_EQ(tables_refused(track(in_box("sbgp", groups_of_two + std::string(16, 1)))), "");
    EXPECT_NE(tables_refused(track(in_box("sbgp", groups_of_two + std::string(15, 1)))), "");
    EXPECT_NE(tables_refused(track(in_box("sgpd", word(1 << 24) + "sync" + zeros + word(2) + "x"))), "");
    EXPECT_EQ(tables_refused(fragment(in_box("trun", flags_of_sizes + word(1) + zeros))), "");
    EXPECT_NE(tables_refused(fragment(in_box("trun", flags_of_sizes + word(2) + zeros))), "");
    // Free space that FFmpeg takes for the movie's box, and compressed tables.
    const std::string first = in_box("mvhd", ""), hostile = in_box("stss", zeros + word(2) + word(1));
    for (const char* disguise : {"free", "hoov"}) {
        EXPECT_NE(tables_refused(in_box(disguise, first + hostile)), "") << disguise;
        EXPECT_EQ(tables_refused(in_box(disguise, hostile)), "") << disguise;
    }
    EXPECT_NE(tables_refused(in_box("moov", in_box("cmov", ""))).find("cmov"), std::string::npos);
    // Each edit may play all samples once more.
    const std::string edits = in_box("edts", in_box("elst", std::string(8 + 12 * 100, 0)));
    const auto samples = [&](std::uint32_t count) { return in_box("stsz", zeros + word(1) + word(count)); };
    EXPECT_EQ(tables_refused(track(edits + samples(500))), "");
    EXPECT_NE(tables_refused(track(edits + samples(5000))).find("its 100 edits of 5000 samples"),
              std::string::npos);
    // Samples without tables: sound has many in a byte, but not all that can be counted.
    EXPECT_EQ(tables_refused(track(in_box("stsz", zeros + word(1) + word(3000)))), "");
    EXPECT_NE(tables_refused(track(in_box("stsz", zeros + word(1) + word(30'000)))), "");
    EXPECT_NE(tables_refused(fragment(in_box("trun", none + word(30'000)))), "");
}

TEST(BoxTables, ThatAreCutAnywhereAreReadNoFurther) {
    const TemporaryFolder folder;
    const std::string video = some_video(folder);
    const std::size_t tables = video.find("moov");
    for (std::size_t length = tables - 8; length < video.size(); ++length)
        EXPECT_EQ(tables_refused(video.substr(0, length)).find("is cut"), std::string::npos) << length;
}

}  // namespace
}  // namespace touchable::test
