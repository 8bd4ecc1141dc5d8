// marquetry fields MESH [TEXTURE...] --field FIELD -o OUT: vector fields, designed by strokes, taken apart, and as maps.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "mq/base/error.h"
#include "mq/fem/hodge_parts.h"
#include "mq/io/file_names.h"
#include "mq/io/vector_field.h"
#include "mq/mesh/geometry.h"
#include "mq/model/field_map.h"
#include "options/field_options.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// Where results go.
struct FieldOutputs {
  std::optional<Outputs> maps;
  fs::path vectors;                ///< of one field
  fs::path folder;                 ///< of everything
  std::vector<fs::path> in_folder; ///< the field, its three parts, u and v

  std::vector<fs::path> paths() const {
    if (maps) return maps->paths();
    return folder.empty() ? std::vector{vectors} : in_folder;
  }
};

FieldOutputs asked_outputs(const OptionValues& options, const TexturedModel& scene) {
  const std::string name = options.text("output");
  FieldOutputs outputs;
  if (names_vector_field(name)) {
    outputs.vectors = name;
  } else if (names_picture(name)) {
    require(!works_at_vertices(options, scene),
            fmt::format("--output: found '{}', a picture, and what is worked on are vertices ({}): wanted .ply or .vf", name,
                        options.flag("vertices") ? "--vertices" : "the model has no texture coordinates"));
    outputs.maps.emplace(name, scene.model, Outputs::Kind::pictures);
  } else {
    require(!names_model(name) && fs::path(name).extension().empty(),
            fmt::format("--output: found '{}', wanted .ply or .vf for vectors, a picture for a map of them, or a folder "
                        "for all parts", name));
    require(options.text("part") == "whole", "--part is for one file; a folder gets all parts");
    outputs.folder = name;
    for (const char* what : {"whole", "gradient", "curl", "harmonic", "potential", "stream"})
      outputs.in_folder.push_back(outputs.folder / fmt::format("{}_{}.ply", scene.model.path.stem().string(), what));
  }
  return outputs;
}

double energy(const Surface& surface, const TangentField& field) {
  double sum = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    sum += triangle_area(surface.mesh, t) * field[std::size_t(t)].squaredNorm();
  return sum;
}

void report(Run& run, const Surface& surface, const TangentField& field, const HodgeParts& parts) {
  const double whole = energy(surface, field);
  Json shares = Json::object();
  std::string text;
  for (const auto& [name, part] : {std::pair{"gradient", &parts.gradient}, {"curl", &parts.curl}, {"harmonic", &parts.harmonic}}) {
    const double share = whole > 0 ? energy(surface, *part) / whole : 0;
    shares[name] = share;
    text += fmt::format("{:>9} {:6.2f} %\n", name, 100 * share);
  }
  run.result["shares"] = shares;
  run.print(text);
}

const TangentField& part_of(const HodgeParts& parts, const std::string& name) {
  return name == "gradient" ? parts.gradient : name == "curl" ? parts.curl : parts.harmonic;
}

/// Values at the vertices of the surface, at those of the file.
std::vector<double> at_file_vertices(const Surface& surface, const Vector& values) {
  std::vector<double> result(surface.vertex_from_source.size(), 0.0);
  for (std::size_t v = 0; v < result.size(); ++v)
    if (const int own = surface.vertex_from_source[v]; own >= 0) result[v] = values[own];
  return result;
}

void write_folder(Run& run, const TexturedModel& scene, const FieldOutputs& outputs, const TangentField& field,
                  const HodgeParts& parts) {
  const Mesh& mesh = scene.model.mesh;
  const std::vector<fs::path>& to = outputs.in_folder;
  write_vector_field(to[0], mesh, field);
  write_vector_field(to[1], mesh, parts.gradient);
  write_vector_field(to[2], mesh, parts.curl);
  write_vector_field(to[3], mesh, parts.harmonic);
  write_vertex_values(to[4], mesh, at_file_vertices(scene.surface, parts.potential));
  write_vertex_values(to[5], mesh, at_file_vertices(scene.surface, stream_at_vertices(scene.surface, parts)));
  say_written(run, to);
}

/// What is worth knowing of a field before its parts or a map are believed.
void say_of_signs(Run& run, const FieldRequest& request) {
  using Kind = FieldRequest::Kind;
  if (request.kind == Kind::max_curvature || request.kind == Kind::min_curvature)
    run.terminal().remark("directions of curvature have no sign: neighbours may point opposite ways, which means over "
                          "texels and the parts of the field show");
}

/// Unknowns for what needs them: texels where the texture counts, else vertices, which cost nothing.
std::unique_ptr<ModelSignal> signal_for(Run& run, const TexturedModel& scene, const FieldRequest& request, bool map) {
  using Kind = FieldRequest::Kind;
  const bool in_texels = request.kind == Kind::strokes || request.kind == Kind::map, gradient = request.kind == Kind::gradient;
  if (!map && !in_texels && !gradient) return std::make_unique<VertexColourSignal>(scene);
  const Step step(run, "assemble", 0.3);
  using Pictures = TextureSignalOptions::Pictures;
  return make_field_signal(run, scene, step, TextureSignalOptions::SharedTexels::one_unknown,
                           gradient ? Pictures::read : Pictures::replaced);
}

Exit fields(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::assume, 0.1, {}, ImageTriangles::per_pixel);
  const FieldOutputs outputs = asked_outputs(options, scene);
  if (outputs.maps)
    run.will_write(outputs.maps->paths(), outputs.maps->folders());
  else
    run.will_write(outputs.paths(), outputs.folder);
  const FieldRequest request = asked_request(options, scene);
  check_field(scene, request);
  if (run.dry_run()) return Exit::done;

  const std::unique_ptr<ModelSignal> signal = signal_for(run, scene, request, outputs.maps.has_value());
  const std::string part = options.text("part");
  ModelField field;
  HodgeParts parts;
  FieldMap map;
  about(scene.model, [&] {
    {
      const Step step(run, "field", 0.3);
      field = found_field(run, scene, *signal, request, step);
    }
    if (part != "whole" || !outputs.folder.empty()) {
      const Step step(run, "take apart", 0.3);
      parts = hodge_parts(scene.surface, field.field, step);
      report(run, scene.surface, field.field, parts);
      if (part != "whole") {
        constexpr double rounding = 1e-12;  // of squares
        if (!(run.result["shares"][part].get<double>() > rounding))
          run.terminal().remark(fmt::format("the {} part of the field is 0: what is written of it is rounding", part));
        field = {part_of(parts, part), {}, {}};
      }
    }
    if (outputs.maps) map = field_map(scene, *signal, field);
  });
  if (outputs.maps || !outputs.folder.empty() || part != "whole") say_of_signs(run, request);
  const double beyond = map.values.rows() > 0 ? 100 * double(map.beyond) / double(map.values.rows()) : 0;
  const bool numbers = outputs.maps && holds_numbers(outputs.maps->paths().front());
  if (beyond >= 0.05 && !numbers)
    run.terminal().remark(fmt::format("{:.1f} % of the texels have vectors longer than 1, which blue cannot say: --strength "
                                      "scaled brings them to scale, and .exr holds them", beyond));
  const Step step(run, "write", 0.1);
  if (outputs.maps) {
    if (!numbers) map.values.col(2) = map.values.col(2).cwiseMin(1.0);
    signal->replace(map.values, numbers ? Depth::f32 : Depth::u16, scene.model);
    write_outputs(run, *outputs.maps, std::move(scene.model), step);
  } else if (!outputs.folder.empty()) {
    write_folder(run, scene, outputs, field.field, parts);
  } else {
    write_vector_field(outputs.vectors, scene.model.mesh, field.field);
    say_written(run, {outputs.vectors});
  }
  return Exit::done;
}

}  // namespace

Verb fields_verb() {
  using Type = Option::Type;
  OptionTable table("fields",
                    "Vector fields on the surface: the smoothest along strokes, curvature, harmonic or a file's; taken "
                    "apart into gradient, curl and harmonic part; as files or as maps for shaders.");
  table.example("scan.obj --field strokes.json -o combed.ply", "the smoothest field along the strokes, for lic or Blender");
  table.example("scan.obj --field strokes.json -o anisotropy.png", "the same as an anisotropy or flow map of its texture");
  table.example("scan.obj --field wind.ply -o parts/", "its Helmholtz-Hodge decomposition");
  add_model_options(table);
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .group = "Output",
             .help = ".ply or .vf for vectors, a picture for a map of them, or a folder for all parts",
             .details = "A .ply has vx, vy, vz at its faces, as lic --field takes it. A map has the direction in tangent "
                        "space in red and green and the length in blue, as KHR_materials_anisotropy of glTF means them. "
                        "A folder gets NAME_whole.ply, NAME_gradient.ply, NAME_curl.ply, NAME_harmonic.ply, and the "
                        "potential and the stream function as quality at vertices, NAME_potential.ply and "
                        "NAME_stream.ply."});
  add_field_options(table, "kept");
  table.add({.name = "part",
             .type = Type::choice,
             .default_value = "whole",
             .choices = {"whole", "gradient", "curl", "harmonic"},
             .group = "Field",
             .help = "which part of it: gradient (no curl), curl (no divergence), or harmonic (neither)"});
  add_vertices_option(table, "a vector per vertex through strokes, and the gradient of colours there");
  return {table, fields, {{.what = "vector fields"}}};
}

}  // namespace mq::app
