// SPDX-License-Identifier: Apache-2.0
// Pictures in HDF5 files, which h5import writes.
#include <stdlib.h>

#include <chrono>
#include <optional>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "tests/picture/hdf5_file.hpp"
#include "tests/picture/results.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

using Names = std::vector<std::string>;

class Hdf5 : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("command -v h5import h5ls h5dump h5jam >/dev/null 2>&1") != 0)
            GTEST_SKIP() << "needs h5import (Debian: hdf5-tools)";
    }
    std::filesystem::path file(const std::string& name = "f.h5") const { return folder_ / name; }
    void add(const Hdf5Numbers& of, int first = 1, const std::string& name = "f.h5") const {
        ASSERT_TRUE(add_data_set(file(name), of, first)) << of.path;
    }
    /// The first picture of a data set.
    StoredImage picture(const std::string& name = "f.h5", const std::string& dataset = "") const {
        return must(must(open_hdf5_stack(file(name), dataset))->image(0));
    }
    std::string refusal(const std::string& dataset = "", const std::string& name = "f.h5") const {
        return message(open_hdf5_stack(file(name), dataset));
    }

    TemporaryFolder folder_;
};

float number_of(const StoredImage& picture, int x, int y) {
    return picture.values.empty() ? static_cast<float>(picture.image.view().sample(x, y))
                                  : picture.values[static_cast<std::size_t>(y * picture.image.width + x)];
}

/// A picture of 7x5 whose numbers count from `first` on, row by row.
void expect_counted(const Result<StoredImage>& picture, int first) {
    ASSERT_EQ(message(picture), "");
    ASSERT_EQ(picture->image.width, 7);
    ASSERT_EQ(picture->image.height, 5);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) ASSERT_EQ(number_of(*picture, x, y), first + 7 * y + x);
}

TEST_F(Hdf5, ReadsEveryTypeAndOrder) {
    for (const std::string kind : {"UIN", "IN", "FP"})
        for (const int bits : {8, 16, 32, 64})
            for (const std::string order : {"LE", "BE"}) {
                if (kind == "FP" && bits < 32) continue;
                const std::string name = kind + std::to_string(bits) + order;
                SCOPED_TRACE(name);
                add({"depth", {5, 7}, kind, bits, order}, 3, name);
                const auto stack = must(open_hdf5_stack(file(name)));
                const auto picture = stack->image(0);
                expect_counted(picture, 3);
                EXPECT_EQ(picture->codec, "hdf5");
                EXPECT_EQ(picture->values.empty(), kind != "FP");
            }
}

TEST_F(Hdf5, MakesNegativeIntegersFloats) {
    add({"depth", {3, 5, 7}, "IN", 32}, -1);
    const auto stack = must(open_hdf5_stack(file()));
    for (const int number : {2, 0}) {
        const auto picture = stack->image(number);
        expect_counted(picture, 35 * number - 1);
        EXPECT_EQ(picture->pixel_format, "grayf32le");
    }
}

/// h5import writes no half floats: those of a file of floats are made so.
TEST_F(Hdf5, ReadsHalfFloats) {
    add({"depth", {5, 8}, "FP", 32});
    std::string bytes = read_bytes(file());
    const auto put = [&](const std::string& from, const std::string& to) {
        const auto at = bytes.find(from);
        ASSERT_NE(at, std::string::npos);
        bytes.replace(at, to.size(), to);
    };
    put({"\x11\x20\x1f\0\4\0\0\0\0\0\x20\0\x17\x08\0\x17\x7f\0\0\0", 20},
        {"\x11\x20\x0f\0\2\0\0\0\0\0\x10\0\x0a\x05\0\x0a\x0f\0\0\0", 20});
    put({"\xa0\0\0\0\0\0\0\0", 8}, {"\x50\0\0\0\0\0\0\0", 8});  // bytes of the data
    put(counted({"", {1}, "FP", 32}, 1), {"\0\x3c\0\xc0", 4});  // 1 and -2
    write_bytes(file(), bytes);
    const StoredImage picture = this->picture();
    EXPECT_EQ(picture.pixel_format, "grayf16le");
    EXPECT_EQ(number_of(picture, 0, 0), 1);
    EXPECT_EQ(number_of(picture, 1, 0), -2);
}

TEST_F(Hdf5, ReadsCompressedStacks) {
    const std::vector<int> shapes[] = {{3, 5, 7}, {3, 1, 5, 7}, {3, 5, 7, 1}, {1, 3, 5, 7}};
    for (const std::vector<int>& shape : shapes) {
        const std::string name = shape_text({shape.begin(), shape.end()});
        SCOPED_TRACE(name);
        std::string chunks = "CHUNKED-DIMENSION-SIZES";
        for (const int extent : shape) chunks += ' ' + std::to_string(std::min(extent, 2));
        add({"obs/agentview_depth", shape, "UIN", 16, "BE",
             chunks + "\nCOMPRESSION-TYPE GZIP\nCOMPRESSION-PARAM 4\n"},
            1, name);
        const auto stack = must(open_hdf5_stack(file(name)));
        ASSERT_EQ(stack->count(), 3);
        for (const int number : {2, 0, 1}) expect_counted(stack->image(number), 35 * number + 1);
        EXPECT_TRUE(is_refused(stack->image(3), "has no picture 3: must be from 0 to 2"));
    }
}

/// Some pictures are read at a time, of these 27.
TEST_F(Hdf5, ReadsPicturesOfAllBlocks) {
    add({"depth", {30, 480, 640}, "UIN", 8}, 0);
    const auto stack = must(open_hdf5_stack(file()));
    for (const int number : {29, 26, 27, 0}) {
        const auto picture = must(stack->image(number));
        for (const int y : {0, 1, 479})
            for (const int x : {0, 3, 639})
                ASSERT_EQ(number_of(picture, x, y), ((number * 480 + y) * 640 + x) % 256);
    }
}

TEST_F(Hdf5, TurnsPicturesOfMatlabOver) {
    // 5x7x2 in MATLAB: the first index runs fastest.
    add({"depths", {2, 7, 5}, "FP", 32}, 1, "m.h5");
    add({"rawDepths", {2, 7, 5}, "FP", 32}, 1, "m.h5");
    add({"images", {2, 3, 7, 5}, "UIN", 8}, 1, "m.h5");
    put_matlab_before(file("m.h5"), file("m.mat"));
    ASSERT_TRUE(is_hdf5_file(file("m.mat")));
    const auto stack = must(open_hdf5_stack(file("m.mat")));
    ASSERT_EQ(stack->count(), 2);
    EXPECT_EQ(stack->left_out(), "depth is the data set /depths; left out: /rawDepths");
    for (int number = 0; number < 2; ++number) {
        const auto picture = must(stack->image(number));
        ASSERT_EQ(picture.image.width, 7);
        ASSERT_EQ(picture.image.height, 5);
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 7; ++x) ASSERT_EQ(number_of(picture, x, y), 35 * number + 5 * x + y + 1);
    }
}

TEST_F(Hdf5, ChoosesDepthByItsName) {
    const std::pair<Names, std::string> cases[] = {
        {{"z"}, ""},
        {{"mask", "depth", "depth_error"}, "depth"},
        {{"mask", "depth_mm"}, "depth_mm"},
        {{"obs/mask", "obs/agentview_depth"}, "obs/agentview_depth"}};
    int number = 0;
    for (const auto& [names, right] : cases) {
        const std::string name = std::to_string(++number);
        for (const std::string& each : names) add({each, {16, 17}}, each == right ? 1000 : 1, name);
        EXPECT_EQ(number_of(picture(name), 0, 0), right.empty() ? 1 : 1000) << right;
    }
}

TEST_F(Hdf5, RefusesAmbiguousDataSets) {
    add({"colors", {16, 17, 3}, "UIN", 8});
    add({"first", {3, 16, 17}, "UIN", 8});
    add({"actions", {200, 7}, "FP", 64});
    EXPECT_EQ(refusal(), file().string() +
                             ": is an HDF5 file without a data set of pictures of depth (height x width, or "
                             "count x height x width): it has /actions of 200x7, /colors of 16x17x3, /first "
                             "of 3x16x17");
    add({"left", {16, 17}});
    add({"right", {16, 17}});
    EXPECT_EQ(refusal(),
              file().string() + ": has several data sets that may be depth: /left of 16x17, /right of 16x17");
    EXPECT_EQ(open_hdf5_stack(file()).error().hints.front().value, "/left");
    add({"data/demo_0/depth", {2, 16, 17}});
    add({"data/demo_1/depth", {2, 16, 17}});
    EXPECT_EQ(refusal(), file().string() +
                             ": has several data sets that may be depth: /data/demo_0/depth of 2x16x17, "
                             "/data/demo_1/depth of 2x16x17");
}

TEST_F(Hdf5, TakesNamedDataSet) {
    add({"data/demo_0/depth", {5, 7}}, 1);
    add({"data/demo_1/depth", {5, 7}}, 100);
    add({"data/with[0]", {5, 7}}, 200);
    add({"colors", {16, 17, 3}, "UIN", 8});
    for (const auto& [name, first] :
         {std::pair("/data/demo_0/depth", 1), {"data/demo_1/depth", 100}, {"/data/with[0]", 200}}) {
        expect_counted(picture("f.h5", name), first);
    }
    EXPECT_EQ(refusal("/depth").find(file().string() + ": has no data set \"/depth\", but /colors of "), 0U)
        << refusal("/depth");
    EXPECT_TRUE(has_words(refusal("colors"), "/colors: is an array of 16x17x3, with 3 numbers a pixel"));
}

TEST_F(Hdf5, ReadsNumberedDataSets) {
    for (const int number : {0, 1, 2, 10}) {
        const std::string name = std::to_string(number);
        add({"depth/" + name, {16, 17}}, 1000 * number + 1);
        add({"mask/" + name, {16, 17}}, 1);
    }
    const auto stack = must(open_hdf5_stack(file()));
    ASSERT_EQ(stack->count(), 4);
    for (const auto& [frame, number] : {std::pair(3, 10), {0, 0}, {2, 2}}) {
        const auto picture = must(stack->image(frame));
        EXPECT_EQ(number_of(picture, 1, 1), 1000 * number + 19);
    }
    add({"depth/11", {16, 18}});
    EXPECT_TRUE(
        has_words(refusal(), "has several data sets that may be depth: /depth/0 of 16x17, /depth/1 of "));
}

TEST_F(Hdf5, RefusesExternalNumbers) {
    const std::string other = file("secret").string();
    add({"depth", {16, 17}, "UIN", 16, "LE", "EXTERNAL-STORAGE " + other + '\n'});
    EXPECT_TRUE(has_words(refusal(), "without a data set of pictures of depth"));
    EXPECT_EQ(refusal("depth"),
              file().string() + ": /depth: has its numbers in other files, which are not read");
}

TEST_F(Hdf5, RefusesGigabytesOfSmallFile) {
    add({"depth",
         {2, 16, 16},
         "UIN",
         8,
         "LE",
         "CHUNKED-DIMENSION-SIZES 1 16 16\nCOMPRESSION-TYPE GZIP\n"
         "COMPRESSION-PARAM 4\n"});
    std::string bytes = read_bytes(file());
    const std::string extents("\2\0\0\0\0\0\0\0\x10\0\0\0\0\0\0\0\x10\0\0\0\0\0\0\0", 24);
    for (auto at = bytes.find(extents); at != std::string::npos; at = bytes.find(extents, at + 1))
        bytes.replace(at, 4, "\xff\xff\xff\x3f", 4);
    write_bytes(file(), bytes);
    EXPECT_NE(refusal(), "");
    EXPECT_EQ(refusal().find('\n'), std::string::npos) << refusal();
}

/// It sets a variable of this program's environment as long as it lives.
class Environment {
public:
    Environment(const char* name, const std::string& value) : name_(name) {
        if (const char* was = std::getenv(name)) was_ = was;
        ::setenv(name, value.c_str(), 1);
    }
    ~Environment() {
        if (was_)
            ::setenv(name_, was_->c_str(), 1);
        else
            ::unsetenv(name_);
    }

private:
    const char* name_;
    std::optional<std::string> was_;
};

TEST_F(Hdf5, NamesMissingPackage) {
    add({"depth", {5, 7}});
    const Environment path("PATH", folder_.path().string());
    EXPECT_EQ(refusal(), file().string() + ": is HDF5, which needs h5dump: install the package hdf5-tools");
}

/// In the place of h5ls or h5dump.
void write_tool(const std::filesystem::path& file, const std::string& lines) {
    write_bytes(file, "#!/bin/sh\n" + lines);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
}

TEST_F(Hdf5, StopsToolWhenCancelled) {
    add({"depth", {5, 7}});
    write_tool(file("h5ls"), "echo $$ > '" + file("pid").string() + "'\nexec sleep 1000\n");
    const Environment path("PATH", folder_.path().string() + ":" + std::getenv("PATH"));
    std::stop_source given_up;
    const auto opened = work_until(given_up.get_token(), [&] {
        std::jthread stops([&] {
            while (read_bytes(file("pid")).empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            given_up.request_stop();
        });
        return open_hdf5_stack(file());
    });
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, ErrorKind::interrupted);
    EXPECT_NE(::kill(std::stoi(read_bytes(file("pid"))), 0), 0) << "it is still there";
}

TEST_F(Hdf5, NamesToolFaults) {
    add({"depth", {2, 5, 7}});  // codes, which opening need not read
    for (const auto& [lines, said] :
         {std::pair("printf abc", "/depth: is damaged: h5dump gives 3 bytes of 140"),
          {"head -c 1000 /dev/zero", "h5dump gives more than 140 bytes"},
          {"echo Oh no >&2; exit 3", "h5dump ended with status 3: Oh no"},
          {"kill -SEGV $$", "h5dump ended by signal 11"}}) {
        write_tool(file("h5dump"), lines);
        const Environment path("PATH", folder_.path().string() + ":" + std::getenv("PATH"));
        const auto stack = must(open_hdf5_stack(file()));
        EXPECT_TRUE(is_refused(stack->image(0), said));
    }
}

TEST_F(Hdf5, AdvisesSmallerChunks) {
    const std::string packed = "\nCOMPRESSION-TYPE GZIP\nCOMPRESSION-PARAM 1\n";
    add({"obs/depth", {3, 480, 640}, "UIN", 16, "LE", "CHUNKED-DIMENSION-SIZES 3 480 640" + packed});
    add({"depth", {700, 1024}, "FP", 64, "LE", "CHUNKED-DIMENSION-SIZES 700 1024" + packed}, 1, "large.h5");
    add({"depth", {2, 5, 7}}, 1, "plain.h5");
    const auto slow = [&](const std::string& name) {
        write_tool(file("h5dump"), "kill -XCPU $$");  // its limit of processor time
        const Environment path("PATH", folder_.path().string() + ":" + std::getenv("PATH"));
        return message(must(open_hdf5_stack(file(name)))->image(0));
    };
    const std::string said = slow("f.h5"), at = file().string();
    const std::string command = "h5repack -l /obs/depth:CHUNK=1x480x640 " + at + " repacked.h5";
    EXPECT_EQ(said, at +
                        ": /obs/depth: h5dump used up its processor time (it is packed by deflate-1); it has "
                        "chunks of 1843200 bytes, and must have smaller ones: " +
                        command);
    EXPECT_TRUE(has_words(slow("large.h5"), "h5repack -l /depth:CHUNK=128x1024 "));
    EXPECT_EQ(slow("plain.h5"), file("plain.h5").string() + ": /depth: h5dump used up its processor time");
    ASSERT_EQ(std::system(("cd '" + folder_.path().string() + "' && " + command).c_str()), 0);
    const auto repacked = must(open_hdf5_stack(file("repacked.h5")));
    EXPECT_EQ(number_of(must(repacked->image(2)), 639, 479), 3 * 480 * 640 % 65536);
}

TEST_F(Hdf5, NamesDamageInOneLine) {
    add({"depth",
         {2, 5, 7},
         "UIN",
         16,
         "LE",
         "CHUNKED-DIMENSION-SIZES 1 5 7\nCOMPRESSION-TYPE GZIP\nCOMPRESSION-PARAM 4\n"});
    const std::string whole = read_bytes(file());
    const auto look = [&](const std::string& bytes) {
        write_bytes(file("damaged.h5"), bytes);
        const auto stack = open_hdf5_stack(file("damaged.h5"));
        std::string said = message(stack);
        for (std::int64_t k = 0; stack && k < std::min<std::int64_t>(2, (*stack)->count()); ++k)
            if (auto words = message((*stack)->image(k)); !words.empty()) said = words;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        return said;
    };
    EXPECT_EQ(look(whole), "");
    for (std::size_t length = 0; length < whole.size(); length += 31 * sweep_step())
        EXPECT_NE(look(whole.substr(0, length)), "") << length;
    for (std::size_t at = 0; at < whole.size(); at += 13 * sweep_step()) {
        std::string bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ 0xff);
        look(bytes);
    }
}

std::optional<NumberFormat> format_of(const std::string& type) {
    const auto sets = hdf5_data_sets(
        "/                        Group\n/d  Dataset {5/5, 7/7}\n    Type:      " + type + '\n');
    return sets && sets->size() == 1 ? sets->front().format : std::nullopt;
}

TEST(Hdf5Listing, KnowsTypesOfAllVersions) {
    const std::string half_places =
        " floating-point\n               (significant for 10 bits at bit 0, msb implied)\n"
        "               (exponent for 5 bits at bit 10, bias is 0xf)\n               (sign bit at 15)";
    for (const auto& [type, bytes, is_big] : {std::tuple("native unsigned short", 2, false),
                                              {"IEEE 64-bit big-endian float", 8, true},
                                              {"IEEE 16-bit little-endian float", 2, false},
                                              {"native _Float16", 2, false},
                                              {"8-bit unsigned integer", 1, false},
                                              {"32-bit big-endian integer", 4, true},
                                              {"shared-1:800 native double", 8, false}}) {
        const auto format = format_of(type);
        ASSERT_TRUE(format) << type;
        EXPECT_EQ(format->bytes, bytes) << type;
        EXPECT_EQ(format->big_endian, is_big) << type;
    }
    const auto half = format_of("16-bit big-endian" + half_places);
    ASSERT_TRUE(half);
    EXPECT_EQ(half->kind, NumberFormat::Kind::floating);
    // bfloat16, integers of 12 bits, and what is no number.
    std::string other_float = "16-bit little-endian" + half_places;
    other_float.replace(other_float.find("10 bits"), 7, "7 bits");
    for (const std::string& type :
         {other_float,
          std::string(
              "16-bit little-endian integer\n               (12 bits of precision beginning at bit 0)"),
          std::string("variable-length null-terminated UTF-8 string"), std::string("native long double"),
          std::string("struct {\n                   \"a\"  +0    native int\n               } 4 bytes")})
        EXPECT_FALSE(format_of(type)) << type;
}

TEST(Hdf5Listing, ReadsNamesAndShapes) {
    const auto sets = must(hdf5_data_sets(
        "Opened \"x.h5\" with sec2 driver.\n/                        Group\n    Attribute: a scalar\n"
        "        Type:      native int\n/a\\ b\\\\\\303\\251           Dataset {2/Inf, 16/16}\n"
        "    Attribute: b {3}\n        Type:      native int\n    Location:  1:96\n    Links:     1\n"
        "    Filter-0:  lzf-32000 OPT {4, 261}\n    Type:      native float\n/s  Dataset {SCALAR}\n"
        "/v  Dataset {5/5, 6/6}\n    Maps:      {1} Source {\n    Type:      native int\n"
        "/l  Soft Link {/v}\n/e  External Link {other.h5//d}\n/h  Dataset, same as /v\n"));
    ASSERT_EQ(sets.size(), 3U);
    EXPECT_EQ(sets[1].path, "/s");
    EXPECT_TRUE(sets[1].shape.empty());
    const Hdf5DataSet &first = sets.front(), &last = sets.back();
    EXPECT_EQ(first.path, "/a b\\\xc3\xa9");
    EXPECT_EQ(first.shape, (std::vector<std::int64_t>{2, 16}));
    EXPECT_EQ(first.packed_by, "lzf-32000");
    ASSERT_TRUE(first.format);
    EXPECT_EQ(first.format->bytes, 4);
    EXPECT_FALSE(first.is_elsewhere);
    EXPECT_EQ(last.path, "/v");
    EXPECT_TRUE(last.is_elsewhere);
}

/// A filter's name is printed as it is, with line breaks.
TEST(Hdf5Listing, RefusesForgedDataSets) {
    const std::string root = "/                        Group\n", set = "  Dataset {5/5, 7/7}\n";
    for (const std::string& lines :
         {root + "/d" + set + "/d" + set, root + "/link  External Link {other.h5//}\n/link/d" + set,
          root + "/link  Soft Link {/g}\n/link  Group\n/link/d" + set, "/d" + set, root + "/g/d" + set})
        EXPECT_TRUE(is_refused(hdf5_data_sets(lines), "is damaged: h5ls lists")) << lines;
}

}  // namespace
}  // namespace touchable::test
