/// Functions of libraries that may or may not be there are looked up in CHOLMOD and in what it was linked with, so that
/// they are found too where this library is a module whose names nobody else sees.

#include "mq/linear/calling_thread.h"

#include <dlfcn.h>

#include <mutex>
#include <type_traits>

#ifdef MARQUETRY_WITH_CHOLMOD
#include <cholmod.h>
#endif

namespace mq {
namespace {

/// What `openblas_get_parallel` answers.
enum class Parallel { none = 0, own_threads = 1, openmp = 2 };

struct Libraries {
  // OpenMP.
  int (*max_threads)() = nullptr;
  void (*set_threads)(int) = nullptr;
  int (*max_levels)() = nullptr;
  void (*set_levels)(int) = nullptr;
  // OpenBLAS.
  int (*parallel)() = nullptr;
  int (*blas_threads)() = nullptr;
  void (*set_blas_threads)(int) = nullptr;

  Libraries() {
    void* cholmod = nullptr;
#ifdef MARQUETRY_WITH_CHOLMOD
    if (Dl_info place; ::dladdr(reinterpret_cast<const void*>(&cholmod_l_start), &place) != 0)
      cholmod = ::dlopen(place.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
#endif
    const auto find = [&](auto& function, const char* name) {
      void* found = cholmod != nullptr ? ::dlsym(cholmod, name) : nullptr;
      if (found == nullptr) found = ::dlsym(RTLD_DEFAULT, name);
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
    };
    find(max_threads, "omp_get_max_threads");
    find(set_threads, "omp_set_num_threads");
    find(max_levels, "omp_get_max_active_levels");
    find(set_levels, "omp_set_max_active_levels");
    find(parallel, "openblas_get_parallel");
    find(blas_threads, "openblas_get_num_threads");
    find(set_blas_threads, "openblas_set_num_threads");
  }

  void keep_openmp_here() const {
    set_threads(1);
    set_levels(0);  // CHOLMOD names the number of threads at its loops
  }
  bool openmp() const { return max_threads && set_threads && max_levels && set_levels; }
  bool openblas(Parallel kind) const {
    return parallel && blas_threads && set_blas_threads && Parallel(parallel()) == kind;
  }
};

const Libraries& libraries() {
  static const Libraries found;
  return found;
}

std::mutex in_turns;      ///< of callers of an OpenBLAS without locks
std::mutex counting;      ///< guards the next two
int living = 0;           ///< callers of an OpenBLAS with threads of its own
int blas_threads_before;  ///< those it had before the first of them

}  // namespace

OnCallingThread::OnCallingThread() {
  const Libraries& found = libraries();
  if (found.openmp()) {
    threads_before_ = found.max_threads();
    levels_before_ = found.max_levels();
    found.keep_openmp_here();
  }
  if (found.openblas(Parallel::none)) in_turns.lock();
  if (found.openblas(Parallel::own_threads)) {
    const std::lock_guard lock(counting);
    if (living++ == 0) {
      blas_threads_before = found.blas_threads();
      found.set_blas_threads(1);
    }
  }
}

OnCallingThread::~OnCallingThread() {
  const Libraries& found = libraries();
  if (found.openblas(Parallel::own_threads)) {
    const std::lock_guard lock(counting);
    if (--living == 0) found.set_blas_threads(blas_threads_before);
  }
  if (found.openblas(Parallel::none)) in_turns.unlock();
  if (found.openmp()) {
    found.set_levels(levels_before_);
    found.set_threads(threads_before_);
  }
}

void stay_on_calling_thread() {
  const Libraries& found = libraries();
  if (found.openmp()) found.keep_openmp_here();
  if (found.openblas(Parallel::own_threads)) found.set_blas_threads(1);
}

}  // namespace mq
