#include "tests/verify/verify_forces.hpp"

#include <charconv>

#include "tests/verify/checks.hpp"

namespace touchable::verify {
namespace {

constexpr std::string_view usage =
    "verify_forces --forces FILE.csv --frames DIR [--min-contact SHARE] [--no-slip] [--shown N]\n"
    "  FILE.csv       written by touchable touch --forces\n"
    "  DIR            DIR/N holds what touchable export --frame N wrote, for every frame that the file "
    "names\n"
    "  --min-contact  fail where fewer rows are in contact, 0 to 1 (default 0)\n"
    "  --no-slip      do not check how a proxy moves within a facet (for substeps, or other than Coulomb "
    "friction)\n"
    "  --shown        offenders shown of each kind (default 3)\n";

struct Options {
    std::string forces, frames;
    double min_contact = 0;
    Settings settings;
};

template <class Number>
bool read_number(const std::string& text, Number least, Number most, Number& out) {
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), out);
    return status == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

Result<Options> read_options(const std::vector<std::string>& arguments) {
    Options options;
    for (std::size_t k = 0; k < arguments.size(); ++k) {
        const std::string& name = arguments[k];
        if (name == "--no-slip") {
            options.settings.check_slip = false;
            continue;
        }
        if (name != "--forces" && name != "--frames" && name != "--min-contact" && name != "--shown")
            return usage_error("unknown option " + name);
        if (k + 1 == arguments.size()) return usage_error(name + " needs a value");
        const std::string& value = arguments[++k];
        if (name == "--forces") options.forces = value;
        if (name == "--frames") options.frames = value;
        if (name == "--min-contact" && !read_number(value, 0.0, 1.0, options.min_contact))
            return usage_error("--min-contact is \"" + value + "\": must be 0 to 1");
        if (name == "--shown" && !read_number(value, 0, 1000000, options.settings.shown))
            return usage_error("--shown is \"" + value + "\": must be a whole number, 0 or more");
    }
    if (options.forces.empty() || options.frames.empty())
        return usage_error("--forces and --frames must be given");
    return options;
}

Result<void> check_rows(const std::string& forces, Verifier& verifier) {
    auto reader = ForcesReader::open(forces);
    if (!reader) return reader.error();
    ForceRow row;
    for (;;) {
        const auto more = reader->next(row);
        if (!more) return more.error();
        if (!*more) break;
        if (auto checked = verifier.check(row); !checked)
            return input_error(checked.error().message + " (line " + std::to_string(row.line) + " of " +
                               forces + " needs it)");
    }
    verifier.finish();
    if (verifier.coverage().rows == 0) return input_error(forces + ": has no rows");
    return {};
}

}  // namespace

int verify_forces(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
    const auto options = read_options(arguments);
    if (!options) {
        err << "verify_forces: " << options.error().message << '\n' << usage;
        return exit_code(options.error().kind);
    }
    FrameStore frames(options->frames);
    Verifier verifier(frames, options->settings);
    if (const auto checked = check_rows(options->forces, verifier); !checked) {
        err << "verify_forces: " << checked.error().message << '\n';
        return exit_code(checked.error().kind);
    }
    verifier.report(out);
    const Coverage& c = verifier.coverage();
    const double share = static_cast<double>(c.contacts) / static_cast<double>(c.rows);
    out << "contact share " << share << ", at least " << options->min_contact << " wanted\n";
    const bool good = verifier.violations() == 0 && share >= options->min_contact;
    out << (good ? "verified" : "NOT verified") << '\n';
    return good ? 0 : exit_code(ErrorKind::check);
}

}  // namespace touchable::verify
