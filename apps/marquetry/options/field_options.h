#pragma once
/// The vector field that --field names.

#include "mq/model/model_field.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --field, --number, --turned and --strength.
void add_field_options(OptionTable& table);

FieldRequest asked_request(const OptionValues& options, const TexturedModel& model);

/// `model_field` of the request, with what the report should say of it.
TangentField asked_field(Run& run, const TexturedModel& model, const ModelSignal& signal,
                         const Progress& progress);

}  // namespace mq::app
