#pragma once
/// COLMAP's camera models: names, numbers in binary files, and what their parameters are.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mq/draw/pinhole.h"

namespace mq {

struct ColmapModel {
  const char* name;
  int id;
  Lens::Projection projection;
  std::vector<std::string> parameters;  ///< "f" (both focal lengths), "fx", "cx", ... or of `lens_numbers`
};

const std::vector<ColmapModel>& colmap_models();

/// Those of the name or the number. Throws `Unsupported` beginning with `where` for others.
const ColmapModel& colmap_model(const std::string& name, const std::string& where);
const ColmapModel& colmap_model(int id, const std::string& where);

void set_colmap_parameters(PinholeCamera& camera, const ColmapModel& model,
                           std::span<const double> values);

/// The simplest model that a camera is of. Throws `Unsupported` beginning with `where`.
const ColmapModel& colmap_model_of(const PinholeCamera& camera, const std::string& where);
std::vector<double> colmap_parameters(const PinholeCamera& camera, const ColmapModel& model);

}  // namespace mq
