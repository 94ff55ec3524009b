#pragma once

// Files of devices, programs, networks and data sets, made small: for each row of docs/formats.md's table
// one file or folder with its real names, values and side files.

#include <filesystem>
#include <map>
#include <string>

#include "engine/scene/scene.hpp"
#include "tests/import/source_writer.hpp"

namespace touchable::test {

/// The file of a source, and the clip that it has to give.
struct Made {
    std::filesystem::path file;  ///< what is typed
    Depth metres{};              ///< as stored
    Camera camera{};
    int frames = 1;
    double rate = 30;         ///< frames a second
    bool has_colour = false;  ///< found, whichever that is
    int width = wide, height = high;
    int lost_codes = 0;  ///< at most, by the source's own codec
    DepthSemantics semantics = DepthSemantics::planar;
};

using SourceMaker = Made (*)(Writer&);
/// By the names of rows (DepthSource).
const std::map<std::string, SourceMaker>& source_makers();

}  // namespace touchable::test
