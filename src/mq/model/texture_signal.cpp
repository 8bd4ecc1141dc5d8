// Values of textures are decoded and encoded for the unknowns alone, texture by texture: what no
// chart reads is never looked at, and unknowns that did not change are never encoded.

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "mq/atlas/texel_grid.h"
#include "mq/atlas/texel_patches.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/fem/field_metric.h"
#include "mq/model/detail/same_row.h"
#include "mq/model/detail/texel_values.h"
#include "mq/model/kept_work.h"
#include "mq/model/model_signal.h"

namespace mq {
namespace {

/// How many channels all pictures have.
int common_channels(const Model& model) {
  int most = 0;
  for (const Texture& texture : model.textures) most = std::max(most, texture.pixels.channels());
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    const int channels = model.textures[i].pixels.channels();
    require(channels == most || lacks_alpha(channels, most),
            fmt::format("{}: has {} and another texture of the model {}: textures of one model are "
                        "processed together and must agree; convert one of them",
                        texture_file(model, i), counted(channels, "channel"), most));
  }
  return most;
}

/// The logarithm of light is a straight line below `log_threshold`: values there change by other
/// rules than the rest.
void warn_of_no_light(const Model& model, Messages& messages) {
  for (const Texture& texture : model.textures) {
    const auto negative =
        std::ranges::count_if(texture.pixels.values(), [](float v) { return v < 0; });
    if (negative > 0)
      messages.warning(fmt::format(
          "{}: {} of {} values are below 0, where light has no logarithm, and may end "
          "far from where they are: the logarithm is for light; take linear or stored values",
          texture.path.string(), negative, texture.pixels.values().size()));
  }
}

/// Texels of which the picture shows one of several values.
/// A few at the borders of charts are a note.
Defects shared_texels(const TexelCopies& copies, const std::vector<TextureSize>& pictures, int unknowns) {
  constexpr std::int64_t few = 1000;  // a thousandth
  std::vector<std::int64_t> ids;
  const TexelGrid grid(pictures);
  for (const Texels::Place& at : copies.shared()) ids.push_back(grid.texel(at.texture, at.x, at.y));
  Defects defects;
  add_defect(
      defects, "shared_texels", few * std::ssize(ids) < unknowns ? Defect::Severity::note : Defect::Severity::warning, "texel", ids,
      "texels that stand for several places of the surface: each "
      "place was worked out by itself, and the picture can show one of them, that of the chart "
      "which covers the texel's centre; a wider gutter or a larger texture parts them",
      "that stand for several places of the surface: the picture shows one of them");
  if (!defects.empty()) list_places(grid, std::move(ids), defects.back());
  return defects;
}

/// Mean of the colour channels: pictures of one model may have grey, colours and alpha as they like.
Image<float> brightness_of(const Image<float>& picture) {
  Image<float> grey(picture.width(), picture.height(), 1);
  const int colours = colour_channels(picture.channels());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto pixel = picture.pixel(x, y).first(std::size_t(colours));
      grey(x, y) = std::accumulate(pixel.begin(), pixel.end(), 0.0F) / float(colours);
    }
  return grey;
}

}  // namespace

TextureSignal::TextureSignal(const TexturedModel& model, const TextureSignalOptions& options,
                             Messages& messages, const Progress& progress)
    : model_(model), values_(options.values), depth_(options.depth) {
  require(model.atlas.has_value(),
          model.model.path.string() + ": has no texture coordinates, so no textures; the verb unwrap makes some");
  const bool reads = options.pictures == TextureSignalOptions::Pictures::read;
  if (reads) channels_ = common_channels(model.model);
  if (reads && !model.model.textures.empty() &&
      model.model.textures.front().meaning == TextureMeaning::normals)
    values_.meaning = ValueSpace::Meaning::normals;
  auto shared = options.shared;
  if (reads && values_.meaning == ValueSpace::Meaning::normals) shared = find_axes(shared, messages);
  Progress rest = progress;
  if (shared == TextureSignalOptions::SharedTexels::one_for_each) {
    apart_ = separate_overlaps(model.surface, *model.atlas, progress.step("lay charts apart", 0.2));
    rest = progress.step("texels", 0.8);
  }
  space_ = options.kept ? options.kept->space(model.surface, atlas(), options.space, rest)
                        : std::make_shared<const TexelSpace>(model.surface, atlas(), options.space, rest);
  if (apart_) copies_.emplace(model.surface, *apart_, *space_);
  const std::vector<Texels::Place>& places = space_->texels().places;
  for (int i = 0; i <= int(model.texture_sizes.size()); ++i)
    first_of_texture_.push_back(int(std::ranges::lower_bound(places, i, {}, &Texels::Place::texture) - places.begin()));
  if (!reads) return;
  find_frames();
  if (values_.space == ColourSpace::log) warn_of_no_light(model.model, messages);
}

Defects TextureSignal::defects() const {
  return copies_ ? shared_texels(*copies_, model_.texture_sizes, space_->size()) : space_->defects();
}

std::vector<int> TextureSignal::unknowns_at(const Texels::Place& texel) const {
  if (copies_) return copies_->meant(texel);
  const int unknown = space_->texels().find(texel);
  return unknown < 0 ? std::vector<int>() : std::vector{unknown};
}

/// The texel of the pictures that an unknown stands for.
Texels::Place TextureSignal::home(int unknown) const {
  return copies_ ? copies_->home(unknown) : space_->texels().places[std::size_t(unknown)];
}

UnknownRange TextureSignal::of_texture(std::size_t texture) const {
  return {first_of_texture_[texture], first_of_texture_[texture + 1]};
}

std::vector<Texels::Place> TextureSignal::texels() const {
  std::vector<Texels::Place> places;
  places.reserve(std::size_t(space_->size()));
  for (int k = 0; k < space_->size(); ++k) places.push_back(home(k));
  return places;
}

Signal TextureSignal::values_of(std::span<const Texture> textures) const {
  Signal values(space_->size(), channels_);
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const Image<float>& pixels = textures[i].pixels;
    const int channels = pixels.channels();
    require(channels == channels_ || lacks_alpha(channels, channels_),
            fmt::format("{}: has {}, and the textures of {} have {}; convert it",
                        textures[i].path.string(), counted(channels, "channel"),
                        model_.model.path.string(), channels_));
    const PlaceOfUnknown place = [&](int k) { return home(k); };
    if (!tangent_) {
      take_values(of_texture(i), place, textures[i], values_, values);
      continue;
    }
    for_each_block(of_texture(i), [&](std::span<const int> block) {
      Image<float> worked = decoded(stored_at(block, place, pixels), textures[i], values_);
      to_deviations(block, textures[i], worked, values);
    });
  }
  return values;
}

void TextureSignal::require_alike(std::span<const Texture> textures) const {
  const std::size_t own = model_.texture_sizes.size();
  require(textures.size() >= own,
          fmt::format("values of {} are put into {}", counted(int(own), "texture"), textures.size()));
  for (std::size_t i = 0; i < own; ++i) {
    const int width = model_.texture_sizes[i].width, height = model_.texture_sizes[i].height;
    const Image<float>& pixels = textures[i].pixels;
    require(pixels.width() == width && pixels.height() == height,
            fmt::format("{}: is {} x {}, and the values that are put into it are those of {} x {}",
                        textures[i].path.string(), pixels.width(), pixels.height(), width, height));
  }
}

void TextureSignal::put(const Signal& before, const Signal& after, Model& model) const {
  require_alike(model.textures);
  for (std::size_t i = 0; i < model_.texture_sizes.size(); ++i) {
    std::vector<int> changed;
    for (int k = of_texture(i).first; k < of_texture(i).last; ++k)
      if (!same_row(before, after, k) && (!copies_ || copies_->is_shown(k))) changed.push_back(k);
    Texture& texture = model.textures[i];
    if (tangent_)
      for_each_block(changed, [&](std::span<const int> block) { put_normals(block, before, after, texture); });
    else
      put_values(changed, [&](int k) { return home(k); }, after, values_, texture);
  }
}

void TextureSignal::replace(const Signal& values, Depth depth, Model& model) const {
  std::vector<Image<float>> pictures;
  for (const TextureSize& size : model_.texture_sizes)
    pictures.emplace_back(size.width, size.height, int(values.cols()));
  if (copies_)
    copies_->scatter(values, pictures);
  else
    space_->scatter(values, pictures);
  model.textures.resize(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    model.textures[i].pixels = std::move(pictures[i]);
    model.textures[i].format = {
        .depth = depth, .file_format = model.textures[i].format.file_format, .tags = nullptr};
  }
}

std::unique_ptr<SignalSpace> TextureSignal::space_across(std::span<const Vector3> field,
                                                         double kappa,
                                                         const Progress& progress) const {
  TexelSpaceOptions options;
  options.metrics = texel_metrics_across(model_.surface, atlas(), field, kappa);
  return std::make_unique<TexelSpace>(model_.surface, atlas(), options, progress);
}

Signal TextureSignal::gather(std::span<const Image<float>> pictures) const {
  Signal values(space_->size(), pictures.front().channels());
  parallel_for(space_->size(), [&](std::int64_t k) {
    const Texels::Place at = home(int(k));
    const auto pixel = pictures[std::size_t(at.texture)].pixel(at.x, at.y);
    for (int c = 0; c < values.cols(); ++c) values(k, c) = pixel[std::size_t(c)];
  });
  return values;
}

Vector TextureSignal::brightness() const {
  std::vector<Image<float>> pictures;
  for (const Texture& texture : model_.model.textures)
    pictures.push_back(brightness_of(texture.pixels));
  require(pictures.size() == model_.texture_sizes.size() &&
              std::ranges::none_of(pictures, &Image<float>::empty),
          "the model lacks a picture to take the gradient of");
  Vector values(space_->size());
  for (int k = 0; k < space_->size(); ++k) {
    const Texels::Place at = home(k);
    values[k] = pictures[std::size_t(at.texture)](at.x, at.y);
  }
  return values;
}

}  // namespace mq
