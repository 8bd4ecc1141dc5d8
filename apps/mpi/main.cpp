// mpirun -n N marquetry-mpi VERB INPUT... -o OUTPUT [options]
//
// The frame around verbs is that of marquetry; the first process alone speaks and writes the report.
#include <petscsys.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/linear/calling_thread.h"
#include "processes.h"
#include "shell/program.h"
#include "shell/scratch.h"
#include "verbs.h"

namespace {

/// Without what the first process does for all.
void leave_out_reports(std::vector<std::string>& words) {
  std::erase(words, "--json");
  for (auto word = words.begin(); word != words.end();) {
    if (*word == "--report" && word + 1 != words.end())
      word = words.erase(word, word + 2);
    else if (word->starts_with("--report="))
      word = words.erase(word);
    else
      ++word;
  }
}

}  // namespace

int main(int argc, char** argv) {
  mq::stay_on_calling_thread();  // PETSc's packages call BLAS too
  // Words after "--petsc" are PETSc's, for those who know it.
  std::vector<std::string> words(argv + 1, argv + argc);
  const auto end = std::ranges::find(words, "--petsc");
  try {
    mq::app::start_with_scratch({words.begin(), end});
  } catch (const mq::Error& error) {
    std::fprintf(stderr, "marquetry-mpi: %s\n", error.what());
    return 2;
  }
  std::vector<char*> theirs{argv[0]};
  for (auto word = end == words.end() ? end : end + 1; word != words.end(); ++word) theirs.push_back(word->data());
  int their_count = int(theirs.size());
  theirs.push_back(nullptr);
  char** their_words = theirs.data();
  if (PetscInitialize(&their_count, &their_words, nullptr, nullptr) != 0) return 2;
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);

  std::vector<std::string> ours(words.begin(), end);
  int status = 0;
  {
    const mq::shared::Processes processes;
    mq::shared::silence_others(processes);
    if (!processes.is_first()) leave_out_reports(ours);
    using namespace mq::shared;
    status = mq::app::run_program(
        {filter_verb(), stitch_verb(), denoise_verb(), seams_verb(), fill_verb(), geodesic_verb()}, ours);
  }
  PetscFinalize();
  return status;
}
