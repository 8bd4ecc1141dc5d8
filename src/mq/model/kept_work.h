#pragma once
/// What was prepared for the textures worked on last, for others on the same charts: the next frame of a sequence, the
/// next slot of a material, the next job of a batch.

#include <memory>

#include "mq/fem/texel_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/solver.h"
#include "mq/model/solving.h"

namespace mq {

/// Holds one space and one equation. Results are the same to the last bit as without it; memory is what those two
/// take, from one run to the next. Not for several threads at a time.
class KeptWork {
 public:
  KeptWork();
  ~KeptWork();
  KeptWork(const KeptWork&) = delete;
  KeptWork& operator=(const KeptWork&) = delete;

  /// `TexelSpace(surface, atlas, options)`, or the last one if it was made of equals of these; it refers to copies of
  /// them, so both may go. Spaces with metrics or cells of their own are made anew and not kept. Throws what that
  /// constructor throws, and then holds nothing.
  std::shared_ptr<const TexelSpace> space(const Surface& surface, const Atlas& atlas, const TexelSpaceOptions& options,
                                          const Progress& progress = {});

  /// An equation, and whether it is that of before.
  struct Equation {
    std::shared_ptr<const ScreenedPoisson> of;
    bool kept = false;
  };

  /// The equation of this weight on the space, prepared by the factory, or the last one if it was made by the same
  /// choice. On a space that is not the one held, or with a factory of the choice's own, it is made anew and not kept.
  Equation equation(const SignalSpace& space, double weight, const SolverChoice& choice, const SolverFactory& factory,
                    const Progress& progress = {});

  /// Lets go of the equation, or of both.
  void forget_equation();
  void forget();

 private:
  struct Place;
  struct Prepared;
  std::shared_ptr<Place> place_;
  std::unique_ptr<Prepared> prepared_;
};

}  // namespace mq
