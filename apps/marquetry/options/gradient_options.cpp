#include "options/gradient_options.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/file_names.h"
#include "mq/io/vector_field.h"
#include "mq/model/target_gradient.h"
#include "options/field_options.h"

namespace mq::app {
namespace {

bool names_table(const std::string& name) { return lower_extension(name) == ".csv"; }

FieldRequest request_of(const std::string& name) {
  return {.kind = names_picture(name) ? FieldRequest::Kind::map : FieldRequest::Kind::file,
          .file = name,
          .strength = FieldRequest::Strength::kept};
}

/// β of ψ's own gradients: beside a field none, unless asked for; between places that a table does not name all.
double own_share(const OptionValues& options, double usual) {
  return options.has("beta") ? options.number("beta") : usual;
}

/// Maps without floating point hold no vectors longer than 1.
void warn_of_cut_lengths(Run& run, const std::string& name, const ModelField& field) {
  if (!names_picture(name) || holds_numbers(name)) return;
  constexpr double noticed = 0.01;
  Eigen::Index full = 0, count = field.texels.size() / 2;
  for (Eigen::Index i = 0; i < count; ++i) full += field.texels.segment<2>(2 * i).norm() > 0.999;
  if (double(full) > noticed * double(count))
    run.terminal().warning(fmt::format("{}: {:.0f} % of its vectors have the length 1, the most that 8 and 16 bits hold: gradients that "
                                       "were longer are cut; write it as .exr",
                                       name, 100.0 * double(full) / double(count)));
}

Signal moments_of_table(const OptionValues& options, const TexturedModel& model, const ModelSignal& signal, const Signal& psi,
                        const std::string& file) {
  EdgeDifferences table = read_edge_differences(file);
  for (double& value : table.values) value *= options.number("gradient-scale");
  const Eigen::Index colours = colour_channels(int(psi.cols()));
  if (table.channels != 1 && table.channels != colours)
    return gradient_moments(model, signal, psi, own_share(options, 1), table);
  Signal moments = signal.space().stiffness_times(psi);
  moments.leftCols(colours) = gradient_moments(model, signal, psi.leftCols(colours), own_share(options, 1), table);
  return moments;
}

}  // namespace

void add_gradient_options(OptionTable& table, const std::string& group) {
  table.add({.name = "gradient",
             .type = Option::Type::text,
             .count = Option::Count::many,
             .accepts = [](const std::string& name) {
               return names_table(name) || names_vector_field(name) || names_picture(name);
             },
             .wanted = "a file .vf, .ply or .csv, or a map of vectors: a picture",
             .metavar = "FIELD",
             .group = group,
             .help = "the gradients wanted, instead of the texture's own times a factor",
             .details =
                 "A field in changes of value per model unit of length, of all colour channels alike, or given once for each. "
                 "Files as of --field, vectors as long as they are (in maps of 8 and 16 bits 1 at most; .exr holds more). --beta adds the texture's own gradients times that, 0 "
                 "without it. A .csv file holds differences from texel to texel or vertex to vertex, "
                 "column,row,to_column,to_row,value under a first line that says so (texture,...,to_texture,... for several "
                 "textures; vertex,to_vertex,value), a value for all colour channels or one for each; places next to each other "
                 "that it does not name keep their own difference times --beta, 1 without it."});
  table.add({.name = "gradient-scale",
             .type = Option::Type::number,
             .default_value = "1",
             .least = -1e9,
             .most = 1e9,
             .group = group,
             .help = "factor on that field or those differences; below 0 it turns them round"});
}

void check_gradient(const OptionValues& options, const TexturedModel& model) {
  const std::vector<std::string> names = options.texts("gradient");
  for (const std::string& name : names) {
    if (!names_table(name)) {
      check_field(model, request_of(name));
      continue;
    }
    require(names.size() == 1, "--gradient: a .csv file says the differences of all channels: give it alone");
    read_edge_differences(name);
  }
}

Signal asked_gradient_moments(Run& run, const TexturedModel& model, const ModelSignal& signal, const Signal& psi,
                              const Progress& progress) {
  const OptionValues& options = run.options();
  const std::vector<std::string> names = options.texts("gradient");
  if (names_table(names.front())) return moments_of_table(options, model, signal, psi, names.front());
  const auto count = std::ssize(names);
  const Eigen::Index colours = colour_channels(int(psi.cols())), changed = count == psi.cols() ? count : colours;
  require(count == 1 || count == psi.cols() || count == colours,
          fmt::format("--gradient: given {} times, wanted once, or once for each of {} channels", count, psi.cols()));
  Signal moments = signal.space().stiffness_times(psi);
  moments.leftCols(changed) *= own_share(options, 0);
  Vector found;
  for (Eigen::Index c = 0; c < changed; ++c) {
    if (c < count) {
      const ModelField field = found_field(run, model, signal, request_of(names[std::size_t(c)]), progress);
      warn_of_cut_lengths(run, names[std::size_t(c)], field);
      found = options.number("gradient-scale") * gradient_moments(model, signal, field);
    }
    moments.col(c) += found;
  }
  return moments;
}

}  // namespace mq::app
