// What h5ls says of an HDF5 file, whose names and filters are the file's own.
#include <set>

#include "engine/picture/number_pictures.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_hdf5_listing(std::string_view bytes) {
    const auto sets = hdf5_data_sets(bytes);
    if (!is_taken(sets)) return false;
    std::set<std::string> paths;
    for (const Hdf5DataSet& set : *sets) {
        require(set.path.starts_with('/') && paths.insert(set.path).second, "a path is none, or there twice");
        require(set.shape.size() <= 32, "a data set has too many extents");
        for (const std::int64_t extent : set.shape)
            require(extent >= 0 && extent <= std::int64_t{1} << 31, "an extent is none");
        require(!set.format || (set.format->bytes >= 1 && set.format->bytes <= 8), "a number has no size");
    }
    return !sets->empty();
}

const Registered hdf5_listing_target{{.name = "hdf5_listing", .parse = parse_hdf5_listing}};

}  // namespace
}  // namespace touchable::fuzz
