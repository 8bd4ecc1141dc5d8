// Normal maps: in which axes they are, and those in tangent space as one field d = n − N in the model's
// axes (detail/tangent_texels.h). n itself would be continuous too; but what smoothing does to it on a
// curved surface is mostly that to N, which is the mesh's and not the map's: a flat map would not come
// back flat.

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/model/detail/tangent_texels.h"
#include "mq/model/model_signal.h"

namespace mq {
namespace {

using SharedTexels = TextureSignalOptions::SharedTexels;

void refuse_overlaps(const TexturedModel& model) {
  throw InvalidInput(fmt::format(
      "{}: its normals are in tangent space, and charts lie on top of each other, so that one texel is "
      "another normal in each of them; this needs charts of their own: bake the map in object space "
      "onto such an atlas first",
      texture_file(model.model, 0)));
}

void say_oddities(const TexturedModel& model, const NormalMapShares& shares, Messages& messages) {
  constexpr double worth_a_word = 0.01;
  const std::string file = texture_file(model.model, 0);
  if (shares.below > worth_a_word)
    messages.warning(fmt::format("{}: {:.0f} % of its normals point below the surface (blue under the "
                                 "middle), as none do in tangent space; if it is in object space say "
                                 "{}",
                                 file, 100 * shares.below, option_name("normal_space") + " object"));
  if (shares.far_off > worth_a_word)
    messages.warning(fmt::format("{}: {:.0f} % of its normals are shorter or longer than 1 by more than "
                                 "a quarter: their directions count, and what changes comes back with "
                                 "unit length",
                                 file, 100 * shares.far_off));
}

Vector3 vector_of(const Signal& values, int row) { return values.row(row).head<3>().transpose(); }

}  // namespace

/// Finds the axes, and which shared texels that needs.
SharedTexels TextureSignal::find_axes(SharedTexels shared, Messages& messages) {
  const std::vector<Texture>& textures = model_.model.textures;
  if (textures.empty()) return shared;
  require(channels_ >= 3,
          fmt::format("{}: a normal map has x, y and z in three channels, and this picture has {}{}",
                      texture_file(model_.model, 0), counted(channels_, "channel"),
                      channels_ == 2 ? ": of x and y alone (BC5) write z = √(1 − x² − y²) as its third"
                                     : ""));
  const std::vector<Coverage> coverage = texel_coverage(model_.surface, *model_.atlas);
  const NormalMapShares shares = normal_map_shares(model_, coverage);
  const NormalAxes asked = values_.axes;
  values_.axes = found_axes(model_, asked, shares);
  if (asked == NormalAxes::object) return shared;
  require(!shares.without_z,
          fmt::format("{}: its blue is 0 everywhere, so the map has x and y alone (BC5): write "
                      "z = √(1 − x² − y²) there",
                      texture_file(model_.model, 0)));
  if (values_.axes == NormalAxes::object) return shared;
  if (asked == NormalAxes::as_found && textures.front().meaning != TextureMeaning::normals)
    messages.remark(fmt::format("{}: {:.0f} % of its normals point along z, so they are taken to be in "
                                "tangent space, green up; else say {}",
                                texture_file(model_.model, 0), 100 * shares.upright,
                                option_name("normal_space") + " object or directx"));
  say_oddities(model_, shares, messages);
  if (shared == SharedTexels::one_for_each || !charts_overlap(coverage)) return shared;
  if (shared == SharedTexels::one_unknown) refuse_overlaps(model_);
  return SharedTexels::one_for_each;
}

/// Once the space is there, and where normals are in tangent space.
void TextureSignal::find_frames() {
  const bool tangent = values_.meaning == ValueSpace::Meaning::normals &&
                       (values_.axes == NormalAxes::tangent ||
                        values_.axes == NormalAxes::tangent_down);
  if (!tangent || model_.model.textures.empty()) return;
  tangent_ = std::make_shared<const TangentTexels>(
      std::make_shared<const ShadingFrames>(model_, values_.axes),
      texel_places(model_.surface, atlas(), space_->texels(),
                   texel_coverage(model_.surface, atlas())));
}

/// Between two neighbouring codes that are, or will be, stored.
double TextureSignal::code_step(const Texture& texture) const {
  switch (depth_.value_or(texture.format.depth)) {
    case Depth::u8: return 1.0 / 255;
    case Depth::u16: return 1.0 / 65535;
    default: return 0;
  }
}

void TextureSignal::to_deviations(std::span<const int> block, const Texture& texture,
                                  Image<float>& worked, Signal& values) const {
  const double half_step = half_vector_step(texture.format.depth);
  for (int n = 0; n < worked.width(); ++n) {
    const int k = block[std::size_t(n)];
    const Vector3 mapped(worked(n, 0, 0), worked(n, 0, 1), worked(n, 0, 2));
    values.row(k).head<3>() = tangent_->deviation(k, mapped, half_step).transpose();
    for (int c = 3; c < channels_; ++c)
      values(k, c) = c < worked.channels() ? double(worked(n, 0, c)) : 1.0;
  }
}

void TextureSignal::put_normals(std::span<const int> block, const Signal& before,
                                const Signal& after, Texture& texture) const {
  constexpr double rounding = 5e-7;  // of codes; 10⁻⁶ of vectors
  const double enough = std::max(rounding, code_step(texture) / 2 * (1 + 1e-3));
  for (const int k : block) {
    const Texels::Place at = home(k);
    const auto pixel = texture.pixels.pixel(at.x, at.y);
    for (int c = 3; c < int(pixel.size()); ++c)
      if (before(k, c) != after(k, c)) pixel[std::size_t(c)] = float(after(k, c));
    const Vector3 was = tangent_->mapped(k, vector_of(before, k));
    const Vector3 is = tangent_->mapped(k, vector_of(after, k));
    if ((is - was).cwiseAbs().maxCoeff() / 2 <= enough) continue;
    for (int c = 0; c < 3; ++c) pixel[std::size_t(c)] = float((is[c] + 1) / 2);
  }
}

const ShadingFrames* TextureSignal::shading_frames() const {
  return tangent_ ? &tangent_->frames() : nullptr;
}

Signal TextureSignal::shading_normals() const {
  Signal normals = Signal::Zero(space_->size(), 3);
  if (tangent_)
    parallel_for(space_->size(), [&](std::int64_t k) {
      normals.row(k) = tangent_->shading_normal(int(k)).transpose();
    });
  return normals;
}

}  // namespace mq
