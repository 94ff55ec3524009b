#include "player/session/output_file.hpp"

#include <iostream>
#include <utility>

#include "player/session/standard_output.hpp"

namespace touchable {

OutputFile::OutputFile(std::string option, const std::filesystem::path& file, Existing existing)
    : option_(std::move(option)) {
    if (is_standard_output(file)) return;
    file_.emplace(file, existing);
    out_.open(file_->path(), std::ios::binary);
}

Result<std::unique_ptr<OutputFile>> OutputFile::create(std::string option, const std::filesystem::path& file,
                                                       Existing existing) {
    std::unique_ptr<OutputFile> out(new OutputFile(std::move(option), file, existing));
    if (!out->file_) return out;
    if (auto usable = out->file_->check(); !usable.ok())
        return input_error(out->option_ + ' ' + usable.error().message);
    if (!out->out_) return out->failed();
    return out;
}

Result<void> OutputFile::write(std::string_view bytes) {
    std::ostream& out = file_ ? out_ : std::cout;
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (out) return {};
    return file_ ? failed() : flush_standard_output();
}

Result<void> OutputFile::finish() {
    if (!file_) return flush_standard_output();
    out_.close();
    if (!out_) return failed();
    return file_->commit();
}

std::string OutputFile::name() const {
    return option_ + ' ' + (file_ ? file_->target().string() : "-");
}

Error OutputFile::failed() const {
    return input_error(name() + ": cannot be written (no such folder, no permission, or the disk is full)");
}

Error fell_behind_error(const std::string& files, std::int64_t ticks_missing) {
    const std::string slow =
        files.empty() ? "this machine was" : files + ": its disk, or whoever reads it, was";
    return input_error(slow + " too slow for 1000 ticks a second: " + std::to_string(ticks_missing) +
                       " ticks are missing, so it is not complete, and no file is kept");
}

}  // namespace touchable
