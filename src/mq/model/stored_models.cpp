#include "mq/model/stored_models.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/model/stored_frames.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

constexpr double own_within = 0.02;  // of the diagonal
constexpr float added_later = 0.5F;  // grey

}  // namespace

StoreFigures store_figures(const EvolvingReader& reader, const std::vector<int>& damaged) {
  StoreFigures figures;
  EvolvingMesh sound;
  for (const StoredSegment& segment : reader.segments()) figures.bytes += segment.bytes;
  sound.segments.resize(reader.segments().size());
  for (int f = 0; f < int(reader.frames().size()); ++f) {
    const StoredFrame& frame = reader.frames()[std::size_t(f)];
    figures.bytes += frame.bytes;
    if (std::ranges::binary_search(damaged, f)) continue;
    EvolvingSegment& segment = sound.segments[std::size_t(frame.segment)];
    if (segment.triangles.empty()) segment = reader.segment(frame.segment);
    sound.frames.push_back({frame.number, frame.segment, {}});
  }
  const std::vector<Lifespan> spans = triangle_lifespans(sound);
  figures.triangles = int(spans.size());
  for (const Lifespan& span : spans) {
    figures.mean_lifespan += double(span.last - span.first + 1) / double(spans.size());
    figures.throughout += span.first == 0 && span.last + 1 == int(sound.frames.size());
  }
  return figures;
}

CarriedColours::CarriedColours(const Model& model, const EvolvingReader& reader) {
  const std::string word = option_name("colours");
  const Signal colours = vertex_colours(model);
  require(colours.cols() > 0,
          fmt::format("{}: {} wants colours at vertices or a texture, and it has neither",
                      model.path.string(), word));
  require(!reader.frames().empty(), fmt::format("{}: holds no whole frame to take {} from",
                                                reader.manifest().string(), word));
  const StoredFrame& first = reader.frames().front();
  const std::vector<int> ids = reader.segment(first.segment).vertex_ids;
  const std::vector<ClosestPoint> places = ClosestPointFinder(model.mesh)(reader.positions(0));
  const double near = own_within * bounding_box(model.mesh).diagonal();
  const auto far = std::ranges::count_if(
      places, [&](const ClosestPoint& place) { return place.squared_distance > near * near; });
  require(
      2 * far < std::ssize(places),
      fmt::format("{}: {} wants the first frame's own model, and of the {} vertices of "
                  "frame {} {} are farther than {:g} % of its diagonal from it",
                  model.path.string(), word, places.size(), first.number, far, 100 * own_within));
  for (std::size_t v = 0; v < ids.size(); ++v) {
    const Triangle& corners = model.mesh.triangles[std::size_t(places[v].triangle)];
    const Eigen::RowVectorXd colour =
        interpolate(places[v].barycentric, [&](int k) { return colours.row(corners[k]); });
    colours_[ids[v]] = colour.head<3>().cwiseMax(0).cwiseMin(1).cast<float>();
  }
}

VertexSignal CarriedColours::at(const EvolvingSegment& segment) const {
  VertexSignal signal;
  signal.channels = 3;
  for (const int id : segment.vertex_ids) {
    const auto found = colours_.find(id);
    for (int c = 0; c < 3; ++c)
      signal.values.push_back(found == colours_.end() ? added_later : found->second[c]);
  }
  return signal;
}

void write_stored_models(const EvolvingReader& reader, const std::vector<int>& frames,
                         const std::vector<std::filesystem::path>& paths, const StoredLook& look,
                         const Progress& progress) {
  require(paths.size() == frames.size(),
          fmt::format("{} paths are given for {} frames", paths.size(), frames.size()));
  numbers_of(reader, frames);  // refuses those that are not there
  int open = -1;
  EvolvingSegment segment;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const StoredFrame& frame = reader.frames()[std::size_t(frames[i])];
    if (frame.segment != open) segment = reader.segment(open = frame.segment);
    Model model;
    model.mesh = mesh_of(segment, reader.positions(frames[i]));
    for (Vector3& p : model.mesh.positions) p *= unit_in(paths[i], reader);
    if (look.colours) model.colors = look.colours->at(segment);
    if (Image<float> picture = look.picture ? look.picture(frames[i]) : Image<float>(); !picture.values().empty()) {
      Texture& texture = model.textures.emplace_back();
      texture.name = fs::path(paths[i]).replace_extension(".png").filename().string();
      texture.pixels = std::move(picture);
    }
    write_model(paths[i], model);
    progress.at(double(i + 1) / double(frames.size()));
  }
}

}  // namespace mq
