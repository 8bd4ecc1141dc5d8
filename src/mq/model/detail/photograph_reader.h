#pragma once
/// Photographs read one after another, without those that cannot be.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mq/model/detail/photograph_light.h"
#include "mq/model/messages.h"
#include "mq/model/photograph_texture.h"

namespace mq {

class PhotographReader {
 public:
  /// The photographs and who is told of them must outlive it.
  PhotographReader(std::span<const Photograph> photographs, UnreadablePhotographs how, Messages& messages)
      : photographs_(photographs), how_(how), messages_(messages), left_out_(photographs.size()) {}

  /// Nothing where it cannot be read now or could not before, and is to be left out: the first time with a warning.
  /// Else throws what `PhotographLight::read` throws, with the way out.
  std::optional<PhotographLight> read(std::size_t view);

  /// As the photograph is, before it is aligned; as it was given where its head cannot be read and it is left out.
  PinholeCamera camera(std::size_t view);

  /// Why it was left out; empty where it was not.
  const std::string& why_left_out(std::size_t view) const { return left_out_[view]; }

 private:
  /// Or throws.
  void leave_out(std::size_t view, const std::string& why);

  std::span<const Photograph> photographs_;
  UnreadablePhotographs how_;
  Messages& messages_;
  std::vector<std::string> left_out_;
};

}  // namespace mq
