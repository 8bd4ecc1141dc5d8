#include "options/field_options.h"

#include <algorithm>

#include "mq/base/error.h"

namespace mq::app {
namespace {

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
           "brightness, or of that of the colours at vertices; turned it is the default for a picture. A .vf file holds a 32-bit count "
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

FieldRequest asked_request(const OptionValues& options, const TexturedModel& model) {
  using Kind = FieldRequest::Kind;
  const std::string name = options.text("field");
  FieldRequest request{.kind = name == "max-curvature"   ? Kind::max_curvature
                               : name == "min-curvature" ? Kind::min_curvature
                               : name == "harmonic"      ? Kind::harmonic
                               : name == "gradient"      ? Kind::gradient
                                                         : Kind::file,
                       .number = int(options.integer("number"))};
  if (request.kind == Kind::file) request.file = name;
  if (options.flag("turned")) request.turn = FieldRequest::Turn::quarter;
  // A picture is flat: without --field its lines run along its edges.
  if (model.is_picture && !options.given("field")) {
    request.kind = Kind::gradient;
    request.turn = options.flag("turned") ? FieldRequest::Turn::none : FieldRequest::Turn::quarter;
  }
  if (options.text("strength") == "unit") request.strength = FieldRequest::Strength::unit;
  return request;
}

TangentField asked_field(Run& run, const TexturedModel& model, const ModelSignal& signal,
                         const Progress& progress) {
  ModelField found = model_field(model, signal, asked_request(run.options(), model), progress);
  if (found.harmonic_fields) run.result["harmonic_fields"] = *found.harmonic_fields;
  return std::move(found.field);
}

}  // namespace mq::app
