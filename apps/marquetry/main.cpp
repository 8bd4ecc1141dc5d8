// marquetry VERB INPUT... -o OUTPUT [options]
#include <unistd.h>

#include <cstdio>

#include "shell/program.h"

int main(int argc, char** argv) {
  const int status = mq::app::run_program(mq::app::all_verbs(), {argv + 1, argv + argc});
  // What was cancelled may have left a factorisation behind, which nobody waits for.
  if (status == int(mq::app::Exit::cancelled)) {
    std::fflush(nullptr);
    ::_exit(status);
  }
  return status;
}
