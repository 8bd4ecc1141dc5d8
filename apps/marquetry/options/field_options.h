#pragma once
/// The vector field that --field names.

#include "mq/model/model_field.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --field, --number, --turned and --strength; `strength` is the default, "unit" or, with no --field by default, "kept".
void add_field_options(OptionTable& table, const std::string& strength = "unit");

/// Adds --field, which is nothing by default, --number, --turned and --kappa with this default; "`what` along a field".
void add_direction_options(OptionTable& table, const std::string& group, const std::string& what, const std::string& kappa);

/// The signal's unknowns with distances across that field made longer (`ModelSignal::space_across`); null: none was named.
std::unique_ptr<SignalSpace> asked_space_along(Run& run, const TexturedModel& model, const ModelSignal& signal,
                                               const Progress& progress);

FieldRequest asked_request(const OptionValues& options, const TexturedModel& model);

/// `model_field`, with what the report should say of it.
ModelField found_field(Run& run, const TexturedModel& model, const ModelSignal& signal, const FieldRequest& request,
                       const Progress& progress);

}  // namespace mq::app
