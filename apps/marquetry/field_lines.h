#pragma once
/// What verbs that draw the lines of vector fields have in common.

#include <memory>

#include "domain.h"
#include "mq/fem/tangent_fields.h"

namespace mq::app {

/// The unknowns of the domain, with the metric in which places across the field are far apart.
std::unique_ptr<SignalSpace> space_across(const Scene& scene, const Domain& domain,
                                          const TangentField& field, double kappa,
                                          const Progress& progress);

}  // namespace mq::app
