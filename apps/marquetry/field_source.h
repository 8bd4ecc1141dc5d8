#pragma once
/// The vector field that --field names.

#include "domain.h"
#include "mq/fem/tangent_fields.h"

namespace mq::app {

/// Adds --field, --number and --turned.
void add_field_options(OptionTable& table);

/// Refuses a file that is not a field for this mesh, before any work. Throws `IoError`.
void check_field(const OptionValues& options, const Scene& scene);

/// The field on the triangles of the surface, and what the report should say of it. `domain` is for
/// fields of signals. Throws `InvalidInput` or `IoError` with the remedy where there is none.
TangentField asked_field(Run& run, const Scene& scene, const Domain& domain,
                         const Progress& progress);

}  // namespace mq::app
