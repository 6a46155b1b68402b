#include "lcmtypes/program/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <string>

#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

// Straight to the descriptor: a buffer would report its failure at the end of the program, where nobody asks.
std::error_code WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return {errno, std::generic_category()};
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

}  // namespace

void SecureStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one. Opened for the other direction, so that an answer which nobody can read is
    // an error, as it was while the stream was closed.
    const int opened = open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    if (opened != stream) std::_Exit(EXIT_FAILURE);  // a system without /dev/null, and nowhere to say so
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void WriteOutput(std::string_view text) { DrawOutput(CleanLines(text)); }

std::error_code WriteMessage(std::string_view text) { return DrawMessage(CleanLines(text)); }

std::error_code WriteComplaint(std::string_view program, std::string_view what) {
  return DrawMessage(CleanText(std::string(program) + ": " + std::string(what)) + "\n");
}

void DrawOutput(std::string_view text) {
  if (const std::error_code error = WriteAll(STDOUT_FILENO, text)) {
    throw std::system_error(error, "cannot write to stdout");
  }
}

std::error_code DrawMessage(std::string_view text) { return WriteAll(STDERR_FILENO, text); }

}  // namespace knap
