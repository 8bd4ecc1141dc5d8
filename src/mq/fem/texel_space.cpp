#include "mq/fem/texel_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "mq/atlas/overlap_depth.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {

TexelSpace::TexelSpace(const Surface& surface, const Atlas& atlas, const TexelSpaceOptions& options,
                       const Progress& progress) {
  Defects defects = deep_overlaps(surface, atlas);
  defects.insert(defects.begin(), atlas.defects.begin(), atlas.defects.end());
  if (refused(defects)) {
    std::string message = "the atlas cannot be worked with:";
    for (const Defect& d : defects)
      if (d.severity == Defect::Severity::refused)
        message += fmt::format(
            " {} {}s ({}{}): {};", d.count, d.element,
            fmt::join(d.ids.begin(), d.ids.begin() + std::min<std::size_t>(d.ids.size(), 5), ", "),
            d.count > 5 ? ", ..." : "", d.message);
    message.pop_back();
    throw InvalidInput(message);
  }
  data_ = std::make_unique<Data>(surface, atlas);
  data_->integrate(options, progress);
  data_->number_texels();
  require(!data_->texels.places.empty(),
          "no triangle has texture coordinates and area: there is nothing to work on");
  progress.at(0.75);
  data_->find_parts();
  progress.at(0.85);
  data_->place_texels();
  data_->find_weak();
  data_->list_defects();
  progress.at(1);
}

TexelSpace::~TexelSpace() = default;
TexelSpace::TexelSpace(TexelSpace&&) noexcept = default;

int TexelSpace::size() const {
  return data_->packed_places.empty() ? data_->texels.size() : data_->packed_places.back().unknown;
}
const Texels& TexelSpace::texels() const { return data_->texels; }
const Defects& TexelSpace::defects() const { return data_->defects; }

SurfaceScale TexelSpace::scale() const {
  return {data_->atlas.surface_area, data_->atlas.texel_spacing()};
}

Vector TexelSpace::lumped_mass() const {
  const Data& d = *data_;
  d.require_integrals();
  Vector mass = Vector::Zero(size());
  parallel_for(size(), [&](std::int64_t i) {
    d.for_each_coupling(int(i), {}, [&](int, double m, double) { mass[i] += m; });
  });
  return mass;
}

Signal TexelSpace::stiffness_times(const Signal& psi, std::span<const double> beta) const {
  return stiffness_rows({}, psi, beta);
}

Signal TexelSpace::stiffness_rows(std::span<const int> rows, const Signal& psi,
                                  std::span<const double> beta) const {
  require(psi.rows() == size(), "one row per texel is needed");
  require(beta.empty() || std::ssize(beta) == size(), "one modulation per texel is needed");
  const Data& d = *data_;
  const auto mean_beta = [&](const std::array<int, 4>& corners) {
    if (beta.empty()) return 1.0;
    double sum = 0;
    for (int c : corners) sum += beta[d.unknown[c]];
    return sum / 4;
  };
  // Of a seam block: the corners of the cell whose pieces it holds.
  const auto block_beta = [&](const SeamBlocks::Block& block) {
    if (beta.empty()) return 1.0;
    if (block.cell < 0) {
      double sum = 0;
      for (int k = 0; k < block.count; ++k) sum += beta[d.cells.seams.texels[block.first + k]];
      return sum / block.count;
    }
    return mean_beta(d.corners_of(block.cell));
  };
  return d.stiffness_product(
      rows, psi, [&](int, const std::array<int, 4>& corners) { return mean_beta(corners); },
      [&](int block) { return block_beta(d.cells.seams.blocks[block]); });
}

Signal TexelSpace::gather(std::span<const Image<float>> pictures) const {
  const Data& d = *data_;
  d.require_places();
  require(std::ssize(pictures) == d.grid.texture_count(),
          fmt::format("{} pictures for {} textures: give one each", pictures.size(),
                      d.grid.texture_count()));
  const int channels = pictures.front().channels();
  for (int k = 0; k < d.grid.texture_count(); ++k) {
    const TextureSize& size = d.grid.texture(k);
    if (pictures[k].width() != size.width || pictures[k].height() != size.height ||
        pictures[k].channels() != channels)
      throw InvalidInput(
          fmt::format("picture {} is {} x {} with {} channels where {} x {} with {} was wanted", k,
                      pictures[k].width(), pictures[k].height(), pictures[k].channels(), size.width,
                      size.height, channels));
  }
  Signal signal(size(), channels);
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < channels; ++c) signal(i, c) = pixel[c];
  });
  return signal;
}

void TexelSpace::scatter(const Signal& signal, std::span<Image<float>> pictures) const {
  const Data& d = *data_;
  d.require_places();
  require(signal.rows() == size() && std::ssize(pictures) == d.grid.texture_count() &&
              signal.cols() == pictures.front().channels(),
          "a signal of this space and the pictures it was gathered from are needed");
  parallel_for(size(), [&](std::int64_t i) {
    const Texels::Place& at = d.texels.places[i];
    const auto pixel = pictures[at.texture].pixel(at.x, at.y);
    for (int c = 0; c < signal.cols(); ++c) pixel[c] = float(signal(i, c));
  });
}

std::int64_t TexelSpace::bytes() const {
  const Data& d = *data_;
  const auto size = [](const auto& v) { return std::int64_t(v.capacity() * sizeof(v[0])); };
  return size(d.metrics) + size(d.cells.kind) + size(d.cells.cut) + size(d.cells.info) +
         size(d.cells.whole) + size(d.cells.seams.blocks) + size(d.cells.seams.texels) +
         size(d.cells.seams.mass) + size(d.cells.seams.stiffness) + size(d.cells.seams.means) + size(d.texels.places) +
         size(d.texels.positions) + size(d.texels.chart) + size(d.texels.interior) +
         size(d.unknown) + size(d.block_offsets) + size(d.parts) + size(d.packed_places);
}

}  // namespace mq
