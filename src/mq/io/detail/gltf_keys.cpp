#include "mq/io/detail/gltf_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"

namespace mq {

std::vector<double> GltfKeys::at(double time) const {
  const std::size_t key = before(time);
  std::vector<double> result(values.begin() + std::ptrdiff_t(key * size),
                             values.begin() + std::ptrdiff_t((key + 1) * size));
  if (steps || key + 1 >= times.size() || time <= times[key]) return result;
  const double share = (time - times[key]) / (times[key + 1] - times[key]);
  for (std::size_t k = 0; k < size; ++k)
    result[k] += share * (values[(key + 1) * size + k] - result[k]);
  return result;
}

std::size_t GltfKeys::before(double time) const {
  const auto next = std::ranges::upper_bound(times, time);
  return next == times.begin() ? 0 : std::size_t(next - times.begin()) - 1;
}

GltfKeys gltf_keys(const GltfFile& file, const Json& animation, const Json& channel,
                   const std::string& place, int components) {
  const Json& samplers = json_array(animation, "samplers", place);
  const std::int64_t id = json_count(channel, "sampler", -1, place);
  if (id < 0 || id >= std::ssize(samplers) || !samplers[std::size_t(id)].is_object())
    file.fail(place, fmt::format("its sampler {} is not there", id));
  const Json& sampler = samplers[std::size_t(id)];
  const std::string how = json_text_of(sampler, "interpolation");
  if (how == "CUBICSPLINE")
    throw Unsupported(place +
                      ": found an animation by splines (CUBICSPLINE), wanted LINEAR or STEP: "
                      "sample it where it was "
                      "made, frame by frame");
  GltfKeys found;
  found.steps = how == "STEP";
  found.times = file.values(json_count(sampler, "input", -1, place), {1}).values;
  found.values =
      file.values(json_count(sampler, "output", -1, place), {components == 0 ? 1 : components})
          .values;
  const bool whole = !found.times.empty() && found.values.size() % found.times.size() == 0;
  found.size = whole ? found.values.size() / found.times.size() : 0;
  if (found.size == 0 || (components > 0 && found.size != std::size_t(components)))
    file.fail(place,
              fmt::format("found {} values at {} times, wanted {} at each; write the file again",
                          found.values.size(), found.times.size(),
                          components > 0 ? std::to_string(components) : "as many"));
  for (std::size_t i = 0; i < found.times.size(); ++i)
    if (!std::isfinite(found.times[i]) || (i > 0 && !(found.times[i] > found.times[i - 1])))
      file.fail(place, fmt::format("time {} of its keys is {} s after {} s, wanted increasing "
                                   "ones; write the file again",
                                   i, found.times[i], i > 0 ? found.times[i - 1] : 0));
  for (std::size_t i = 0; i < found.values.size(); ++i)
    if (!std::isfinite(found.values[i]))
      file.fail(place,
                fmt::format("value {} of its keys is {}, wanted a finite one; write the file again",
                            i, found.values[i]));
  return found;
}

}  // namespace mq
