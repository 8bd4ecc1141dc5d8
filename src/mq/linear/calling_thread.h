#pragma once
/// BLAS and OpenMP, kept in the thread that calls them.

namespace mq {

/// While it lives, BLAS and the loops of OpenMP that this thread comes to (CHOLMOD's, say) run in this thread alone.
/// Several threads factor at a time here, and sums must not depend on how many there are; besides, threads that wait
/// for CHOLMOD's next short loop spin. To be had around each call; it costs nothing beside one.
///
/// The BLAS is whichever is installed:
///
/// - the reference BLAS needs nothing of this;
/// - OpenBLAS with OpenMP asks the calling thread how many it may use, and is told one;
/// - OpenBLAS with threads of its own has one number for the whole program. It is one while any of these lives, and
///   what it was before when the last has gone;
/// - OpenBLAS without threads (Debian's `libopenblas0-serial`) shares its buffers between callers without a lock: with
///   it only one of these lives at a time, and others wait.
class OnCallingThread {
 public:
  OnCallingThread();
  ~OnCallingThread();
  OnCallingThread(const OnCallingThread&) = delete;
  OnCallingThread& operator=(const OnCallingThread&) = delete;

 private:
  int threads_before_ = 0, levels_before_ = -1;
};

/// The same for the calling thread from now on, in programs of which a process runs on each core. Takes no turns.
void stay_on_calling_thread();

}  // namespace mq
