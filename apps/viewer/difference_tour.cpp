#include "difference_tour.h"

#include <fmt/format.h>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/draw/render.h"

namespace mq::view {
namespace {

/// Texels across what is looked at; what is nearer than half of that is seen already.
constexpr double texels_across = 96;

std::vector<Image<float>> images_of(const TextureSet& set) {
  const auto lock = set.lock();
  std::vector<Image<float>> images;
  for (int i = 0; i < set.size(); ++i) images.push_back(set.image(i));
  return images;
}

std::vector<const Image<float>*> borrowed(const std::vector<Image<float>>& images) {
  std::vector<const Image<float>*> pointers;
  for (const Image<float>& image : images) pointers.push_back(&image);
  return pointers;
}

}  // namespace

void DifferenceTour::next(const std::vector<double>& state) {
  require(session_.before != nullptr && session_.scene->atlas.has_value(),
          "the model has no textures, so none that differ");
  asked_ = true;
  if (state == state_ || background_.busy()) return;
  state_ = state;
  at_ = -1;
  result_ = session_.result;
  background_.start([this](const Progress& progress) { find(progress); });
}

/// On the other thread.
void DifferenceTour::find(const Progress& progress) {
  found_ = {};
  const std::vector<Image<float>> before = images_of(*session_.before),
                                  after = images_of(result_ ? *result_ : *session_.after);
  found_ = texture_difference(session_.scene->surface, *session_.scene->atlas, borrowed(before), borrowed(after),
                              {.apart = texels_across / 2}, progress);
}

std::optional<DifferenceTour::Stop> DifferenceTour::arrived(View::Up up) {
  if (background_.busy()) return {};
  result_.reset();
  if (!asked_) return {};
  asked_ = false;
  try {
    background_.rethrow();
  } catch (...) {
    state_.clear();
    throw;
  }
  require(!found_.places.empty(), "the textures do not differ anywhere on the model");
  at_ = (at_ + 1) % int(found_.places.size());
  const DifferencePlace& place = found_.places[std::size_t(at_)];
  const double extent = texels_across * session_.scene->atlas->texel_spacing();
  return Stop{place, sight_of(session_.scene->surface, *session_.rays, place.point, place.normal, extent, up).view};
}

std::string DifferenceTour::words() const {
  if (at_ < 0 || background_.busy()) return {};
  return fmt::format("place {} of {}: {} of 255 apart", at_ + 1, found_.places.size(),
                     plain(255 * found_.places[std::size_t(at_)].difference));
}

void DifferenceTour::stop() {
  background_.stop();
  background_.error();
  asked_ = false;
  at_ = -1;
  state_.clear();
  found_ = {};
  result_.reset();
}

}  // namespace mq::view
