#include "options/field_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "options/signal_options.h"
#include "mq/io/file_names.h"
#include "mq/io/vector_field.h"

namespace mq::app {
namespace {

bool names_strokes(const std::string& name) { return name.ends_with(".json"); }
bool names_file(const std::string& name) {
  return names_vector_field(name) || names_strokes(name) || names_picture(name);
}

constexpr const char* known[] = {"max-curvature", "min-curvature", "harmonic", "gradient"};

/// How --field is asked for.
struct FieldNaming {
  std::string usual = {};  ///< the default; empty: none
  char letter = '\0';
  bool required = false;
};

/// --field and what goes with it.
void add_naming_options(OptionTable& table, const FieldNaming& naming, const std::string& group, const std::string& help) {
  using Type = Option::Type;
  table.add(
      {.name = "field",
       .letter = naming.letter,
       .type = Type::text,
       .default_value = naming.usual,
       .required = naming.required,
       .choices = {std::begin(known), std::end(known)},
       .accepts =
           [](const std::string& text) {
             return names_file(text) || std::ranges::count(known, text) > 0;
           },
       .wanted = "max-curvature, min-curvature, harmonic, gradient, a file .vf, .ply or .json, or a map: a picture",
       .metavar = "FIELD",
       .group = group,
       .help = help,
       .details =
           "Curvatures: the principal directions, as strong as the two differ. harmonic: "
           "a field without curl and divergence, see --number. gradient: of the textures' "
           "brightness, or of that of the colours at vertices; turned it is the default for a picture. A .vf file holds a 32-bit count "
           "of triangles and two doubles for each, along its first two edges from its first "
           "corner; a .ply file has vx, vy, vz at its vertices or faces. A .json file holds strokes, "
           "{\"strokes\": [{\"points\": [[x, y, z], ...]}]} or \"uv\": [[u, v], ...]: the field is the smoothest "
           "along them. A picture is a map of directions in tangent space, as fields writes it; with %s in its name one for each texture."});
  table.add({.name = "number",
             .type = Type::integer,
             .default_value = "1",
             .least = 1,
             .most = 100000,
             .group = group,
             .help = "which of the harmonic fields, of which there are twice the genus"});
  table.add({.name = "turned", .group = group, .help = "the field turned by 90 degrees"});
}

/// What --field, --number and --turned say.
FieldRequest named_request(const OptionValues& options) {
  using Kind = FieldRequest::Kind;
  const std::string name = options.text("field");
  FieldRequest request{.kind = name == "max-curvature"   ? Kind::max_curvature
                               : name == "min-curvature" ? Kind::min_curvature
                               : name == "harmonic"      ? Kind::harmonic
                               : name == "gradient"      ? Kind::gradient
                               : names_strokes(name)     ? Kind::strokes
                               : names_picture(name)     ? Kind::map
                                                         : Kind::file,
                       .number = int(options.integer("number"))};
  if (names_file(name)) request.file = name;
  if (options.flag("turned")) request.turn = FieldRequest::Turn::quarter;
  return request;
}

}  // namespace

void add_field_options(OptionTable& table, const std::string& strength) {
  const bool kept = strength == "kept";
  add_naming_options(table, kept ? FieldNaming{{}, 'f', true} : FieldNaming{"max-curvature", 'f', false}, "Field",
                     "max-curvature, min-curvature, harmonic, gradient, or a file");
  table.add({.name = "strength",
             .type = Option::Type::choice,
             .default_value = strength,
             .choices = kept ? std::vector<std::string>{"kept", "scaled", "unit"} : std::vector<std::string>{"unit", "scaled"},
             .group = "Field",
             .help = kept ? "kept: as it is; scaled: its strongest tenth becomes 1; unit: 1 everywhere"
                          : "unit: lines equally clear everywhere; scaled: they fade where the field is weak"});
}

void add_direction_options(OptionTable& table, const std::string& group, const std::string& what, const std::string& kappa) {
  add_naming_options(table, {}, group, what + " along a field: max-curvature, min-curvature, harmonic, gradient, or a file");
  table.add({.name = "kappa",
             .type = Option::Type::number,
             .default_value = kappa,
             .least = 0,
             .most = 10000,
             .group = group,
             .help = "how many times less far across the field, where that is strong"});
}

std::unique_ptr<SignalSpace> asked_space_along(Run& run, const TexturedModel& model, const ModelSignal& signal,
                                               const Progress& progress) {
  const OptionValues& options = run.options();
  if (!options.has("field")) {
    for (const char* name : {"number", "turned", "kappa"})
      require(!asks_for(options, name), fmt::format("--{} is of a field: name one with --field", name));
    return nullptr;
  }
  const ModelField found = found_field(run, model, signal, named_request(options), progress.step("field", 0.4));
  return signal.space_across(found.field, options.number("kappa"), progress.step("metric", 0.6));
}

FieldRequest asked_request(const OptionValues& options, const TexturedModel& model) {
  FieldRequest request = named_request(options);
  // A picture is flat: without --field its lines run along its edges.
  if (model.is_picture && !options.given("field")) {
    request.kind = FieldRequest::Kind::gradient;
    request.turn = options.flag("turned") ? FieldRequest::Turn::none : FieldRequest::Turn::quarter;
  }
  const std::string strength = options.text("strength");
  if (strength == "unit") request.strength = FieldRequest::Strength::unit;
  if (strength == "kept") request.strength = FieldRequest::Strength::kept;
  return request;
}

ModelField found_field(Run& run, const TexturedModel& model, const ModelSignal& signal, const FieldRequest& request,
                       const Progress& progress) {
  ModelField found = model_field(model, signal, request, progress);
  if (found.harmonic_fields) run.result["harmonic_fields"] = *found.harmonic_fields;
  return found;
}

}  // namespace mq::app
