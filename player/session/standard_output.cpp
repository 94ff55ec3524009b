#include "player/session/standard_output.hpp"

#include <poll.h>
#include <unistd.h>

#include <iostream>

namespace touchable {
namespace {

bool reader_is_gone() {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    return poll(&output, 1, 0) == 1 && (output.revents & (POLLERR | POLLHUP)) != 0;
}

}  // namespace

bool is_standard_output(const std::filesystem::path& name) {
    return name == "-";
}

Result<void> flush_standard_output() {
    std::cout.flush();
    if (std::cout || reader_is_gone()) return {};
    return input_error("standard output cannot be written");
}

}  // namespace touchable
