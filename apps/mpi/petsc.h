#pragma once
/// What wraps PETSc: objects that are let go of, and errors as exceptions.

#include <petscksp.h>

#include <utility>

#include "mq/linear/matrix.h"

namespace mq::shared {

/// Throws `SolverError` with PETSc's words where it says that something went wrong.
void check(PetscErrorCode code);

/// A handle of PETSc's and what destroys it.
template <class Handle, PetscErrorCode (*destroy)(Handle*)>
class Owned {
 public:
  Owned() = default;
  Owned(Owned&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Owned() { reset(); }

  void reset() {
    if (handle_) destroy(&handle_);
    handle_ = nullptr;
  }
  Handle* place() {
    reset();
    return &handle_;
  }
  operator Handle() const { return handle_; }

 private:
  Handle handle_ = nullptr;
};

/// A channel of a signal's own rows, as a vector of PETSc's and back.
void put_channel(const Signal& X, Eigen::Index channel, Vec to);
void take_channel(Vec from, Eigen::Index channel, Signal& X);

using OwnedMat = Owned<Mat, MatDestroy>;
using OwnedVec = Owned<Vec, VecDestroy>;
using OwnedPC = Owned<PC, PCDestroy>;

}  // namespace mq::shared
