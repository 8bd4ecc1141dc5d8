#include "mq/io/detail/colmap_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "mq/base/error.h"

namespace mq {
namespace {

/// What a parameter is of a camera.
double& parameter_of(PinholeCamera& camera, const std::string& name) {
  if (name == "f" || name == "fx") return camera.fx;
  if (name == "fy") return camera.fy;
  if (name == "cx") return camera.cx;
  if (name == "cy") return camera.cy;
  const auto numbers = lens_numbers();
  const auto found =
      std::ranges::find_if(numbers, [&](const LensNumber& number) { return name == number.name; });
  return camera.lens.*found->value;
}

ColmapModel model_from(const char* name, int id, Lens::Projection projection, const char* words) {
  ColmapModel model{name, id, projection, {}};
  std::istringstream text(words);
  for (std::string word; text >> word;) model.parameters.push_back(word);
  return model;
}

[[noreturn]] void refuse_model(const std::string& model, const std::string& where) {
  std::string known;
  for (const ColmapModel& one : colmap_models()) known += (known.empty() ? "" : ", ") + std::string(one.name);
  throw Unsupported(fmt::format("{}: the lens {} is not known here; undistort the pictures first "
                                "(colmap image_undistorter), or use one of {}",
                                where, model, known));
}

}  // namespace

const std::vector<ColmapModel>& colmap_models() {
  using Projection = Lens::Projection;
  constexpr auto perspective = Projection::perspective, fisheye = Projection::fisheye;
  static const std::vector<ColmapModel> models = {
      model_from("SIMPLE_PINHOLE", 0, perspective, "f cx cy"),
      model_from("PINHOLE", 1, perspective, "fx fy cx cy"),
      model_from("SIMPLE_RADIAL", 2, perspective, "f cx cy k1"),
      model_from("RADIAL", 3, perspective, "f cx cy k1 k2"),
      model_from("OPENCV", 4, perspective, "fx fy cx cy k1 k2 p1 p2"),
      model_from("FULL_OPENCV", 6, perspective, "fx fy cx cy k1 k2 p1 p2 k3 d1 d2 d3"),
      model_from("SIMPLE_RADIAL_FISHEYE", 8, fisheye, "f cx cy k1"),
      model_from("RADIAL_FISHEYE", 9, fisheye, "f cx cy k1 k2"),
      model_from("OPENCV_FISHEYE", 5, fisheye, "fx fy cx cy k1 k2 k3 k4"),
      model_from("THIN_PRISM_FISHEYE", 10, fisheye, "fx fy cx cy k1 k2 p1 p2 k3 k4 s1 s2"),
      model_from("FOV", 7, Projection::field_of_view, "fx fy cx cy shape"),
      model_from("SIMPLE_DIVISION", 12, Projection::division, "f cx cy shape"),
      model_from("DIVISION", 13, Projection::division, "fx fy cx cy shape"),
      model_from("SIMPLE_FISHEYE", 14, fisheye, "f cx cy"),
      model_from("FISHEYE", 15, fisheye, "fx fy cx cy")};
  return models;
}

const ColmapModel& colmap_model(const std::string& name, const std::string& where) {
  const auto found = std::ranges::find(colmap_models(), name, &ColmapModel::name);
  if (found == colmap_models().end()) refuse_model("'" + name + "'", where);
  return *found;
}

const ColmapModel& colmap_model(int id, const std::string& where) {
  const auto found = std::ranges::find(colmap_models(), id, &ColmapModel::id);
  if (found == colmap_models().end()) refuse_model(fmt::format("of number {}", id), where);
  return *found;
}

void set_colmap_parameters(PinholeCamera& camera, const ColmapModel& model,
                           std::span<const double> values) {
  camera.lens.projection = model.projection;
  for (std::size_t k = 0; k < model.parameters.size(); ++k)
    parameter_of(camera, model.parameters[k]) = values[k];
  if (model.parameters.front() == "f") camera.fy = camera.fx;
}

const ColmapModel& colmap_model_of(const PinholeCamera& camera, const std::string& where) {
  for (const ColmapModel& model : colmap_models()) {
    if (model.id >= 14 || model.projection != camera.lens.projection) continue;  // younger, simpler
    PinholeCamera back = camera;
    back.lens = {}, back.fx = back.fy = back.skew = 0;
    set_colmap_parameters(back, model, colmap_parameters(camera, model));
    if (back.lens == camera.lens && back.fx == camera.fx && back.fy == camera.fy && camera.skew == 0)
      return model;
  }
  throw Unsupported(fmt::format("{}: COLMAP has no model for its lens ({}{}): write our own JSON, or "
                                "undistort the picture",
                                where, lens_text(camera.lens), camera.skew == 0 ? "" : ", skew"));
}

std::vector<double> colmap_parameters(const PinholeCamera& camera, const ColmapModel& model) {
  PinholeCamera copy = camera;
  std::vector<double> values;
  for (const std::string& name : model.parameters) values.push_back(parameter_of(copy, name));
  return values;
}

}  // namespace mq
