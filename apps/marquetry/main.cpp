// marquetry VERB INPUT... -o OUTPUT [options]
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "shell/program.h"

namespace {

/// Where a standard stream is closed, the next file that is opened would be taken for it.
void open_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDWR);
}

}  // namespace

int main(int argc, char** argv) {
  open_closed_streams();
  const int status = mq::app::run_program(mq::app::all_verbs(), {argv + 1, argv + argc});
  // What was cancelled may have left a factorisation behind, which nobody waits for.
  if (status == int(mq::app::Exit::cancelled)) {
    std::fflush(nullptr);
    ::_exit(status);
  }
  return status;
}
