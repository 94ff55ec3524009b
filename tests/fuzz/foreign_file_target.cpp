// What is said of files that are not opened.
#include "engine/formats/foreign_files.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// Under a name that says nothing, and under names of which only some say what the file is.
bool parse_foreign_file(std::string_view bytes) {
    bool is_known = false;
    for (const char* name : {"foreign", "foreign.bin", "foreign.zip"}) {
        const SourceFile file(file_of(bytes, name));
        const auto misleading = misleading_file(file, bytes.substr(0, 16)), what = foreign_file(file);
        require(!misleading || what == misleading, "two things are said of a file");
        if (what) require_readable({ErrorKind::input, name + (": " + *what)});
        is_known = is_known || what;
    }
    return is_known;
}

const Registered foreign_file_target{{.name = "foreign_file", .parse = parse_foreign_file}};

}  // namespace
}  // namespace touchable::fuzz
