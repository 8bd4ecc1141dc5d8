// A program of one verb that has begun a file and then does not look up for a minute, as work in a library
// might: what a second Ctrl-C is for.
#include <chrono>
#include <thread>

#include "mq/io/atomic_file.h"
#include "shell/run.h"
#include <shell/program.h>

namespace {

mq::app::Exit work(mq::app::Run& run) {
  const mq::AtomicFile file(run.options().text("output"));
  run.terminal().remark("at work");
  std::this_thread::sleep_for(std::chrono::minutes(1));
  return mq::app::Exit::done;
}

}  // namespace

int main(int argc, char** argv) {
  mq::OptionTable table("stubborn", "Do not look up.");
  table.add({.name = "output",
             .letter = 'o',
             .type = mq::Option::Type::path,
             .required = true,
             .help = "a file that is never finished"});
  return mq::app::run_program({{table, work}}, {argv + 1, argv + argc});
}
