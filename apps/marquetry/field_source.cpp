#include "field_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/image/colour.h"
#include "mq/io/vector_field.h"
#include "mq/mesh/geometry.h"

namespace mq::app {
namespace {

TangentField harmonic(Run& run, const Scene& scene, const Progress& progress) {
  std::vector<TangentField> fields = harmonic_fields(scene.surface, progress);
  run.result["harmonic_fields"] = fields.size();
  require(!fields.empty(),
          "--field harmonic: a surface without handles has none, and neither has one "
          "with a single boundary");
  const std::int64_t number = run.options().integer("number");
  require(number <= std::ssize(fields), fmt::format("--number {}: there are {}", number,
                                                    counted(std::ssize(fields), "harmonic field")));
  return fields[std::size_t(number - 1)];
}

/// Mean of the colour channels: pictures of one model may have grey, colours and alpha as they like.
Image<float> brightness(const Image<float>& picture) {
  Image<float> grey(picture.width(), picture.height(), 1);
  const int colours = colour_channels(picture.channels());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto pixel = picture.pixel(x, y).first(std::size_t(colours));
      grey(x, y) = std::accumulate(pixel.begin(), pixel.end(), 0.0F) / float(colours);
    }
  return grey;
}

/// Mean of the colour channels of the textures, or of the colours, at the vertices of the surface.
Vector brightness(const Scene& scene, const Domain& domain) {
  const Mesh& mesh = scene.surface.mesh;
  Vector values = Vector::Zero(mesh.vertex_count());
  if (const auto* texels = dynamic_cast<const TexelDomain*>(&domain)) {
    std::vector<Image<float>> pictures;
    for (const Texture& texture : scene.model.textures)
      pictures.push_back(brightness(texture.pixels));
    require(std::ssize(pictures) == std::ssize(scene.texture_sizes) &&
                std::ranges::none_of(pictures, &Image<float>::empty),
            "--field gradient: the model lacks a picture to take the gradient of");
    const Signal signal = texels->space().gather(pictures);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      if (scene.atlas->chart[t] < 0) continue;
      for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (const TexelWeight& w : texels->space().basis_at(t, Vector3::Unit(k)))
          sum += w.weight * signal(w.texel, 0);
        values[mesh.triangles[t][k]] = sum;
      }
    }
    return values;
  }
  const VertexSignal& colors = scene.model.colors;
  require(colors.channels > 0,
          "--field gradient: there are neither textures nor colours at vertices");
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int c = 0; c < colour_channels(colors.channels); ++c)
      values[v] +=
          colors.values[std::size_t(scene.surface.source_from_vertex[v]) * colors.channels + c];
  return values;
}

/// ∇ψ, 0 in triangles where ψ varies by no more than what it is rounded to.
TangentField gradient(const Scene& scene, const Vector& psi) {
  constexpr double rounding = 1e-6;
  const Surface& surface = scene.surface;
  TangentField field = gradient_field(surface, psi);
  const double least = rounding * psi.cwiseAbs().maxCoeff();
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Triangle& v = surface.mesh.triangles[t];
    const auto [low, high] = std::minmax({psi[v[0]], psi[v[1]], psi[v[2]]});
    if (!(high - low > least)) field[t].setZero();
  }
  return field;
}

TangentField from_file(const Scene& scene, const std::string& file) {
  VectorField field = read_vector_field(file, scene.model.mesh);
  const Surface& surface = scene.surface;
  if (field.at == VectorField::At::triangles) {
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 n = triangle_normal(surface.mesh, t);
      field.vectors[t] =
          n.isZero() ? Vector3::Zero() : Vector3(field.vectors[t] - n.dot(field.vectors[t]) * n);
    }
    return std::move(field.vectors);
  }
  std::vector<Vector3> vertices;
  for (const int source : surface.source_from_vertex)
    vertices.push_back(field.vectors[std::size_t(source)]);
  return field_from_vertices(surface, vertices);
}

bool names_file(const std::string& name) { return name.ends_with(".vf") || name.ends_with(".ply"); }

constexpr const char* known[] = {"max-curvature", "min-curvature", "harmonic", "gradient"};

}  // namespace

void add_field_options(OptionTable& table) {
  using Type = Option::Type;
  table.add(
      {.name = "field",
       .letter = 'f',
       .type = Type::text,
       .default_value = "max-curvature",
       .choices = {std::begin(known), std::end(known)},
       .accepts =
           [](const std::string& text) {
             return names_file(text) || std::ranges::count(known, text) > 0;
           },
       .wanted = "max-curvature, min-curvature, harmonic, gradient, or a file .vf or .ply",
       .metavar = "FIELD",
       .group = "Field",
       .help = "max-curvature, min-curvature, harmonic, gradient, or a file",
       .details =
           "Curvatures: the principal directions, as strong as the two differ. harmonic: "
           "a field without curl and divergence, see --number. gradient: of the textures' "
           "brightness, or of that of the colours at vertices. A .vf file holds a 32-bit count "
           "of triangles and two doubles for each, along its first two edges from its first "
           "corner; a .ply file has vx, vy, vz at its vertices or faces."});
  table.add({.name = "number",
             .type = Type::integer,
             .default_value = "1",
             .least = 1,
             .most = 100000,
             .group = "Field",
             .help = "which of the harmonic fields, of which there are twice the genus"});
  table.add({.name = "turned", .group = "Field", .help = "the field turned by 90 degrees"});
  table.add({.name = "strength",
             .type = Type::choice,
             .default_value = "scaled",
             .choices = {"scaled", "unit"},
             .group = "Field",
             .help = "scaled: lines fade where the field is weak; unit: equally clear everywhere"});
}

void check_field(const OptionValues& options, const Scene& scene) {
  const std::string name = options.text("field");
  if (names_file(name)) read_vector_field(name, scene.model.mesh);
}

TangentField asked_field(Run& run, const Scene& scene, const Domain& domain,
                         const Progress& progress) {
  const std::string name = run.options().text("field");
  const Surface& surface = scene.surface;
  TangentField field =
      name == "max-curvature"   ? curvature_field(surface, Principal::max, 2, progress)
      : name == "min-curvature" ? curvature_field(surface, Principal::min, 2, progress)
      : name == "harmonic"      ? harmonic(run, scene, progress)
      : name == "gradient"      ? gradient(scene, brightness(scene, domain))
                                : from_file(scene, name);
  if (run.options().flag("turned"))
    for (int t = 0; t < surface.triangle_count(); ++t)
      field[t] = triangle_normal(surface.mesh, t).cross(field[t]);
  require(std::ranges::any_of(field, [](const Vector3& v) { return !v.isZero(0); }),
          "--field " + name + ": it is 0 everywhere");
  return run.options().text("strength") == "unit" ? normalised(surface, std::move(field))
                                                  : scaled_to_one(surface, std::move(field));
}

}  // namespace mq::app
