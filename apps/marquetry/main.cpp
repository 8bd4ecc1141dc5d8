// marquetry VERB INPUT... -o OUTPUT [options]
#include "program.h"

int main(int argc, char** argv) {
  return mq::app::run_program(mq::app::all_verbs(), {argv + 1, argv + argc});
}
