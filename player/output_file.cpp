#include "player/output_file.hpp"

#include <utility>

namespace touchable {

OutputFile::OutputFile(std::string option, const std::filesystem::path& file)
    : option_(std::move(option)), file_(file), out_(file_.path(), std::ios::binary) {}

Result<std::unique_ptr<OutputFile>> OutputFile::create(std::string option,
                                                       const std::filesystem::path& file) {
    std::unique_ptr<OutputFile> out(new OutputFile(std::move(option), file));
    if (auto usable = out->file_.check_target(); !usable.ok())
        return input_error(out->option_ + ' ' + usable.error().message);
    if (!out->out_) return out->failed();
    return out;
}

Result<void> OutputFile::write(std::string_view bytes) {
    out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out_) return failed();
    return {};
}

Result<void> OutputFile::finish() {
    out_.close();
    if (!out_) return failed();
    return file_.commit();
}

Error OutputFile::failed() const {
    return input_error(option_ + ' ' + file_.target().string() +
                       ": cannot be written (no such folder, no permission, or the disk is full)");
}

}  // namespace touchable
