#pragma once
/// What wraps PETSc: objects that are let go of, and errors as exceptions.

#include <petscksp.h>

#include <memory>
#include <utility>

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

using OwnedMat = Owned<Mat, MatDestroy>;
using OwnedVec = Owned<Vec, VecDestroy>;
using OwnedPC = Owned<PC, PCDestroy>;

}  // namespace mq::shared
