#include "mq/model/kept_work.h"

#include <algorithm>

namespace mq {
namespace {

bool equal(const TextureSize& a, const TextureSize& b) {
  return a.width == b.width && a.height == b.height && a.wrap == b.wrap;
}

/// Whether spaces on them would be the same: what they are made of, not what is counted of it.
bool equal(const Surface& a, const Surface& b) {
  return a.mesh.positions == b.mesh.positions && a.mesh.triangles == b.mesh.triangles && a.mesh.uvs == b.mesh.uvs &&
         a.mesh.corner_uvs == b.mesh.corner_uvs && a.mesh.textures == b.mesh.textures && a.twins == b.twins &&
         a.degenerate == b.degenerate;
}

bool equal(const Atlas& a, const Atlas& b) {
  return std::ranges::equal(a.textures, b.textures,
                            [](const TextureSize& s, const TextureSize& t) { return equal(s, t); }) &&
         a.chart == b.chart && a.corners == b.corners && a.edges == b.edges;
}

bool is_kept(const TexelSpaceOptions& options) { return options.metrics.empty() && options.cells.empty(); }

bool equal(const TexelSpaceOptions& a, const TexelSpaceOptions& b) {
  return is_kept(a) && is_kept(b) && a.seams == b.seams && a.seam_penalty == b.seam_penalty;
}

bool equal(const StoppingRule& a, const StoppingRule& b) {
  return a.tolerance == b.tolerance && a.max_cycles == b.max_cycles;
}

}  // namespace

/// A space with what it refers to.
struct KeptWork::Place {
  Surface surface;
  Atlas atlas;
  TexelSpaceOptions options;
  TexelSpace space;

  Place(const Surface& s, const Atlas& a, const TexelSpaceOptions& o, const Progress& progress)
      : surface(s), atlas(a), options(o), space(surface, atlas, options, progress) {}
};

struct KeptWork::Prepared {
  double weight;
  SolverChoice::Kind kind;
  StoppingRule stop;
  std::shared_ptr<const ScreenedPoisson> equation;
};

KeptWork::KeptWork() = default;
KeptWork::~KeptWork() { forget(); }

void KeptWork::forget_equation() { prepared_.reset(); }

void KeptWork::forget() {
  forget_equation();  // it refers to the space
  place_.reset();
}

std::shared_ptr<const TexelSpace> KeptWork::space(const Surface& surface, const Atlas& atlas,
                                                  const TexelSpaceOptions& options, const Progress& progress) {
  if (!is_kept(options)) return std::make_shared<const TexelSpace>(surface, atlas, options, progress);
  const bool is_there = place_ && equal(place_->options, options) && equal(place_->surface, surface) &&
                        equal(place_->atlas, atlas);
  if (!is_there) {
    forget();
    place_ = std::make_shared<Place>(surface, atlas, options, progress);
  }
  return {place_, &place_->space};
}

KeptWork::Equation KeptWork::equation(const SignalSpace& space, double weight, const SolverChoice& choice,
                                      const SolverFactory& factory, const Progress& progress) {
  const auto made = [&] { return std::make_shared<const ScreenedPoisson>(space, weight, factory, progress); };
  if (!place_ || &space != &place_->space || choice.kind == SolverChoice::Kind::given) return {made()};
  if (prepared_ && prepared_->weight == weight && prepared_->kind == choice.kind && equal(prepared_->stop, choice.stop))
    return {prepared_->equation, true};
  prepared_.reset();
  prepared_ = std::make_unique<Prepared>(weight, choice.kind, choice.stop, made());
  return {prepared_->equation};
}

}  // namespace mq
