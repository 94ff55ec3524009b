// SPDX-License-Identifier: Apache-2.0
// Arrays that NumPy wrote.

#include <gtest/gtest.h>
#include <zip.h>

#include <cmath>
#include <cstdlib>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

/// Number k*100 + 7*y + x + 1 at y, x of picture k, for floats an eighth of it less 2.
constexpr const char* numpy_script = R"(
import numpy as np, sys
folder = sys.argv[1] + '/'
k, y, x = np.mgrid[0:3, 0:5, 0:7]
n = k * 100 + 7 * y + x + 1
for order in '<>':
    for kind in ['u1', 'u2', 'i2', 'u4', 'i4', 'u8', 'i8', 'f2', 'f4', 'f8']:
        a = (n[0] / 8 - 2 if kind[0] == 'f' else n[0]).astype(order + kind)
        name = folder + kind + ('le' if order == '<' else 'be')
        np.save(name + '_c', a)
        np.save(name + '_f', np.asfortranarray(a))
np.save(folder + 'negative', (n[0] - 5).astype('<i2'))
np.save(folder + 'large', (n[0] * 100000).astype('<i4'))
np.save(folder + 'special', np.array([[np.nan, np.inf, -np.inf, 1e300, 1.5]]))
halves = np.arange(65536).astype('<u2').reshape(256, 256).view('<f2')
np.save(folder + 'halves', halves)
np.save(folder + 'as_floats', halves.astype('<f4'))
np.save(folder + 'with_one', n[0].astype('<u2')[:, :, None])
np.save(folder + 'stack', n.astype('<u2'))
np.save(folder + 'batch', n[0].astype('<u2')[None, None])
np.save(folder + 'batch_last', n[0].astype('<u2')[None, :, :, None])
np.save(folder + 'batches', n.astype('<u2')[:, None])
np.save(folder + 'colours', np.zeros((2, 3, 5, 7), 'u2'))
late = n.astype('<i4'); late[2, 4, 6] = -1
np.save(folder + 'late', late)
np.save(folder + 'colour', np.zeros((9, 8, 3), 'u1'))
np.save(folder + 'row', np.zeros(9))
np.save(folder + 'complex', np.zeros((2, 2), 'c8'))
np.save(folder + 'records', np.zeros((2, 2), [('a', '<f4')]))
np.save(folder + 'fortran_stack', np.asfortranarray(n))
for version in [(2, 0), (3, 0)]:
    with open(folder + 'version%d.npy' % version[0], 'wb') as f:
        np.lib.format.write_array(f, n[0].astype('<u2'), version)
u = n.astype('<u2')
np.savez(folder + 'one.npz', u[0])
np.savez_compressed(folder + 'named.npz', rgb=np.zeros((4, 4), 'u1'), depth=u[0], depth_error=u[1])
np.savez_compressed(folder + 'begins.npz', mask=np.zeros((4, 4), 'u1'), depth_mm=u[0], depth_scale=0.001)
np.savez(folder + 'only.npz', K=np.zeros((3, 3)), inverse_DEPTH=u[0], t=3.0)
large = np.zeros((16, 20), 'u2')
np.savez(folder + 'several.npz', left=large, right=large)
np.save(folder + 'object', np.array({'depth': u[0]}, dtype=object), allow_pickle=True)
np.save(folder + 'K', np.eye(3))
np.save(folder + 'poses', np.zeros((7, 4, 4)))
np.savez_compressed(folder + 'stack.npz', depth=u)
)";

class Npy : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        write_bytes(*folder_ / "write.py", numpy_script);
        written_ = std::system(("/usr/bin/python3 '" + (*folder_ / "write.py").string() + "' '" +
                                folder_->path().string() + "' 2>/dev/null")
                                   .c_str()) == 0;
    }
    static void TearDownTestSuite() { delete folder_; }
    void SetUp() override {
        if (!written_) GTEST_SKIP() << "needs Python with NumPy (Debian: python3-matplotlib)";
    }
    static std::filesystem::path file(const std::string& name) { return *folder_ / name; }
    static std::string bytes(const std::string& name) { return read_bytes(file(name)); }
    static std::string refusal(const std::string& name) {
        return message(decode_stored_image(bytes(name), "picture"));
    }

private:
    static inline TemporaryFolder* folder_ = nullptr;
    static inline bool written_ = false;
};

void expect_numbers(const Result<StoredImage>& stored, int first = 1) {
    ASSERT_EQ(message(stored), "");
    ASSERT_EQ(stored->image.width, 7);
    ASSERT_EQ(stored->image.height, 5);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            const int number = first + 7 * y + x;
            if (stored->values.empty())
                ASSERT_EQ(stored->image.view().sample(x, y), number);
            else
                ASSERT_EQ(stored->values[static_cast<std::size_t>(7 * y + x)],
                          static_cast<float>(number) / 8 - 2);
        }
}

TEST_F(Npy, ReadsEveryKindAndOrder) {
    for (const std::string kind : {"u1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"})
        for (const std::string byte_order : {"le", "be"})
            for (const std::string order : {"_c", "_f"}) {
                SCOPED_TRACE(kind + byte_order + order);
                const auto stored = read_stored_image(file(kind + byte_order + order + ".npy"));
                expect_numbers(stored);
                const int bits = 8 * (kind[1] - '0');
                EXPECT_EQ(stored->codec, "npy");
                EXPECT_EQ(stored->values.empty(), kind[0] != 'f');
                EXPECT_EQ(stored->bits, kind[0] == 'f' || bits < 16 ? bits : 16);
                const std::string name = kind[0] == 'f' ? "grayf" + std::to_string(bits) + byte_order
                                         : kind == "u1" ? "gray"
                                         : kind == "u2" ? "gray16" + byte_order
                                                        : "gray16le";
                EXPECT_EQ(stored->pixel_format, name);
            }
    for (const char* name : {"version2.npy", "version3.npy", "with_one.npy", "batch.npy", "batch_last.npy"})
        expect_numbers(read_stored_image(file(name)));
}

TEST_F(Npy, ReadsOtherNumbersAsFloats) {
    const auto negative = must(read_stored_image(file("negative.npy"))),
               large = must(read_stored_image(file("large.npy")));
    EXPECT_EQ(negative.pixel_format + large.pixel_format, "grayf32legrayf32le");
    EXPECT_EQ(negative.values.front(), -4.0F);
    EXPECT_EQ(large.values.back(), 3500000.0F);

    const auto special = must(read_stored_image(file("special.npy")));
    EXPECT_TRUE(std::isnan(special.values[0]));
    for (const std::size_t k : {1U, 3U}) EXPECT_EQ(special.values[k], std::numeric_limits<float>::infinity());
    EXPECT_EQ(special.values[2], -std::numeric_limits<float>::infinity());
    EXPECT_EQ(special.values[4], 1.5F);

    // Every number of 16 bits.
    const auto halves = must(read_stored_image(file("halves.npy"))),
               floats = must(read_stored_image(file("as_floats.npy")));
    ASSERT_EQ(halves.values.size(), 65536U);
    for (std::size_t k = 0; k < 65536; ++k) {
        if (std::isnan(floats.values[k]))
            ASSERT_TRUE(std::isnan(halves.values[k])) << k;
        else
            ASSERT_EQ(std::bit_cast<std::uint32_t>(halves.values[k]),
                      std::bit_cast<std::uint32_t>(floats.values[k]))
                << k;
    }
}

TEST_F(Npy, ReadsStackPictureByPicture) {
    for (const char* name : {"stack.npy", "stack.npz", "batches.npy"}) {
        auto stack = open_npy_stack(file(name));
        ASSERT_EQ(message(stack), "");
        ASSERT_EQ((*stack)->count(), 3);
        for (const int number : {2, 0, 1, 2}) expect_numbers((*stack)->image(number), 100 * number + 1);
        EXPECT_TRUE(is_refused((*stack)->image(3), "has no picture 3: must be from 0 to 2"));
        EXPECT_TRUE(has_words(refusal(name), "is a stack of 3 pictures of 7x5"));
    }
    auto single = must(open_npy_stack(file("u2le_f.npy")));
    ASSERT_EQ(single->count(), 1);
    expect_numbers(single->image(0));

    auto late = must(open_npy_stack(file("late.npy")));
    const auto first = must(late->image(0)), last = must(late->image(2));
    EXPECT_EQ(first.pixel_format, last.pixel_format);
    EXPECT_EQ(first.values.front(), 1.0F);
    EXPECT_EQ(last.values.back(), -1.0F);
}

TEST_F(Npy, FindsDepthAmongArrays) {
    for (const char* name : {"one.npz", "named.npz", "begins.npz", "only.npz"}) {
        SCOPED_TRACE(name);
        expect_numbers(read_stored_image(file(name)));
    }
    EXPECT_EQ(refusal("several.npz"),
              "picture: has several arrays that may be depth: left of 16x20, right of 16x20");

    const std::pair<const char*, const char*> cases[] = {
        {"colour.npy",
         "is an array of 9x8x3, with 3 numbers a pixel: must have one, of points numpy.save('depth.npy', "
         "array[..., 2])"},
        {"colours.npy", "is an array of 2x3x5x7: must be"},
        {"row.npy", "is an array of 9: must be height x width, or count x height x width, array.reshape("},
        {"complex.npy", "is of NumPy's type \"<c8\": must be an integer or float of 8 to 64 bits"},
        {"records.npy", "is an array of records"},
        {"object.npy", "is a pickled Python object, which is not read, as it may run any program: "},
        {"K.npy", "is of 3x3 numbers, as cameras' matrices are: must be a picture of depth"},
        {"poses.npy", "is of 7x4x4 numbers, as cameras' matrices are"},
        {"fortran_stack.npy", "is a stack in Fortran order"}};
    for (const auto& [name, words] : cases) EXPECT_TRUE(has_words(refusal(name), words));
}

/// Such an array would be slices across all frames, in which nothing looks wrong.
TEST(NpyShape, RefusesFramesAsLastAxis) {
    const auto refusal = [](const std::string& shape) {
        return message(decode_stored_image(npy_header("<u2", shape), "picture"));
    };
    for (const char* shape : {"480, 640, 6", "240, 320, 80", "48, 64, 16"})
        EXPECT_TRUE(has_words(refusal(shape),
                              ", whose last axis seems to count its pictures: must be count x "
                              "height x width, numpy.moveaxis(array, -1, 0)"))
            << shape;
    EXPECT_TRUE(
        has_words(refusal("48, 64, 4"), "must have one, of RGB-D numpy.save('depth.npy', array[..., 3])"));
    for (const char* shape : {"6, 480, 640", "300, 480, 640", "480, 64, 48", "300, 1280, 590", "1, 480, 100"})
        EXPECT_TRUE(has_words(refusal(shape), "is cut short")) << shape;
}

TEST(NpyDamage, IsFoundBeforeAllocating) {
    const LimitedMemory little(64);
    const auto refusal = [](const std::string& shape) {
        return message(decode_stored_image(npy_header("<f8", shape), "picture"));
    };
    EXPECT_EQ(refusal("16384, 16384"), "picture: is cut short: has 128 bytes of 2147483776");
    EXPECT_EQ(refusal("2147483648, 16384, 16384").find("picture: is cut short: has 128 bytes of "), 0U);
    EXPECT_EQ(refusal("16385, 16384"), "picture: is 16384x16385 pixels: must be from 1x1 to 16384x16384");
    EXPECT_EQ(refusal("-1, 5"), "picture: is damaged: its header is not NumPy's");
}

/// The archive's directory says how long a member is; its packed bytes say what is possible.
TEST_F(Npy, RefusesImpossibleMemberLength) {
    const TemporaryFolder folder;
    std::string archive = bytes("stack.npz");
    constexpr std::size_t size_in_entry = 24;
    const auto entry = archive.rfind("PK\1\2");
    ASSERT_NE(entry, std::string::npos);
    archive.replace(entry + size_in_entry, 4, "\xff\xff\xff\x0f");
    write_bytes(folder / "depth.npz", archive);
    EXPECT_TRUE(is_refused(open_npy_stack(folder / "depth.npz"),
                           "depth: is damaged: is said to unpack to 268435455"));
}

/// A .npy file of so many pictures of 2x2 bytes, its data a hole.
std::filesystem::path stack_of(const TemporaryFolder& folder, std::int64_t pictures) {
    write_bytes(folder / "depth.npy", npy_header("|u1", std::to_string(pictures) + ", 2, 2"));
    std::filesystem::resize_file(folder / "depth.npy", static_cast<std::uintmax_t>(128 + 4 * pictures));
    return folder / "depth.npy";
}

/// Frames cost nothing until they are read, however many there are.
TEST(NpyStack, TakesMemoryOfOneFrame) {
    const TemporaryFolder folder;
    constexpr std::int64_t pictures = 100'000'000;
    stack_of(folder, pictures);
    Image still{2, 2, 1, 1, {1, 2, 3, 4}};
    ASSERT_EQ(message(write_png(folder / "height.png", still.view())), "");
    Scene scene = small_scene(2, 2);
    scene.folder = FolderSource{"depth.npy", "", "", "height.png", 0, 0};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const LimitedMemory little(64);
    const auto clip = must(open_clip(folder.path()));
    EXPECT_EQ(clip->frame_count(), pictures);
    EXPECT_EQ(clip->inputs().size(), 3U);
    ASSERT_EQ(message(clip->seek(pictures - 1)), "");
    const auto last = must(clip->next());
    ASSERT_TRUE(last);
    EXPECT_EQ(last->number, pictures - 1);
    EXPECT_EQ(last->height.sample(1, 1), 4);
    EXPECT_FALSE(*clip->next());
}

TEST(NpyStack, RefusesShortFile) {
    const TemporaryFolder folder;
    const auto file = stack_of(folder, 1'000'000'000);
    std::filesystem::resize_file(file, 1000);
    const LimitedMemory little(64);
    EXPECT_TRUE(is_refused(open_npy_stack(file), "is cut short: has 1000 bytes of 4000000128"));
}

// Arrays with a confidence beside depth, as Depth Anything 3 writes them.

constexpr int columns = 4, rows = 3, count = 2;

/// Depth 1, 2, ...; confidence 1 to 12 of the first picture, and 0.5 everywhere of the second.
class NpzConfidence : public ::testing::Test {
protected:
    std::string write(const std::string& name, const std::string& shape = "2, 3, 4") const {
        std::vector<float> depth, confidence;
        for (int k = 0; k < count * columns * rows; ++k) {
            depth.push_back(static_cast<float>(k + 1));
            confidence.push_back(k < columns * rows ? static_cast<float>(k + 1) : 0.5F);
        }
        write_npz(folder_ / name,
                  {{"depth", npy_bytes("2, 3, 4", depth)}, {"conf", npy_bytes(shape, confidence)}});
        return folder_ / name;
    }
    static int missing(const StoredImage& picture) {
        int missing = 0;
        for (const float value : picture.values) missing += std::isnan(value);
        return missing;
    }
    TemporaryFolder folder_;
};

TEST_F(NpzConfidence, DropsDoubtfulDepth) {
    auto stack = must(open_npy_stack(SourceFile(write("da3.npz"))));
    EXPECT_EQ(stack->least_confidence(), 3.5);  // the median is 7
    const auto first = must(stack->image(0)), second = must(stack->image(1)), again = must(stack->image(0));
    EXPECT_EQ(missing(first), 3);
    EXPECT_EQ(first.values[3], 4);
    EXPECT_EQ(missing(second), columns * rows);
    EXPECT_EQ(missing(again), 3);
    auto strict = open_npy_stack(SourceFile(write("da3.npz")), 12);
    EXPECT_EQ(missing(*(*strict)->image(0)), 11);
}

TEST_F(NpzConfidence, RefusesOtherSize) {
    EXPECT_TRUE(is_refused(open_npy_stack(SourceFile(write("other.npz", "2, 4, 3"))),
                           "conf: is of 2 pictures of 3x4, but depth of 2 of 4x3"));
}

/// A picture of booleans, as numpy.savez writes it.
std::string boolean_bytes(int ones) {
    std::string bytes = npy_header("|b1", "3, 4");
    for (int k = 0; k < columns * rows; ++k) bytes += k < ones ? '\1' : '\0';
    return bytes;
}

TEST_F(NpzConfidence, UsesMasksThatTell) {
    const std::string depth = npy_bytes("3, 4", std::vector<float>(columns * rows, 2));
    const struct {
        const char* name;
        int ones, missing;
        const char* said;
    } masks[] = {{"valid", 10, 2, "where its array valid is 0 there is no depth"},
                 {"valid_mask", 12, 0, "where its array valid_mask is 0 there is no depth"},
                 {"mask", 4, 0, "its array mask is not used, as most of it is not 1"},
                 {"person_mask", 10, 0, "depth is the array depth; left out: person_mask"}};
    for (const auto& mask : masks) {
        write_npz(folder_ / "m.npz", {{"depth", depth}, {mask.name, boolean_bytes(mask.ones)}});
        auto stack = open_npy_stack(SourceFile(folder_ / "m.npz"));
        ASSERT_EQ(message(stack), "") << mask.name;
        EXPECT_EQ((*stack)->left_out(), mask.said);
        EXPECT_EQ(missing(*(*stack)->image(0)), mask.missing) << mask.name;
        EXPECT_EQ((*stack)->least_confidence(), std::nullopt);
    }
    write_npz(folder_ / "only.npz", {{"depth", boolean_bytes(12)}});
    EXPECT_TRUE(is_refused(open_npy_stack(SourceFile(folder_ / "only.npz")), "is of NumPy's type \"|b1\""));
}

TEST_F(NpzConfidence, IsFoundByName) {
    const std::string depth = npy_bytes("3, 4", std::vector<float>(columns * rows, 2));
    std::vector<float> low(columns * rows, 8);
    low[5] = 1;
    write_npz(folder_ / "v.npz", {{"depth", depth},
                                  {"depth_conf", npy_bytes("3, 4", low)},
                                  {"world_points_conf", npy_bytes("3, 4", std::vector<float>(12, 9))}});
    auto stack = must(open_npy_stack(SourceFile(folder_ / "v.npz")));
    EXPECT_EQ(stack->least_confidence(), 4);
    EXPECT_EQ(stack->left_out(), "depth is the array depth; left out: world_points_conf");
    EXPECT_EQ(missing(*stack->image(0)), 1);
}

// Archives with a picture in each of several arrays, as numpy.savez writes a list.

std::string picture_of(float value, const std::string& shape = "16, 20") {
    return npy_bytes(shape, std::vector<float>(320, value));
}

class NpzRow : public ::testing::Test {
protected:
    using Arrays = std::vector<std::pair<std::string, std::string>>;
    auto open(const Arrays& arrays, const std::string& name = "") const {
        write_npz(folder_ / "row.npz", arrays);
        return open_npy_stack(SourceFile(folder_ / "row.npz"), {}, name);
    }
    TemporaryFolder folder_;
};

TEST_F(NpzRow, OrdersFramesByNumbers) {
    Arrays arrays;
    for (const int n : {10, 2, 0, 1}) arrays.emplace_back("arr_" + std::to_string(n), picture_of(0.5F + n));
    const auto stack = must(open(arrays));
    ASSERT_EQ(stack->count(), 4);
    EXPECT_EQ(stack->width(), 20);
    EXPECT_EQ(stack->height(), 16);
    constexpr int numbers[] = {0, 1, 2, 10};
    for (const int n : {3, 0, 2, 1}) {
        const auto picture = must(stack->image(n));
        EXPECT_EQ(picture.values.at(11), 0.5F + static_cast<float>(numbers[n]));
    }
    EXPECT_TRUE(is_refused(stack->image(4), "has no picture 4: must be from 0 to 3"));
}

TEST_F(NpzRow, PrefersDepthToOtherRows) {
    const auto stack = must(open({{"depth_1", picture_of(1.5F)},
                                  {"depth_2", picture_of(2.5F)},
                                  {"normal_1", picture_of(0.5F)},
                                  {"normal_2", picture_of(0.5F)}}));
    ASSERT_EQ(stack->count(), 2);
    EXPECT_EQ(stack->image(1)->values.at(0), 2.5F);
}

TEST_F(NpzRow, RefusesOtherSizesAndRows) {
    EXPECT_TRUE(
        is_refused(open({{"a_1", picture_of(1)}, {"a_2", picture_of(1, "20, 16")}}), "has several arrays"));
    EXPECT_TRUE(is_refused(open({{"a_1", picture_of(1)}, {"a_2", picture_of(1)}, {"b", picture_of(1)}}),
                           "has several arrays"));
}

TEST_F(NpzRow, NamesOtherPictures) {
    const auto stack =
        must(open({{"depth", picture_of(1)}, {"disparity", picture_of(2)}, {"mask", picture_of(0)}}));
    EXPECT_EQ(stack->left_out(), "depth is the array depth; left out: disparity, mask");
}

/// Beside what networks and renderers write.
TEST_F(NpzRow, FindsDepthByExclusion) {
    const std::string matrix = npy_bytes("3, 3", std::vector<float>(9, 1)),
                      colour = npy_bytes("3, 16, 20", std::vector<float>(960, 1)), picture = picture_of(1);
    const struct {
        Arrays others;
        const char* depth;
    } cases[] = {{{{"K", matrix}}, "pred_depth"},
                 {{{"K", matrix}}, "Depth"},
                 {{{"K", matrix}}, "z"},
                 {{{"cam_c2w", npy_bytes("4, 4", std::vector<float>(16, 1))}}, "distance"},
                 {{{"depth_conf", picture}, {"world_points", colour}}, "range"},
                 {{{"normals", colour}, {"rgb", picture}, {"valid", picture}}, "data"},
                 {{{"extrinsics", matrix}, {"image", picture}}, "depth_image"},
                 {{{"z", picture}, {"left", picture}}, "metric_depth"},
                 {{{"depth_mm", picture}, {"pred_depth", picture}}, "depth"}};
    for (const auto& row : cases) {
        auto arrays = row.others;
        arrays.emplace_back(row.depth, picture_of(2));
        const auto stack = open(arrays);
        ASSERT_EQ(message(stack), "") << row.depth;
        EXPECT_EQ((*stack)->array(), row.depth);
        EXPECT_EQ((*stack)->count(), 1) << row.depth;
    }
}

TEST_F(NpzRow, TakesNamedArray) {
    const Arrays two{{"pred", picture_of(1)}, {"gt", picture_of(2)}};
    EXPECT_EQ(must(open(two, "gt"))->image(0)->values.at(0), 2);
    EXPECT_TRUE(is_refused(open(two, "x"), "has no array \"x\", but pred of 16x20"));
    EXPECT_TRUE(
        is_refused(open({{"K", npy_bytes("3, 3", std::vector<float>(9, 1))}, {"rgb", picture_of(1)}}),
                   "has no array of pictures of depth (height x width, or count x height x width): it "
                   "has K of 3x3, rgb of 16x20"));
    EXPECT_TRUE(
        is_refused(open({{"xyz", npy_bytes("9, 8, 3", std::vector<float>(216, 1))}, {"rgb", picture_of(1)}}),
                   "; of points numpy.save('depth.npy', array[..., 2]) keeps depth"));
}

}  // namespace
}  // namespace touchable::test
