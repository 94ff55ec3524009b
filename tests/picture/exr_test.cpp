// SPDX-License-Identifier: Apache-2.0
// OpenEXR: by FFmpeg's encoder, and by OpenEXR's own writer, which the reader does not use.

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>

#include "engine/picture/exr_layers.hpp"
#include "engine/picture/image.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

float exr_value(int x, int y) {
    return static_cast<float>(x) / 8 - static_cast<float>(y);
}

struct ExrKind {
    Imf::PixelType type = Imf::FLOAT;
    Imf::Compression compression = Imf::ZIP_COMPRESSION;
    bool tiled = false;
    std::vector<std::string> channels = {"Z"};
    int width = 37, height = 41;
    int beyond = 0;        ///< pixels of the display window around the data window
    std::string odd = "";  ///< a channel of which one pixel differs
};

/// Numbers x/8 - y, of integers 100 y + x, in each channel.
std::string exr_file(const ExrKind& kind) {
    const TemporaryFolder folder;
    const Imath::Box2i data({5, 3}, {5 + kind.width - 1, 3 + kind.height - 1});
    const Imath::Box2i display({5 - kind.beyond, 3 - kind.beyond},
                               {data.max.x + kind.beyond, data.max.y + kind.beyond});
    Imf::Header header(display, data);
    header.compression() = kind.compression;
    const std::size_t bytes = kind.type == Imf::HALF ? 2 : 4,
                      row = bytes * static_cast<std::size_t>(kind.width);
    std::vector<std::vector<char>> samples;
    for (const std::string& name : kind.channels) {
        header.channels().insert(name, Imf::Channel(kind.type));
        auto& plane = samples.emplace_back(row * static_cast<std::size_t>(kind.height));
        for (int y = 0; y < kind.height; ++y)
            for (int x = 0; x < kind.width; ++x) {
                const float value = exr_value(x, y) + (name == kind.odd && x == 36 && y == 40 ? 1 : 0);
                const half small(value);
                const auto whole = static_cast<unsigned>(100 * y + x);
                const void* from = kind.type == Imf::HALF   ? static_cast<const void*>(&small)
                                   : kind.type == Imf::UINT ? static_cast<const void*>(&whole)
                                                            : static_cast<const void*>(&value);
                std::memcpy(
                    plane.data() + row * static_cast<std::size_t>(y) + bytes * static_cast<std::size_t>(x),
                    from, bytes);
            }
    }
    Imf::FrameBuffer frame;
    for (std::size_t k = 0; k < samples.size(); ++k)
        frame.insert(kind.channels[k], Imf::Slice::Make(kind.type, samples[k].data(), data, bytes, row));
    const std::string name = folder / "a.exr";
    if (kind.tiled) {
        header.setTileDescription({16, 8, Imf::MIPMAP_LEVELS});
        Imf::TiledOutputFile file(name.c_str(), header);
        file.setFrameBuffer(frame);
        for (int level = 0; level < file.numLevels(); ++level)
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    } else {
        Imf::OutputFile file(name.c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(kind.height);
    }
    return read_bytes(folder / "a.exr");
}

void expect_exr_values(const std::string& bytes, const std::string& format) {
    const auto stored = must(decode_stored_image(bytes, "picture"));
    EXPECT_EQ(stored.codec, "exr");
    EXPECT_EQ(stored.pixel_format, format);
    ASSERT_EQ(stored.image.width, 37);
    ASSERT_EQ(stored.image.height, 41);
    ASSERT_EQ(stored.values.size(), 37U * 41U);
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 37; ++x)
            ASSERT_EQ(stored.values[static_cast<std::size_t>(37 * y + x)], exr_value(x, y)) << x << "," << y;
}

std::string exr_refusal(const ExrKind& kind) {
    return message(decode_stored_image(exr_file(kind), "picture"));
}

TEST(Exr, ReadsFfmpegFiles) {
    for (const AVPixelFormat format : {AV_PIX_FMT_GRAYF32LE, AV_PIX_FMT_GBRPF32LE})
        expect_exr_values(
            encoded("exr", format, 37, 41,
                    [&](AVFrame& frame) {
                        for (int plane = 0; plane < (format == AV_PIX_FMT_GRAYF32LE ? 1 : 3); ++plane)
                            for (int y = 0; y < 41; ++y)
                                for (int x = 0; x < 37; ++x) {
                                    const float value = exr_value(x, y);
                                    std::memcpy(frame.data[plane] + y * frame.linesize[plane] + 4 * x, &value,
                                                4);
                                }
                    }),
            "grayf32le");
}

TEST(Exr, ReadsEveryCompression) {
    for (const Imf::Compression compression :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
          Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION})
        for (const bool tiled : {false, true}) {
            SCOPED_TRACE(std::to_string(compression) + (tiled ? " tiled" : ""));
            expect_exr_values(exr_file({.compression = compression, .tiled = tiled}), "grayf32le");
            expect_exr_values(exr_file({.type = Imf::HALF, .compression = compression, .tiled = tiled}),
                              "grayf16le");
        }
}

TEST(Exr, RefusesDwa) {
    EXPECT_EQ(exr_refusal({.compression = Imf::DWAA_COMPRESSION}),
              "picture: is compressed by DWA: must be by ZIP, PIZ or another that loses nothing");
}

TEST(Exr, KeepsIntegersAsCodes) {
    const auto stored = must(decode_stored_image(exr_file({.type = Imf::UINT}), "picture"));
    EXPECT_EQ(stored.pixel_format, "gray16le");
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 37; ++x) ASSERT_EQ(stored.image.view().sample(x, y), 100 * y + x);
}

TEST(Exr, FindsDepthChannel) {
    // The one to read alone has the right numbers: another's last pixel is odd.
    expect_exr_values(exr_file({.channels = {"A", "B", "G", "R", "Z"}, .odd = "R"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"Y", "left.Depth.V"}, .odd = "Y"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"A", "R"}, .odd = "A"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"A", "B", "G", "R"}, .odd = "A"}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"disparity"}}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"b", "g", "r"}}), "grayf32le");
    expect_exr_values(exr_file({.channels = {"depth.B", "depth.G", "depth.R"}}), "grayf32le");
    for (const ExrKind& colour : {ExrKind{.channels = {"B", "G", "R"}, .odd = "B"},
                                  {.channels = {"b", "g", "r"}, .odd = "g"},
                                  {.channels = {"depth.B", "depth.G", "depth.R"}, .odd = "depth.B"},
                                  {.channels = {"Depth.b", "Depth.g", "Depth.r"}, .odd = "Depth.r"},
                                  {.channels = {"BY", "RY", "Y"}},
                                  {.channels = {"depth.by", "depth.ry", "depth.y"}}}) {
        SCOPED_TRACE(colour.channels.back());
        EXPECT_EQ(exr_refusal(colour),
                  "picture: is in colour: a picture of depth has a channel Z, depth, Y or R");
    }
    EXPECT_EQ(exr_refusal({.channels = {"u", "v"}}),
              "picture: has no channel Z, depth, Y or R for each pixel, but u, v");
}

TEST(Exr, TellsRenderersByTheirChannels) {
    for (const char* channel : {"Z", "left.Depth.V", "ViewLayer.Depth.Z"})
        EXPECT_TRUE(must(decode_stored_image(exr_file({.channels = {channel}}), "picture")).is_rendered);
    for (const char* channel : {"Y", "R", "disparity"})
        EXPECT_FALSE(must(decode_stored_image(exr_file({.channels = {channel}}), "picture")).is_rendered);
}

TEST(Exr, HasNothingOutsideDataWindow) {
    const auto stored = must(decode_stored_image(exr_file({.beyond = 2}), "picture"));
    ASSERT_EQ(stored.image.width, 41);
    ASSERT_EQ(stored.image.height, 45);
    for (int y = 0; y < 45; ++y)
        for (int x = 0; x < 41; ++x) {
            const float value = stored.values[static_cast<std::size_t>(41 * y + x)];
            if (x < 2 || y < 2 || x >= 39 || y >= 43)
                ASSERT_TRUE(std::isnan(value)) << x << "," << y;
            else
                ASSERT_EQ(value, exr_value(x - 2, y - 2));
        }
    EXPECT_TRUE(has_words(exr_refusal({.beyond = -2}), "data window beyond its display window"));
}

/// A header that ends behind its first attribute, which OpenEXR calls damaged once it has read that.
std::string exr_header(int channels, int attributes) {
    const auto number = [](std::size_t value) {
        std::string bytes;
        for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> 8 * k & 255);
        return bytes;
    };
    std::string list, others;
    for (int k = 0; k < channels; ++k)
        list += 'c' + std::to_string(k) + '\0' + number(2) + number(0) + number(1) + number(1);
    list += '\0';
    for (int k = 0; k < attributes; ++k)
        others += 'a' + std::to_string(k) + '\0' + "int" + '\0' + number(4) + number(7);
    return std::string("\x76\x2f\x31\x01\x02\0\0\0", 8) + others + "channels" + '\0' + "chlist" + '\0' +
           number(list.size()) + list;
}

/// OpenEXR would take as long as the square of their number.
TEST(Exr, RefusesLargeHeadersUnparsed) {
    EXPECT_EQ(message(decode_stored_image(exr_header(1025, 0), "picture")),
              "picture: has more than 1024 channels");
    EXPECT_EQ(message(decode_stored_image(exr_header(100'000, 0), "picture")),
              "picture: has more than 1024 channels");
    EXPECT_EQ(message(decode_stored_image(exr_header(1, 8192), "picture")),
              "picture: has more than 8192 attributes in its header");
    EXPECT_TRUE(is_refused(decode_stored_image(exr_header(1024, 100), "picture"), "is damaged"));
}

// Renderings with several layers: which channel is what, by names and in files; files of Blender 3.4.1
// (tests/picture/blender/render_seeds.py), and of OpenEXR's own writer.

/// The names of depth, of colour's red and of the material index; "|" separates parts.
std::string layers_in(const std::vector<std::string>& names) {
    std::vector<ExrChannelName> channels;
    int part = 0;
    for (const std::string& name : names)
        if (name == "|")
            ++part;
        else
            channels.push_back({part, name});
    const ExrLayers found = exr_layers(channels);
    const auto name = [&](const auto& place) { return place ? channels[*place].name : std::string("-"); };
    const auto red = found.colour ? std::optional((*found.colour)[0]) : std::nullopt;
    return name(found.depth) + ' ' + name(red) + ' ' + name(found.materials);
}

TEST(ExrLayers, AreFoundByName) {
    // Blender, in the order of a file: normals and mist have a Z as well.
    EXPECT_EQ(layers_in({"V.Combined.A", "V.Combined.B", "V.Combined.G", "V.Combined.R", "V.Depth.Z",
                         "V.IndexMA.X", "V.Mist.Z", "V.Normal.X", "V.Normal.Y", "V.Normal.Z"}),
              "V.Depth.Z V.Combined.R V.IndexMA.X");
    EXPECT_EQ(layers_in({"V.Combined.B", "V.Combined.G", "V.Combined.R", "V.Denoising Depth.Z", "V.Depth.Z"}),
              "V.Depth.Z V.Combined.R -");
    EXPECT_EQ(layers_in({"V.Depth.V", "V.Material Index.V"}), "V.Depth.V - V.Material Index.V");
    // Several view layers: the first that has depth and colour of its own.
    EXPECT_EQ(layers_in({"a.Depth.Z", "b.Combined.B", "b.Combined.G", "b.Combined.R", "b.Depth.Z",
                         "c.Combined.B", "c.Combined.G", "c.Combined.R", "c.Depth.Z", "c.IndexMA.X"}),
              "b.Depth.Z b.Combined.R -");
    EXPECT_EQ(layers_in({"a.Combined.B", "a.Combined.G", "a.Combined.R", "a.Normal.X", "a.Normal.Y",
                         "a.Normal.Z", "b.Depth.Z"}),
              "b.Depth.Z - -");
    // Two eyes.
    EXPECT_EQ(layers_in({"V.Combined.left.B", "V.Combined.left.G", "V.Combined.left.R", "V.Combined.right.B",
                         "V.Combined.right.G", "V.Combined.right.R", "V.Depth.right.Z"}),
              "V.Depth.right.Z V.Combined.right.R -");
    // Others: at the root, in a layer of their own, in parts.
    EXPECT_EQ(layers_in({"A", "B", "G", "R", "Z"}), "Z R -");
    EXPECT_EQ(layers_in({"B", "G", "R", "depth.B", "depth.G", "depth.R"}), "depth.R R -");
    EXPECT_EQ(layers_in({"B", "G", "R", "depth.Z"}), "depth.Z R -");
    EXPECT_EQ(layers_in({"B", "G", "R", "|", "Z"}), "Z R -");
    EXPECT_EQ(layers_in({"B", "G", "R", "|", "B", "G", "R", "Z"}), "Z R -");
    // Unreal's: the pass is a word that ends so, and R, G and B are alike.
    EXPECT_EQ(layers_in({"A", "B", "FinalImageMovieRenderQueue_WorldDepth.A",
                         "FinalImageMovieRenderQueue_WorldDepth.B", "FinalImageMovieRenderQueue_WorldDepth.G",
                         "FinalImageMovieRenderQueue_WorldDepth.R", "G", "R"}),
              "FinalImageMovieRenderQueue_WorldDepth.R R -");
    EXPECT_EQ(layers_in({"B", "G", "R", "SceneDepth.R"}), "SceneDepth.R R -");
    // Neither depth of a vector nor colour in parts.
    EXPECT_EQ(layers_in({"N.X", "N.Y", "N.Z"}), "- - -");
    EXPECT_EQ(layers_in({"B", "G", "|", "R", "Z"}), "Z - -");
    EXPECT_EQ(layers_in({"B", "G", "R"}), "R - -");
    EXPECT_EQ(layers_in({"disparity"}), "disparity - -");
    EXPECT_EQ(layers_in({"u", "v"}), "- - -");
    // A rendering without depth: its colour is none, be it grey, nor is any other pass.
    EXPECT_EQ(layers_in({"V.Combined.B", "V.Combined.G", "V.Combined.R", "V.IndexMA.X"}), "- - -");
    EXPECT_EQ(layers_in({"V.Combined.B", "V.Combined.G", "V.Combined.R"}), "- - -");
    EXPECT_EQ(layers_in({"V.Combined.R", "V.Mist.Z", "V.Normal.Z"}), "- - -");
    EXPECT_EQ(layers_in({"V.IndexMA.X"}), "- - -");
    EXPECT_EQ(layers_in({"B", "G", "R", "crypto00.r"}), "- - -");
    EXPECT_EQ(layers_in({"", ".", "..Z", "Depth"}), "..Z - -");
    EXPECT_EQ(layers_in({}), "- - -");
}

TEST(ExrLayers, TakeNamedDepth) {
    const std::vector<ExrChannelName> channels{{0, "B"},          {0, "G"},          {0, "R"},
                                               {0, "Dist.G"},     {0, "Dist.R"},     {0, "V.Mist.Z"},
                                               {0, "V.Normal.X"}, {0, "V.Normal.Y"}, {0, "v.mist.z"}};
    const auto depth = [&](const std::string& named) {
        const ExrLayers found = exr_layers(channels, named);
        EXPECT_TRUE(found.same_as_depth.empty());
        return found.depth ? channels[*found.depth].name : std::string("-");
    };
    EXPECT_EQ(depth("V.Mist.Z"), "V.Mist.Z");
    EXPECT_EQ(depth("v.mist.z"), "v.mist.z");
    EXPECT_EQ(depth("V.MIST.Z"), "V.Mist.Z");
    EXPECT_EQ(depth("dist"), "Dist.R");
    EXPECT_EQ(depth("V.Normal"), "V.Normal.X");
    EXPECT_EQ(depth("G"), "G");
    EXPECT_EQ(depth("V"), "-");
    EXPECT_EQ(depth("Z"), "-");
    EXPECT_TRUE(exr_layers(channels, "dist").colour.has_value());
    EXPECT_FALSE(exr_layers(channels, "G").colour.has_value()) << "it is depth";
}

int depths_in(const std::vector<std::string>& names) {
    std::vector<ExrChannelName> channels;
    for (const std::string& name : names) channels.push_back({0, name});
    return exr_layers(channels).depths;
}

TEST(ExrLayers, CountDepthsByViewLayer) {
    EXPECT_EQ(depths_in({"depth.B", "depth.G", "depth.R"}), 1);
    EXPECT_EQ(depths_in({"depth.V", "depth.W"}), 1);
    EXPECT_EQ(depths_in({"V.Denoising Depth.V", "V.Depth.V"}), 1);
    EXPECT_EQ(depths_in({"a.depth.B", "a.depth.G", "a.depth.R", "b.depth.B", "b.depth.G", "b.depth.R"}), 2);
    EXPECT_EQ(depths_in({"a.Depth.Z", "b.Depth.Z", "c.Depth.Z"}), 3);
    EXPECT_EQ(depths_in({"u", "v"}), 0);
}

TEST(ExrLayers, ReadEachPassAlone) {
    const std::filesystem::path seeds =
        std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/exr_layers";
    for (const auto& [name, format] : {std::pair{"layers_half.exr", "rgbf16"},
                                       {"layers_float.exr", "rgbf32"},
                                       {"two_layers.exr", "rgbf16"},
                                       {"z_half.exr", "rgbf16"}}) {
        SCOPED_TRACE(name);
        const std::string bytes = read_bytes(seeds / name);
        const auto whole = must(decode_exr(bytes, "picture", {true, true}));
        ASSERT_TRUE(whole.beside && whole.beside->colour);
        const auto colour = must(decode_exr_colour(bytes, "picture"));
        EXPECT_EQ(colour.pixel_format, format);
        EXPECT_EQ(colour.image.samples, whole.beside->colour->image.samples);
        const auto depth = must(decode_exr(bytes, "picture"));
        EXPECT_EQ(depth.values, whole.values);
        EXPECT_EQ(depth.beside, nullptr);
        const auto indices = decode_exr_materials(bytes, "picture");
        EXPECT_EQ(message(indices), whole.beside->materials
                                        ? ""
                                        : "picture: has no material indices: must have a layer IndexMA of "
                                          "each pixel, but has A, B, G, R, Z");
        EXPECT_EQ(whole.beside->materials.has_value(), std::string(name) != "z_half.exr");
        EXPECT_TRUE(!indices || indices->values == whole.beside->materials->values);
    }
}

struct PartChannel {
    std::string name;
    Imf::PixelType type = Imf::HALF;
    int sampling = 1;
};

/// Parts of 16x16 pixels, of which the display window has `beyond` more around, in each channel 0.5.
std::string file_of_parts(const std::vector<std::vector<PartChannel>>& parts, int beyond = 0,
                          const std::vector<std::string>& names = {}) {
    const TemporaryFolder folder;
    const Imath::Box2i data({0, 0}, {15, 15}), display({-beyond, -beyond}, {15 + beyond, 15 + beyond});
    std::vector<Imf::Header> headers;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        Imf::Header& header = headers.emplace_back(display, data);
        header.setName(names.empty() ? "part" + std::to_string(p) : names[p]);
        header.setType(Imf::SCANLINEIMAGE);
        for (const PartChannel& one : parts[p])
            header.channels().insert(one.name, Imf::Channel(one.type, one.sampling, one.sampling));
    }
    const std::vector<half> halves(256, half(0.5F));
    const std::vector<float> floats(256, 0.5F);
    const std::vector<unsigned> whole(256, 3);
    {
        Imf::MultiPartOutputFile file((folder / "a.exr").c_str(), headers.data(),
                                      static_cast<int>(headers.size()));
        for (std::size_t p = 0; p < parts.size(); ++p) {
            Imf::FrameBuffer frame;
            for (const PartChannel& one : parts[p]) {
                const void* from = one.type == Imf::HALF    ? static_cast<const void*>(halves.data())
                                   : one.type == Imf::FLOAT ? static_cast<const void*>(floats.data())
                                                            : static_cast<const void*>(whole.data());
                const std::size_t bytes = one.type == Imf::HALF ? 2 : 4;
                frame.insert(one.name, Imf::Slice::Make(one.type, from, data, bytes,
                                                        16 * bytes / static_cast<std::size_t>(one.sampling),
                                                        one.sampling, one.sampling));
            }
            Imf::OutputPart part(file, static_cast<int>(p));
            part.setFrameBuffer(frame);
            part.writePixels(16);
        }
    }
    return read_bytes(folder / "a.exr");
}

TEST(ExrLayers, ReadPartsOfDifferentTypes) {
    const std::string bytes =
        file_of_parts({{{"B"}, {"G"}, {"R"}}, {{"Z", Imf::FLOAT}}, {{"IndexMA.X", Imf::UINT}}}, 2);
    const auto picture = must(decode_exr(bytes, "picture", {true, true}));
    ASSERT_TRUE(picture.beside && picture.beside->colour && picture.beside->materials);
    const Image &colour = picture.beside->colour->image, &materials = picture.beside->materials->image;
    ASSERT_EQ(colour.width, 20);
    ASSERT_EQ(materials.width, 20);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 20; ++x) {
            const bool is_inside = x >= 2 && x < 18 && y >= 2 && y < 18;
            const auto k = static_cast<std::size_t>(20 * y + x);
            ASSERT_EQ(std::isnan(picture.values[k]), !is_inside) << x << ' ' << y;
            ASSERT_EQ(colour.samples[3 * k + 1], is_inside ? 188 : 0) << x << ' ' << y;
            ASSERT_EQ(materials.view().sample(x, y), is_inside ? 3 : 0) << x << ' ' << y;
        }
}

/// Nuke, Blender 5 and others call a part what they would call a layer, and its channels R, Y, V or Z.
TEST(ExrLayers, AreNamedByParts) {
    const std::vector<PartChannel> rgb{{"B"}, {"G"}, {"R"}};
    const auto found = [&](const std::vector<std::string>& names,
                           const std::vector<std::vector<PartChannel>>& parts) {
        const auto picture = decode_exr(file_of_parts(parts, 0, names), "picture", {true, true});
        if (!picture) return picture.error().message;
        if (!picture->beside) return std::string("no colour");
        return picture->beside->depth_name + (picture->beside->colour ? ", colour" : "") +
               (picture->beside->materials ? ", materials" : "");
    };
    for (const char* own : {"Z", "Y", "R", "V"})
        EXPECT_EQ(found({"rgba", "depth"}, {rgb, {{own, Imf::FLOAT}}}),
                  "depth." + std::string(own) + ", colour");
    EXPECT_EQ(found({"rgba", "Depth"}, {rgb, rgb}), "Depth.R, colour");
    EXPECT_EQ(found({"rgba", "depth"}, {rgb, {{"depth.Z"}}}), "depth.Z, colour");
    EXPECT_EQ(found({"normal", "View.Depth", "View.Combined", "View.IndexMA"},
                    {{{"X"}, {"Y"}, {"Z"}}, {{"V"}}, rgb, {{"X", Imf::UINT}}}),
              "View.Depth.V, colour, materials");
    EXPECT_EQ(
        found({"normal", "rgba"}, {{{"X"}, {"Y"}, {"Z"}}, rgb}),
        "picture: has no channel Z, depth, Y or R for each pixel, but normal.X, normal.Y, normal.Z, B, G, R");
}

TEST(ExrLayers, SkipUnusableColour) {
    for (const auto& channels : {std::vector<PartChannel>{{"B"}, {"G", Imf::HALF, 2}, {"R"}, {"Z"}},
                                 {{"B", Imf::UINT}, {"G", Imf::UINT}, {"R", Imf::UINT}, {"Z"}}}) {
        const std::string bytes = file_of_parts({channels});
        const auto picture = decode_exr(bytes, "picture", {true, true});
        ASSERT_EQ(message(picture), "");
        EXPECT_EQ(picture->values.at(200), 0.5F);
        EXPECT_EQ(picture->beside, nullptr);
        EXPECT_EQ(message(decode_exr_colour(bytes, "picture")),
                  "picture: has no colour: must have channels R, G and B, floats of each pixel, but has B, "
                  "G, R, Z");
    }
    EXPECT_EQ(message(decode_exr(file_of_parts({{{"B"}, {"G", Imf::HALF, 2}, {"R"}}}), "picture")),
              "picture: is in colour: a picture of depth has a channel Z, depth, Y or R");
    EXPECT_EQ(
        message(decode_exr_colour(file_of_parts({{{"a\x1b[2J\n"}}}), "picture")),
        "picture: has no colour: must have channels R, G and B, floats of each pixel, but has a\\x1b[2J\\n");
}

/// IEC 61966-2-1, by the C library.
int srgb_of(double light) {
    const double shown = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
    return static_cast<int>(std::floor(255 * std::min(std::max(shown, 0.0), 1.0) + 0.5));
}

TEST(LinearLight, RoundsToNearestSrgbSample) {
    int wrong = 0;
    for (int k = 0; k < 200'000; ++k) {
        const float light = static_cast<float>(k) / 190'000;
        wrong += srgb_sample(light) != srgb_of(light);
    }
    for (int bits = 0; bits < 0x7c00; ++bits) {
        half number;
        number.setBits(static_cast<unsigned short>(bits));
        wrong += srgb_sample(static_cast<std::uint16_t>(bits)) != srgb_of(number);
        wrong += srgb_sample(static_cast<float>(number)) != srgb_of(number);
    }
    EXPECT_LE(wrong, 2) << "but for a tie";
    for (const float none : {-1.0F, -0.0F, 0.0F, NAN, -INFINITY}) EXPECT_EQ(srgb_sample(none), 0);
    for (const std::uint16_t none : {0x8000, 0xbc00, 0x7e00, 0xfc00}) EXPECT_EQ(srgb_sample(none), 0);
    EXPECT_EQ(srgb_sample(INFINITY), 255);
    EXPECT_EQ(srgb_sample(std::uint16_t{0x7c00}), 255);
}

}  // namespace
}  // namespace touchable::test
