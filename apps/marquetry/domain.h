#pragma once
/// The functions on a scene that a signal is made of, and the solvers that know them.

#include <optional>
#include <span>
#include <vector>

#include "mq/atlas/separate_overlaps.h"
#include "mq/fem/boundary_unknowns.h"
#include "mq/fem/texel_copies.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/solver.h"
#include "shell/run.h"
#include "scene.h"

namespace mq::app {

/// When iterations stop: at a relative residual, or after so many cycles.
struct WhenToStop {
  double tolerance = 1e-6;
  std::optional<int> cycles = {};
};

class Domain {
 public:
  virtual ~Domain() = default;
  virtual const SignalSpace& space() const = 0;

  /// Of the surface; what counts as a texel where there are none is the mean spacing of vertices.
  SurfaceScale scale() const;

  /// Where the unknowns lie on the surface.
  virtual std::vector<Vector3> places() const = 0;

  /// The unknowns at the boundaries of the surface.
  virtual std::vector<int> boundary() const = 0;

  /// The largest of values, one per unknown, that the surface shows; those that are not finite do
  /// not count.
  virtual double largest_shown(const Vector& values) const = 0;

  /// Whether there are the solvers below. Where not, asking for one throws `Unsupported`.
  virtual bool has_multigrid() const = 0;
  virtual SolverFactory multigrid(const WhenToStop& when) const = 0;
  virtual SolverFactory reference(const WhenToStop& when) const = 0;
};

/// The texels that the charts use. The scene must have an atlas and outlive the domain.
class TexelDomain : public Domain {
 public:
  /// A texel that several charts read is one unknown, whose value is right for none of them but the
  /// best there is for all; or one for each chart, of which the picture can show one
  /// (`separate_overlaps`).
  enum class SharedTexels { one_unknown, one_for_each };

  /// Puts the space's defects into the report and warns of them.
  TexelDomain(Run& run, const Scene& scene, const TexelSpaceOptions& options = {},
              const Progress& progress = {}, SharedTexels shared = SharedTexels::one_unknown);

  const TexelSpace& space() const override { return *space_; }

  /// The unknowns of a texel of the pictures, none where no chart reads it. With one for each
  /// chart, those of the charts that cover its centre.
  std::vector<int> unknowns_at(const Texels::Place& texel) const;

  /// Puts values, one row per unknown, into the texels of the pictures.
  void put(const Signal& values, std::span<Image<float>> pictures) const;

  std::vector<Vector3> places() const override;
  std::vector<int> boundary() const override;
  double largest_shown(const Vector& values) const override;
  bool has_multigrid() const override { return true; }
  SolverFactory multigrid(const WhenToStop& when) const override;
  SolverFactory reference(const WhenToStop& when) const override;

 private:
  const Atlas& atlas() const { return apart_ ? apart_->atlas : *scene_.atlas; }

  const Scene& scene_;
  std::optional<SeparatedAtlas> apart_;  ///< nothing where each texel is one unknown
  std::optional<TexelSpace> space_;
  std::optional<TexelCopies> copies_;
};

/// The vertices of the surface, which must outlive the domain. Copies of a vertex that exporters
/// wrote for several charts are one.
class VertexDomain : public Domain {
 public:
  explicit VertexDomain(const Scene& scene) : scene_(scene), space_(scene.surface) {}

  const VertexSpace& space() const override { return space_; }
  std::vector<Vector3> places() const override { return scene_.surface.mesh.positions; }
  std::vector<int> boundary() const override { return boundary_unknowns(scene_.surface); }
  double largest_shown(const Vector& values) const override;
  bool has_multigrid() const override { return true; }
  SolverFactory multigrid(const WhenToStop& when) const override;
  SolverFactory reference(const WhenToStop& when) const override;

 private:
  const Scene& scene_;
  VertexSpace space_;
};

}  // namespace mq::app
