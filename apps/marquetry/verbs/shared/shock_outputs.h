#pragma once
/// What `shock` writes beside its result: the potential P that paths run down, and −∇P, along which they run.

#include <filesystem>
#include <optional>
#include <vector>

#include "mq/model/model_field.h"
#include "mq/model/outputs.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --write-potential and --write-field.
void add_shock_output_options(OptionTable& table);

class ShockOutputs {
 public:
  enum class At { texels, vertices };

  /// Says which files will be written. Throws `InvalidInput` where names do not fit what is worked on, where one of
  /// them is among `results`, and for several slots, of which each would write the same.
  ShockOutputs(Run& run, const Model& model, At at, const std::vector<std::filesystem::path>& results);

  bool wanted() const { return potential_ || vectors_ || map_ || !values_.empty(); }

  /// Writes them; the potential has a value per unknown of the signal. The model must not have changed yet.
  void write(Run& run, const TexturedModel& scene, const ModelSignal& signal, const Vector& potential) const;

  /// The same for a picture, row by row.
  void write(Run& run, const Model& picture, const std::vector<double>& potential) const;

  /// Adds them to the result's "outputs".
  void report(Run& run) const;

 private:
  std::vector<std::filesystem::path> potential_paths() const;
  std::vector<std::filesystem::path> field_paths() const;
  std::vector<std::filesystem::path> paths() const;  ///< all
  void write_potential(Run& run, const TexturedModel& scene, const ModelSignal& signal, const Vector& potential) const;

  std::optional<Outputs> potential_, map_;          ///< pictures
  std::filesystem::path values_;                    ///< the potential at vertices
  std::optional<std::filesystem::path> vectors_;
};

}  // namespace mq::app
