#include "spaces.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>

#include "calls.h"
#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/fem/image_space.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/direct_solver.h"
#include "parts.h"

namespace mq::python {
namespace {

WeldOptions weld_of(const py::object& weld) {
  if (py::isinstance<py::str>(weld)) {
    const auto word = weld.cast<std::string>();
    if (word == "exact") return {};
    if (word == "none") return {.kind = WeldOptions::Kind::none};
    throw InvalidInput("weld: found '" + word + "', wanted 'exact', 'none' or a distance");
  }
  return {.kind = WeldOptions::Kind::distance, .distance = weld.cast<double>()};
}

AtlasOptions::Flipped flipped_of(const std::string& word) {
  if (word == "few") return AtlasOptions::Flipped::few;
  if (word == "refuse") return AtlasOptions::Flipped::refuse;
  if (word == "keep") return AtlasOptions::Flipped::keep;
  throw InvalidInput("flipped: found '" + word + "', wanted 'few', 'refuse' or 'keep'");
}

py::list list_of(const Defects& defects) {
  static constexpr const char* severities[] = {"note", "warning", "refused"};
  py::list all;
  for (const Defect& defect : defects) {
    py::dict one;
    one["kind"] = defect.kind;
    one["severity"] = severities[int(defect.severity)];
    one["element"] = defect.element;
    one["count"] = defect.count;
    one["ids"] = defect.ids;
    one["message"] = sentence(defect);
    py::list places;
    for (const Defect::Place& place : defect.places) {
      py::dict at;
      at["texture"] = place.texture;
      at["column"] = place.column;
      at["row"] = place.row;
      at["texels"] = place.texels;
      places.append(at);
    }
    one["places"] = places;
    all.append(one);
  }
  return all;
}

/// The space of a mesh's texels with all that it refers to.
struct TexelDomain {
  Surface surface;
  Atlas atlas;
  std::unique_ptr<TexelSpace> space;
};

class Texelled {
 public:
  explicit Texelled(std::shared_ptr<TexelDomain> domain)
      : domain_(std::move(domain)), space_(domain_, domain_->space.get()),
        textures_(domain_->atlas.textures), chart_(domain_->atlas.chart) {}
  explicit Texelled(std::shared_ptr<ImageSpace> image)
      : space_(image), textures_(image->sheet().atlas.textures), chart_(image->sheet().atlas.chart) {}

  const std::shared_ptr<TexelSpace>& space() const { return space_; }
  const std::vector<TextureSize>& textures() const { return textures_; }
  const std::vector<int>& chart() const { return chart_; }
  Defects defects() const {
    Defects all;
    if (domain_)
      for (const Defects* some : {&domain_->surface.defects, &domain_->atlas.defects})
        all.insert(all.end(), some->begin(), some->end());
    all.insert(all.end(), space_->defects().begin(), space_->defects().end());
    return all;
  }

 private:
  std::shared_ptr<TexelDomain> domain_;
  std::shared_ptr<TexelSpace> space_;
  std::vector<TextureSize> textures_;
  std::vector<int> chart_;
};

Texelled texel_space(const py::array& vertices, const py::array& faces, const py::array& uvs,
                     const py::object& textures, const std::vector<std::pair<int, int>>& sizes,
                     const py::object& weld, const std::string& flipped, const py::object& progress) {
  const Mesh mesh = mesh_from(vertices, faces, uvs, textures);
  std::vector<TextureSize> wanted;
  for (const auto& [width, height] : sizes) {
    require(width > 0 && height > 0 && width <= max_picture_side && height <= max_picture_side,
            fmt::format("sizes: found {} x {}, wanted 1 to {} texels a side", width, height, max_picture_side));
    wanted.push_back({width, height});
  }
  const WeldOptions welding = weld_of(weld);
  const AtlasOptions options{.flipped = flipped_of(flipped)};
  auto domain = std::make_shared<TexelDomain>();
  call(progress, [&](const Progress& inner) {
    domain->surface = make_surface(mesh, welding, inner.step("weld", 0.1));
    domain->atlas = make_atlas(domain->surface, wanted, options, inner.step("charts", 0.1));
    domain->space = std::make_unique<TexelSpace>(domain->surface, domain->atlas, TexelSpaceOptions{},
                                                 inner.step("assemble", 0.8));
  });
  return Texelled(domain);
}

Texelled image_space(int width, int height, const py::object& progress) {
  require(width > 0 && height > 0 && width <= max_picture_side && height <= max_picture_side,
          fmt::format("size: found {} x {}, wanted 1 to {} pixels a side", width, height, max_picture_side));
  std::shared_ptr<ImageSpace> space;
  call(progress, [&](const Progress& inner) { space = std::make_shared<ImageSpace>(width, height, inner); });
  return Texelled(space);
}

/// One for each texture, of its size.
std::vector<PictureView> views_of(const Texelled& texelled, const std::vector<py::array>& pictures) {
  const std::vector<TextureSize>& sizes = texelled.textures();
  require(pictures.size() == sizes.size(), fmt::format("pictures: found {}, wanted one for each of {}",
                                                       pictures.size(), counted(std::ssize(sizes), "texture")));
  std::vector<PictureView> views;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    views.push_back(picture_from(pictures[i], "pictures"));
    require(views[i].width == sizes[i].width && views[i].height == sizes[i].height,
            fmt::format("pictures: picture {} is {} x {} (width x height), and the texture {} x {}", i,
                        views[i].width, views[i].height, sizes[i].width, sizes[i].height));
    require(views[i].channels == views[0].channels,
            fmt::format("pictures: found {} and {} channels, wanted the same of all", views[0].channels,
                        views[i].channels));
  }
  return views;
}

std::vector<Image<float>> images_of(const std::vector<PictureView>& views) {
  HeldFiles held;
  std::vector<Image<float>> images;
  for (const PictureView& view : views) {
    held.put("picture.png", view);
    images.push_back(read_texture(held.path("picture.png")).pixels);
  }
  return images;
}

py::array gather(const Texelled& texelled, const std::vector<py::array>& pictures) {
  const std::vector<PictureView> views = views_of(texelled, pictures);
  Signal signal;
  call(py::none(), [&](const Progress&) { signal = texelled.space()->gather(images_of(views)); });
  return array_of(std::move(signal), pictures.front().ndim() == 2);
}

py::list scatter(const Texelled& texelled, const py::array& signal, const std::vector<py::array>& pictures) {
  const std::vector<PictureView> views = views_of(texelled, pictures);
  const SignalArray values = signal_from(signal, texelled.space()->size(), "signal");
  require(values.values.cols() == views.front().channels,
          fmt::format("signal: has {}, and the pictures {}", counted(values.values.cols(), "channel"),
                      views.front().channels));
  HeldFiles held;
  call(py::none(), [&](const Progress&) {
    std::vector<Image<float>> images = images_of(views);
    texelled.space()->scatter(values.values, images);
    for (std::size_t i = 0; i < images.size(); ++i) {
      Texture texture;
      texture.pixels = std::move(images[i]);
      texture.format.depth = views[i].depth;
      write_texture(held.path(fmt::format("{}.png", i)), texture);
    }
  });
  py::list all;
  for (std::size_t i = 0; i < views.size(); ++i)
    all.append(array_of(std::move(held.pictures().at(fmt::format("{}.png", i))))
                   .attr("reshape")(pictures[i].attr("shape")));
  return all;
}

py::array texels_of(const Texelled& texelled) {
  std::vector<int> values;
  for (const Texels::Place& place : texelled.space()->texels().places)
    values.insert(values.end(), {place.texture, place.x, place.y});
  return array_owning(std::move(values), {texelled.space()->size(), 3});
}

/// Values of all basis functions at points, a row each. `chart`: −1 where a triangle has no functions.
py::object basis_at(const SignalSpace& space, const py::array& faces, const py::array& barycentric,
                    std::int64_t face_count, const std::vector<int>* chart) {
  const std::vector<int> triangles = indices_from(faces, face_count, "faces");
  const SignalArray weights = signal_from(barycentric, std::ssize(triangles), "barycentric");
  require(!weights.flat && weights.values.cols() == 3, "barycentric: wanted three weights for each point");
  Entries entries;
  for (int i = 0; i < std::ssize(triangles); ++i) {
    const Vector3 b = weights.values.row(i).transpose();
    require(std::abs(b.sum() - 1) < 1e-6 && b.minCoeff() > -1e-9,
            fmt::format("barycentric: the weights of point {} are {}, {}, {}; wanted none below 0 and the sum 1",
                        i, b[0], b[1], b[2]));
    require(chart == nullptr || (*chart)[std::size_t(triangles[i])] >= 0,
            fmt::format("faces: face {} has no texels: no texture coordinates, or no area", triangles[i]));
    for (const BasisWeight& one : space.basis_at(triangles[i], b)) entries.emplace_back(i, one.unknown, one.weight);
  }
  return sparse_array(sparse_matrix(int(triangles.size()), space.size(), entries));
}

py::array edges_array(const std::vector<std::array<int, 2>>& edges) {
  std::vector<int> values;
  for (const auto& [i, j] : edges) values.insert(values.end(), {i, j});
  return array_owning(std::move(values), {py::ssize_t(edges.size()), 2});
}

/// (d₀ψ)_ij = ψ_j − ψ_i.
SparseMatrix differences(const std::vector<std::array<int, 2>>& edges, int size) {
  Entries entries;
  for (int e = 0; e < std::ssize(edges); ++e) {
    entries.emplace_back(e, edges[std::size_t(e)][0], -1.0);
    entries.emplace_back(e, edges[std::size_t(e)][1], 1.0);
  }
  return sparse_matrix(int(edges.size()), size, entries);
}

struct VertexDomain {
  Surface surface;
  std::unique_ptr<VertexSpace> space;
};

/// The space of a mesh's vertices.
class Vertices {
 public:
  explicit Vertices(std::shared_ptr<VertexDomain> domain) : domain_(std::move(domain)) {}
  Space space() const { return {domain_, domain_->space.get()}; }
  const VertexSpace& own() const { return *domain_->space; }
  const Surface& surface() const { return domain_->surface; }

 private:
  std::shared_ptr<VertexDomain> domain_;
};

Vertices vertex_space(const py::array& vertices, const py::array& faces, const py::object& weld) {
  const Mesh mesh = mesh_from(vertices, faces, py::none(), py::none());
  const WeldOptions welding = weld_of(weld);
  auto domain = std::make_shared<VertexDomain>();
  call(py::none(), [&](const Progress& inner) {
    domain->surface = make_surface(mesh, welding, inner);
    domain->space = std::make_unique<VertexSpace>(domain->surface);
  });
  return Vertices(domain);
}

/// Gᵀ·M₁: what `gradient_moments` computes.
SparseMatrix moments_matrix(const VertexSpace& space) {
  SparseMatrix G = space.gradient_matrix();
  for (int row = 0; row < G.rows(); ++row)
    for (SparseMatrix::InnerIterator at(G, row); at; ++at)
      at.valueRef() *= space.shapes()[std::size_t(row / 2)].area();
  return SparseMatrix(G.transpose());
}

// ---- What all spaces have ----

void add_matrices(py::class_<SignalSpace, Space>& bound) {
  bound.def_property_readonly("size", &SignalSpace::size)
      .def("system",
           [](const SignalSpace& space, double a, double b, const py::object& progress) {
             require(std::isfinite(a) && std::isfinite(b), "a, b: wanted finite numbers");
             SparseMatrix A;
             call(progress, [&](const Progress& inner) { A = space.system(a, b, inner); });
             return sparse_array(std::move(A));
           })
      .def("regularised_system",
           [](const SignalSpace& space, double a, double b, const py::object& progress) {
             require(std::isfinite(a) && std::isfinite(b), "a, b: wanted finite numbers");
             SparseMatrix A;
             call(progress, [&](const Progress& inner) { A = space.regularised_system(a, b, inner); });
             return sparse_array(std::move(A));
           })
      .def("weighted_system",
           [](const SignalSpace& space, double a, double b, const py::array& conductivity,
              const py::object& progress) {
             require(std::isfinite(a) && std::isfinite(b), "a, b: wanted finite numbers");
             const std::vector<float> c = floats_from(conductivity, space.element_count(), "conductivity");
             for (const float value : c) require(value >= 0, "conductivity: found a value below 0");
             SparseMatrix A;
             call(progress, [&](const Progress& inner) { A = space.weighted_system(a, b, c, inner); });
             return sparse_array(std::move(A));
           })
      .def("lumped_mass", [](const SignalSpace& space) {
        Vector mass;
        call(py::none(), [&](const Progress&) { mass = space.lumped_mass(); });
        return array_owning(std::vector<double>(mass.begin(), mass.end()), {mass.size()});
      });
}

void add_products(py::class_<SignalSpace, Space>& bound) {
  bound
      .def("stiffness_times",
           [](const SignalSpace& space, const py::array& psi, const py::object& beta) {
             const SignalArray values = signal_from(psi, space.size(), "psi");
             std::vector<double> factors;
             if (!beta.is_none()) factors = numbers_from(beta, space.size(), "beta");
             Signal result;
             call(py::none(), [&](const Progress&) { result = space.stiffness_times(values.values, factors); });
             return array_of(std::move(result), values.flat);
           })
      .def_property_readonly("element_count", &SignalSpace::element_count)
      .def("gradient_norms",
           [](const SignalSpace& space, const py::array& psi) {
             const SignalArray values = signal_from(psi, space.size(), "psi");
             std::vector<float> norms;
             call(py::none(), [&](const Progress&) { norms = space.gradient_norms(values.values); });
             const auto count = py::ssize_t(norms.size());
             return array_owning(std::move(norms), {count});
           })
      .def("weighted_stiffness_times",
           [](const SignalSpace& space, const py::array& psi, const py::array& conductivity) {
             const SignalArray values = signal_from(psi, space.size(), "psi");
             const std::vector<float> c = floats_from(conductivity, space.element_count(), "conductivity");
             Signal result;
             call(py::none(),
                  [&](const Progress&) { result = space.weighted_stiffness_times(values.values, c); });
             return array_of(std::move(result), values.flat);
           });
}

void add_places(py::class_<SignalSpace, Space>& bound) {
  bound.def_property_readonly("area", [](const SignalSpace& space) { return space.scale().area; })
      .def_property_readonly("texel_spacing",
                             [](const SignalSpace& space) { return space.scale().texel_spacing; })
      .def("weight",
           [](const SignalSpace& space, const std::string& length) {
             return weight_from_length(parse_length(length), space.scale());
           })
      .def("positions",
           [](const SignalSpace& space) {
             std::vector<double> values;
             for (const Vector3& p : space.positions()) values.insert(values.end(), {p[0], p[1], p[2]});
             return array_owning(std::move(values), {space.size(), 3});
           })
      .def("boundary", [](const SignalSpace& space) {
        std::vector<int> unknowns = space.boundary();
        const auto count = py::ssize_t(unknowns.size());
        return array_owning(std::move(unknowns), {count});
      });
}

void add_texel_space(py::module_& module) {
  py::class_<Texelled>(module, "TexelSpace")
      .def(py::init(&texel_space))
      .def_static("of_image", &image_space)
      .def_property_readonly("space", [](const Texelled& one) -> Space { return one.space(); })
      .def_property_readonly("sizes",
                             [](const Texelled& one) {
                               std::vector<std::pair<int, int>> sizes;
                               for (const TextureSize& size : one.textures())
                                 sizes.emplace_back(size.width, size.height);
                               return sizes;
                             })
      .def("gather", &gather)
      .def("scatter", &scatter)
      .def("texels", &texels_of)
      .def("defects", [](const Texelled& one) { return list_of(one.defects()); })
      .def("basis_at",
           [](const Texelled& one, const py::array& faces, const py::array& barycentric) {
             return basis_at(*one.space(), faces, barycentric, std::ssize(one.chart()), &one.chart());
           })
      .def("edges", [](const Texelled& one) { return edges_array(one.space()->edges()); })
      .def("gradient",
           [](const Texelled& one) { return sparse_array(differences(one.space()->edges(), one.space()->size())); })
      .def("divergence", [](const Texelled& one) {
        SparseMatrix D;
        call(py::none(),
             [&](const Progress&) { D = one.space()->edge_divergence_matrix(one.space()->edges()); });
        return sparse_array(std::move(D));
      });
}

void add_vertex_space(py::module_& module) {
  const auto ints = [](const std::vector<int>& values) {
    return array_owning(std::vector<int>(values), {py::ssize_t(values.size())});
  };
  py::class_<Vertices>(module, "VertexSpace")
      .def(py::init(&vertex_space))
      .def_property_readonly("space", &Vertices::space)
      .def("vertex_from_source", [=](const Vertices& one) { return ints(one.surface().vertex_from_source); })
      .def("source_from_vertex", [=](const Vertices& one) { return ints(one.surface().source_from_vertex); })
      .def("defects", [](const Vertices& one) { return list_of(one.surface().defects); })
      .def("basis_at",
           [](const Vertices& one, const py::array& faces, const py::array& barycentric) {
             return basis_at(one.own(), faces, barycentric, one.own().triangle_count(), nullptr);
           })
      .def("gradient", [](const Vertices& one) { return sparse_array(one.own().gradient_matrix()); })
      .def("divergence", [](const Vertices& one) { return sparse_array(moments_matrix(one.own())); });
}

}  // namespace

SolverFactory factory_of(const SignalSpace& space, const Solving& solving) {
  require(std::isfinite(solving.tolerance) && solving.tolerance > 0,
          fmt::format("tolerance: found {}, wanted a number above 0", solving.tolerance));
  require(solving.cycles >= 0, fmt::format("cycles: found {}, wanted 0 or more", solving.cycles));
  StoppingRule stop{.tolerance = solving.tolerance};
  if (solving.cycles > 0) stop.max_cycles = solving.cycles;
  if (solving.how == "automatic") return space.solver(stop);
  if (solving.how == "multigrid") return space.multigrid(stop);
  if (solving.how == "direct") return direct_solver();
  throw InvalidInput("solver: found '" + solving.how + "', wanted 'automatic', 'direct' or 'multigrid'");
}

py::dict report_of(const SolveReport& report) {
  py::dict made;
  made["method"] = report.method;
  made["cycles"] = report.cycles;
  made["residuals"] = report.residuals;
  made["converged"] = report.converged;
  made["error"] = report.error;
  made["setup_seconds"] = report.setup_seconds;
  made["solve_seconds"] = report.solve_seconds;
  return made;
}

void add_spaces(py::module_& module) {
  py::class_<SignalSpace, Space> bound(module, "Space");
  add_matrices(bound);
  add_products(bound);
  add_places(bound);
  add_texel_space(module);
  add_vertex_space(module);
}

}  // namespace mq::python
