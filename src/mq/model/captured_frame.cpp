#include "mq/model/captured_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/evolving_file.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/orient.h"
#include "mq/model/frame_loader.h"

namespace mq {
namespace {

/// Texture coordinates that say the same lie no farther apart; material, of its box' diagonal.
constexpr double uv_tolerance = 1e-4, material_tolerance = 0.02;
/// A material that no point of a frame is near.
constexpr double nowhere = 1e9;

/// Values at the vertices of a mesh that was cut.
std::vector<float> values_at(const std::vector<SurfacePoint>& places, const Mesh& uncut,
                             const VertexSignal& signal) {
  std::vector<float> values;
  values.reserve(places.size() * std::size_t(signal.channels));
  for (const SurfacePoint& at : places)
    for (int c = 0; c < signal.channels; ++c)
      values.push_back(float(interpolate(at.barycentric, [&](int k) {
        return signal.values[std::size_t(uncut.triangles[at.triangle][k]) * signal.channels + c];
      })));
  return values;
}

/// How many times farther from the middle than half of the vertices no vertex of a surface lies.
constexpr double stray = 1e4;

/// Throws where a vertex lies so far from the others that the surface is none.
void require_no_stray(const Mesh& mesh, const std::string& name) {
  std::vector<double> values(mesh.triangles.size());
  const auto middle = [&](const auto& value_at) {
    for (std::size_t t = 0; t < values.size(); ++t) values[t] = value_at(mesh.positions[mesh.triangles[t][0]]);
    std::ranges::nth_element(values, values.begin() + std::ptrdiff_t(values.size() / 2));
    return values[values.size() / 2];
  };
  if (values.empty()) return;
  Vector3 centre;
  for (int k = 0; k < 3; ++k) centre[k] = middle([&](const Vector3& p) { return p[k]; });
  const double usual = middle([&](const Vector3& p) { return (p - centre).norm(); });
  for (const Triangle& triangle : mesh.triangles)
    for (const int v : triangle) {
      const Vector3& p = mesh.positions[v];
      require(!(usual > 0) || (p - centre).norm() <= stray * usual,
              fmt::format("{}: vertex {} is at ({:g}, {:g}, {:g}), {:.2g} times as far from the middle of the surface as "
                          "half of the vertices are: take it out, or correct it",
                          name, v, p.x(), p.y(), p.z(), (p - centre).norm() / usual));
    }
}

}  // namespace

CapturedFrame::CapturedFrame(const FrameLoader& loader, int frame, const Mesh* before,
                             const CaptureOptions& options)
    : loader_(loader), frame_(frame), options_(options), model_(loader.read(frame)),
      of_file_{model_.mesh.positions.size(), model_.mesh.triangles.size()} {
  require_no_stray(model_.mesh, loader_.name(frame_));
  Oriented found = oriented(model_.mesh, before);
  model_.mesh = std::move(found.mesh);
  turned_ = std::move(found.turned);
  std::ranges::move(found.defects, std::back_inserter(model_.defects));
  cut_long_triangles();
  const bool coloured = options_.colours == CaptureOptions::Colours::used;
  target_ = std::make_unique<TrackTarget>(model_.mesh, coloured ? vertex_colours(model_) : Signal(),
                                          of_file());
}

int CapturedFrame::number() const { return loader_.number(frame_); }

void CapturedFrame::cut_long_triangles() {
  const Surface surface = make_surface(model_.mesh, {.kind = WeldOptions::Kind::none});
  const double most = options_.longest_edge * std::sqrt(surface.area);
  if (!(most > 0) || mean_edge_length(surface) <= most) return;
  RefinedMesh fine = refined(model_.mesh, most);
  model_.colors.values = values_at(fine.places, model_.mesh, model_.colors);
  uncut_ = std::move(model_.mesh.triangles);
  model_.mesh = std::move(fine.mesh);
  places_ = std::move(fine.places);
}

/// 1 per vertex of the file; empty: all are.
std::vector<char> CapturedFrame::of_file() const {
  std::vector<char> result;
  for (const SurfacePoint& place : places_) result.push_back(place.barycentric.maxCoeff() == 1);
  return result;
}

Defects CapturedFrame::defects() const {
  Defects all = model_.defects;
  std::ranges::copy(target_->defects(), std::back_inserter(all));
  return all;
}

const MaterialFrame& CapturedFrame::truth() {
  if (!truth_) truth_ = read_truth();
  return *truth_;
}

double CapturedFrame::truth_tolerance() {
  return options_.truth == Truth::uvs
             ? uv_tolerance
             : material_tolerance * bounding_box(truth().material).diagonal();
}

MaterialFrame CapturedFrame::read_truth() const {
  if (options_.truth == Truth::uvs) {
    require(model_.mesh.has_uvs(),
            fmt::format("{} uv wants texture coordinates, and it has none", option_name("truth")));
    return material_from_uvs(model_.mesh);
  }
  Mesh material = loader_.material(frame_);
  const std::vector<Triangle>& wanted = uncut_.empty() ? model_.mesh.triangles : uncut_;
  // Of triangles that were turned it may be turned as they were, or not.
  if (material.triangles.size() == wanted.size() && material.triangles != wanted)
    material = with_flipped(std::move(material), turned_);
  require(material.triangles == wanted,
          fmt::format("{}: its triangles are not those of {}", loader_.material_name(frame_),
                      loader_.name(frame_)));
  if (uncut_.empty()) return {model_.mesh, std::move(material)};
  Mesh cut = model_.mesh;
  for (std::size_t v = 0; v < cut.positions.size(); ++v)
    cut.positions[v] = point_at(material, places_[v]);
  return {model_.mesh, std::move(cut)};
}

/// What stayed has the material that its triangles' corners have; what moved that of where it is.
std::vector<Vector3> CapturedFrame::template_material(const Remeshed& tidy) {
  const Mesh &clean = target_->surface().mesh, &mesh = model_.mesh;
  std::vector<Vector3> before(clean.positions.size(), Vector3::Constant(nowhere));
  for (int t = 0; t < clean.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int source = target_->source_from_triangle()[t];
      if (options_.truth != Truth::uvs)
        before[clean.triangles[t][k]] = truth().material.position(source, k);
      else if (mesh.textured(source))
        before[clean.triangles[t][k]] = {mesh.uv(source, k).x(), mesh.uv(source, k).y(), 0};
    }
  const ClosestPointFinder nearest(truth().space);
  std::vector<Vector3> result;
  for (int v = 0; v < tidy.mesh.vertex_count(); ++v)
    if (const int stayed = tidy.template_vertices[v]; stayed >= 0)
      result.push_back(before[stayed]);
    else
      result.push_back(point_at(truth().material, nearest(tidy.mesh.positions[v])));
  return result;
}

TrackTemplate CapturedFrame::as_template(double step, int first_vertex_id, int first_triangle_id) {
  const Signal& colours = target_->colours();
  require(options_.colours == CaptureOptions::Colours::left || colours.size() > 0,
          option_name("colours") + " wants colours at vertices or a texture, and it has neither");
  const Surface& surface = target_->surface();
  const Remeshed tidy = tidied(SearchedSurface{surface, target_->closest()});
  // What moved has the colours of where it is now.
  Signal tidy_colours(colours.size() > 0 ? tidy.mesh.vertex_count() : 0, colours.cols());
  for (int v = 0; v < tidy_colours.rows(); ++v) {
    const VertexOrigin& origin = tidy.origins[v];
    const Triangle& corners = surface.mesh.triangles[origin.triangle];
    tidy_colours.row(v) =
        interpolate(origin.barycentric, [&](int k) { return colours.row(corners[k]); });
  }
  const std::vector<Vector3> material =
      has_truth() ? template_material(tidy) : std::vector<Vector3>();
  Mesh mesh = tidy.mesh;
  mesh.positions = rounded(unfolded_onto(*target_, mesh), step);
  return new_template(mesh, tidy_colours, material, first_vertex_id, first_triangle_id);
}

}  // namespace mq
