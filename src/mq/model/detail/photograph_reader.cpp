#include "mq/model/detail/photograph_reader.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/image_file.h"
#include "mq/io/photograph_file.h"

namespace mq {

void PhotographReader::leave_out(std::size_t view, const std::string& why) {
  if (how_ == UnreadablePhotographs::refuse)
    throw IoError(fmt::format("{}; or go on without it ({} skip)", why, option_name("missing")));
  left_out_[view] = why;
  messages_.warning(why + ": left out");
}

std::optional<PhotographLight> PhotographReader::read(std::size_t view) {
  if (!left_out_[view].empty()) return std::nullopt;
  try {
    return PhotographLight::read(photographs_[view]);
  } catch (const IoError& error) {
    leave_out(view, error.what());
    return std::nullopt;
  }
}

PinholeCamera PhotographReader::camera(std::size_t view) {
  const Photograph& photograph = photographs_[view];
  if (!left_out_[view].empty()) return photograph.camera;
  try {
    return fitted_camera(photograph, picture_info(photograph.picture)).camera;
  } catch (const IoError& error) {
    leave_out(view, error.what());
    return photograph.camera;
  }
}

}  // namespace mq
