#include "mq/model/detail/photograph_records.h"

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/file_print.h"

namespace mq {
namespace {

std::span<const double> numbers_of(const Signal& signal) {
  return {signal.data(), std::size_t(signal.size())};
}

void add_signal(const Signal& signal, StoredWriter& to) {
  to.add(std::int64_t(signal.rows())), to.add(std::int64_t(signal.cols()));
  to.add(numbers_of(signal));
}

Signal read_signal(StoredReader& from) {
  const auto rows = from.one<std::int64_t>(), columns = from.one<std::int64_t>();
  const std::vector<double> values = from.list<double>();
  Signal signal(rows, columns);
  std::ranges::copy(values, signal.data());
  return signal;
}

void add_camera(const PinholeCamera& camera, StoredWriter& to) {
  to.add(std::vector<int>{camera.width, camera.height, int(camera.lens.projection)});
  std::vector<double> numbers{camera.fx, camera.fy, camera.cx, camera.cy, camera.skew};
  for (const LensNumber& number : lens_numbers()) numbers.push_back(camera.lens.*number.value);
  numbers.insert(numbers.end(), camera.rotation.data(), camera.rotation.data() + camera.rotation.size());
  numbers.insert(numbers.end(), camera.translation.data(), camera.translation.data() + camera.translation.size());
  to.add(numbers);
}

void add_places(std::span<const Vector3> places, StoredWriter& to) {
  to.add(std::span<const double>(places.empty() ? nullptr : places[0].data(), 3 * places.size()));
}

void add_correction(const Correction& correction, StoredWriter& to) {
  to.add(correction.columns), to.add(correction.rows);
  to.add(std::span<const double>(correction.empty() ? nullptr : correction.offsets[0].data(),
                                 2 * correction.offsets.size()));
}

void add_photograph(const Photograph& photograph, StoredWriter& to) {
  std::error_code error;
  to.add(photograph.picture.string());
  to.add(std::uint64_t(std::filesystem::file_size(photograph.picture, error)));
  const auto written = std::filesystem::last_write_time(photograph.picture, error);
  if (error) throw IoError(photograph.picture.string() + ": cannot be read: " + error.message());
  to.add(std::int64_t(written.time_since_epoch().count()));
  add_camera(photograph.camera, to);
}

}  // namespace

std::uint64_t print_of_setup(const Mesh& mesh, std::span<const Vector3> places, const TextureSignal& signal,
                             const PhotographTextureOptions& options) {
  StoredWriter all;
  all.add(std::string(MARQUETRY_VERSION));
  all.add(std::uint64_t(sizeof(Observations::OfPatch)));
  add_places(mesh.positions, all);
  all.add(std::span<const int>(mesh.triangles.empty() ? nullptr : mesh.triangles[0].data(), 3 * mesh.triangles.size()));
  add_places(places, all);
  all.add(std::vector<int>{signal.channels(), int(signal.value_space().space), options.align, int(options.exposure),
                           options.reject_outliers, options.patch});
  const PhotographOptions& projection = options.projection;
  all.add(std::vector<double>{projection.steepest, projection.bias, projection.outline, projection.doubtful,
                              projection.border, options.choice.smoothness, options.choice.rejected, options.choice.print,
                              options.rejection.least, options.rejection.times});
  return fingerprint(all.bytes);
}

std::uint64_t print_of_photographs(std::span<const Photograph> photographs) {
  StoredWriter all;
  for (const Photograph& photograph : photographs) add_photograph(photograph, all);
  return fingerprint(all.bytes);
}

std::uint64_t print_of_aligned(const Photograph& photograph, const PinholeCamera& camera) {
  StoredWriter all;
  add_photograph(photograph, all);
  add_camera(camera, all);
  add_correction(camera.correction, all);
  return fingerprint(all.bytes);
}

StoredBytes record_to_align(const AlignedPhotograph& photograph, std::span<const float> details) {
  StoredWriter record;
  record.add(photograph.grey.width()), record.add(photograph.grey.height());
  record.add(photograph.grey.values());
  record.add(photograph.places), record.add(photograph.weights), record.add(details);
  return record.bytes;
}

void read_to_align(std::span<const std::byte> record, AlignedPhotograph& photograph, std::vector<float>& details) {
  StoredReader from(record);
  const int width = from.one<int>(), height = from.one<int>();
  photograph.grey = Image<float>(width, height, 1);
  std::ranges::copy(from.list<float>(), photograph.grey.values().begin());
  photograph.places = from.list<int>(), photograph.weights = from.list<float>();
  details = from.list<float>();
}

StoredBytes record_of_poses(std::span<const PinholeCamera> cameras, std::span<const double> moved) {
  StoredWriter record;
  record.add(moved);
  for (const PinholeCamera& camera : cameras) {
    add_camera(camera, record);
    add_correction(camera.correction, record);
  }
  return record.bytes;
}

void read_poses(std::span<const std::byte> record, std::span<PinholeCamera> cameras, std::span<double> moved) {
  StoredReader from(record);
  std::ranges::copy(from.list<double>(), moved.begin());
  for (PinholeCamera& camera : cameras) {
    from.list<int>();
    const std::vector<double> numbers = from.list<double>();
    const double* pose = numbers.data() + numbers.size() - 12;
    camera.rotation = Eigen::Map<const Eigen::Matrix3d>(pose);
    camera.translation = Eigen::Map<const Vector3>(pose + 9);
    camera.correction.columns = from.one<int>(), camera.correction.rows = from.one<int>();
    const std::vector<double> offsets = from.list<double>();
    camera.correction.offsets.clear();
    for (std::size_t k = 0; k + 1 < offsets.size(); k += 2)
      camera.correction.offsets.emplace_back(offsets[k], offsets[k + 1]);
  }
}

StoredBytes record_of_colours(std::uint64_t asked, const TakenColours& colours) {
  StoredWriter record;
  record.add(asked);
  add_signal(colours.own, record), add_signal(colours.beyond.values, record);
  record.add(colours.beyond.confidence);
  return record.bytes;
}

bool read_colours(std::span<const std::byte> record, std::uint64_t asked, TakenColours& colours) {
  StoredReader from(record);
  if (from.one<std::uint64_t>() != asked) return false;
  colours.own = read_signal(from), colours.beyond.values = read_signal(from);
  colours.beyond.confidence = from.list<double>();
  return true;
}

}  // namespace mq
